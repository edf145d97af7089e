"""Layouts: everybody inside every sensor's range, apart from one another, for groups of one to eight."""

from __future__ import annotations

import numpy as np
import pytest

from sjasim.choreography.layout import layout
from sjasim.config import DanceConfig, SceneConfig, SessionConfig
from sjasim.core.errors import ConfigError


def room(name: str, group: int, **options):
    return layout(SessionConfig(layout=name, dancers=group, sensing="joints", scene=SceneConfig(**options)))


def all_slots(place) -> np.ndarray:
    return np.concatenate([place.dancers, place.robot[None]])


@pytest.mark.parametrize("group", range(1, 9))
@pytest.mark.parametrize("name", ["square", "rows"])
def test_groups_of_every_size_have_room(name, group):
    place = room(name, group)
    slots = all_slots(place)
    assert place.dancers.shape == (group, 2)
    gaps = np.linalg.norm(slots[:, None] - slots[None], axis=2) + 9 * np.eye(len(slots))
    assert gaps.min() >= 0.7
    for mount in place.mounts:
        depth = (np.c_[slots, np.zeros(len(slots))] - mount.position) @ mount.world_from_sensor[:, 2]
        assert depth.min() - 0.5 >= 0.5
        assert depth.max() <= 4.5


@pytest.mark.parametrize("name", ["square", "rows"])
def test_small_groups_keep_their_corners(name):
    three = room(name, 3)
    corners = np.array([[0.7, 0.7], [-0.7, 0.7], [0.7, -0.7]])
    cos, sin = (np.cos(np.radians(31.5)), np.sin(np.radians(31.5))) if name == "square" else (1.0, 0.0)
    assert three.dancers == pytest.approx(corners @ np.array([[cos, sin], [-sin, cos]]))
    for group in (1, 2):
        assert room(name, group).dancers == pytest.approx(three.dancers[:group])
        assert room(name, group).robot == pytest.approx(three.robot)


def test_larger_groups_stand_in_a_ring_around_the_centre():
    slots = all_slots(room("square", 6))
    assert slots.mean(axis=0) == pytest.approx([0, 0], abs=1e-12)
    assert np.ptp(np.linalg.norm(slots, axis=1)) < 1e-12


def test_larger_groups_stand_in_aligned_rows():
    slots = all_slots(room("rows", 8))
    assert len(np.unique(slots[:, 0].round(6))) == 3
    assert len(np.unique(slots[:, 1].round(6))) == 3


@pytest.mark.parametrize("group", [0, 9])
def test_a_group_of_none_or_too_many_is_refused(group):
    with pytest.raises(ConfigError, match="1 to 8"):
        room("square", group)


def test_own_slots_must_be_as_many_as_there_are():
    with pytest.raises(ConfigError, match="3 slots"):
        room("custom", 2, slots_m=((0.0, 0.0), (1.0, 0.0)))


def test_slots_too_close_or_out_of_range_are_refused():
    with pytest.raises(ConfigError, match="apart"):
        room("custom", 1, slots_m=((0.0, 0.0), (0.3, 0.0)))
    with pytest.raises(ConfigError, match="sensor"):
        room("square", 3, side_m=3.0)


def test_slots_beside_the_field_of_view_are_refused():
    with pytest.raises(ConfigError, match=r"within 35\.3 degrees of the north sensor's axis.*not 37\.2"):
        room("square", 3, sensor_distance_m=2.0)


def test_the_active_sensor_sees_the_default_square_from_1_94_to_4_36_m():
    place = room("square", 3)
    slots = np.concatenate([place.dancers, [place.robot]])
    for mount in place.mounts:
        depth = (np.c_[slots, np.zeros(4)] - mount.position) @ mount.world_from_sensor[:, 2]
        assert depth.min() - DanceConfig().step_m == pytest.approx(1.94, abs=0.005)
        assert depth.max() == pytest.approx(4.36, abs=0.005)


def test_own_slots_out_of_range_name_their_field():
    far = SceneConfig(slots_m=((9, 9), (1, 1), (0, 1), (-1, 0)))
    with pytest.raises(ConfigError, match=r"scene\.slots_m"):
        layout(SessionConfig(layout="custom", scene=far))


@pytest.mark.parametrize("name", ["square", "rows"])
def test_four_bodies_on_the_corners_of_a_square(name):
    place = room(name, 3)
    slots = np.concatenate([place.dancers, [place.robot]])
    assert np.allclose(slots.mean(axis=0), 0.0)
    assert np.allclose(np.linalg.norm(slots, axis=1), 0.7 * np.sqrt(2))
    gaps = np.linalg.norm(slots[:, None] - slots[None], axis=-1)
    assert np.allclose(np.sort(gaps, axis=1)[:, 1:3], 1.4)


def test_the_turned_square_lets_every_sensor_see_four_bodies_apart():
    place = room("square", 3)
    slots = np.concatenate([place.dancers, [place.robot]])
    for mount in place.mounts:
        offset = slots - mount.position[:2]
        angles = np.sort(np.arctan2(offset @ mount.world_from_sensor[:2, 0], offset @ mount.world_from_sensor[:2, 2]))
        assert np.degrees(np.diff(angles)).min() > 5.0
        assert np.degrees(np.abs(angles)).max() < 35.3


def test_sensors_stand_at_the_cardinal_points_level_and_look_at_the_centre():
    for mount, bearing in zip(room("square", 3).mounts, ([0, 1], [-1, 0], [0, -1], [1, 0]), strict=True):
        assert np.allclose(mount.position, [3.4 * bearing[0], 3.4 * bearing[1], 0.91])
        rotation = mount.world_from_sensor
        assert np.allclose(rotation.T @ rotation, np.eye(3))
        assert np.linalg.det(rotation) == pytest.approx(1.0)
        assert np.allclose(rotation[:, 1], [0, 0, 1])
        assert np.allclose(rotation[:, 2], [-bearing[0], -bearing[1], 0])
    assert [mount.name for mount in room("square", 3).mounts] == ["north", "west", "south", "east"]
