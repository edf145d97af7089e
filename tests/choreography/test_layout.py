"""Tests of floor layouts: distances and visibility for one to eight dancers."""

from __future__ import annotations

import numpy as np
import pytest

from sjasim.choreography.layout import layout
from sjasim.config import DanceConfig, SceneConfig, SessionConfig
from sjasim.core.errors import ConfigError


def make_layout(name: str, dancers: int, **options):
    """The layout of a name for a number of dancers, with options of the scene."""
    return layout(SessionConfig(layout=name, dancers=dancers, sensing="joints", scene=SceneConfig(**options)))


def all_slots(place) -> np.ndarray:
    """(D + 1, 2) slots of the dancers and the robot [m]."""
    return np.concatenate([place.dancers, place.robot[None]])


@pytest.mark.parametrize("dancers", range(1, 9))
@pytest.mark.parametrize("name", ["square", "rows"])
def test_groups_of_every_size_stand_apart_and_in_range(name, dancers):
    place = make_layout(name, dancers)
    slots = all_slots(place)
    assert place.dancers.shape == (dancers, 2)
    gaps = np.linalg.norm(slots[:, None] - slots[None], axis=2) + 9 * np.eye(len(slots))
    assert gaps.min() >= 0.7

    assert len(place.mounts) == 4
    for mount in place.mounts:
        depth = (np.c_[slots, np.zeros(len(slots))] - mount.position) @ mount.world_from_sensor[:, 2]
        assert depth.min() - 0.5 >= 0.5
        assert depth.max() <= 4.5


@pytest.mark.parametrize("name", ["square", "rows"])
def test_small_groups_stand_on_corners_of_the_square(name):
    three = make_layout(name, 3)
    corners = np.array([[0.7, 0.7], [-0.7, 0.7], [0.7, -0.7]])
    cos, sin = (np.cos(np.radians(31.5)), np.sin(np.radians(31.5))) if name == "square" else (1.0, 0.0)

    assert three.dancers == pytest.approx(corners @ np.array([[cos, sin], [-sin, cos]]))
    for dancers in (1, 2):
        assert make_layout(name, dancers).dancers == pytest.approx(three.dancers[:dancers])
        assert make_layout(name, dancers).robot == pytest.approx(three.robot)


def test_larger_groups_stand_in_a_ring_around_the_centre():
    slots = all_slots(make_layout("square", 6))
    assert slots.mean(axis=0) == pytest.approx([0, 0], abs=1e-12)
    assert np.ptp(np.linalg.norm(slots, axis=1)) < 1e-12


def test_larger_groups_stand_in_aligned_rows():
    slots = all_slots(make_layout("rows", 8))
    assert len(np.unique(slots[:, 0].round(6))) == 3
    assert len(np.unique(slots[:, 1].round(6))) == 3


@pytest.mark.parametrize("dancers", [0, 9])
def test_a_group_outside_one_to_eight_is_refused(dancers):
    with pytest.raises(ConfigError, match="1 to 8"):
        make_layout("square", dancers)


def test_custom_slots_must_match_the_number_of_dancers():
    with pytest.raises(ConfigError, match="3 slots"):
        make_layout("custom", 2, slots_m=((0.0, 0.0), (1.0, 0.0)))


def test_slots_too_close_or_out_of_range_are_refused():
    with pytest.raises(ConfigError, match="apart"):
        make_layout("custom", 1, slots_m=((0.0, 0.0), (0.3, 0.0)))
    with pytest.raises(ConfigError, match="sensor"):
        make_layout("square", 3, side_m=3.0)


def test_slots_beside_the_field_of_view_are_refused():
    with pytest.raises(ConfigError, match=r"within 35\.3 degrees of the north sensor's axis.*not 37\.2"):
        make_layout("square", 3, sensor_distance_m=2.0)


def test_the_active_sensor_sees_the_default_square_from_1_94_to_4_36_m():
    place = make_layout("square", 3)
    slots = np.concatenate([place.dancers, [place.robot]])
    for mount in place.mounts:
        depth = (np.c_[slots, np.zeros(4)] - mount.position) @ mount.world_from_sensor[:, 2]
        assert depth.min() - DanceConfig().step_m == pytest.approx(1.94, abs=0.005)
        assert depth.max() == pytest.approx(4.36, abs=0.005)


def test_an_error_about_custom_slots_names_their_field():
    far = SceneConfig(slots_m=((9, 9), (1, 1), (0, 1), (-1, 0)))
    with pytest.raises(ConfigError, match=r"scene\.slots_m"):
        layout(SessionConfig(layout="custom", scene=far))


@pytest.mark.parametrize("name", ["square", "rows"])
def test_four_bodies_on_the_corners_of_a_square(name):
    place = make_layout(name, 3)
    slots = np.concatenate([place.dancers, [place.robot]])
    assert np.allclose(slots.mean(axis=0), 0.0)
    assert np.allclose(np.linalg.norm(slots, axis=1), 0.7 * np.sqrt(2))
    gaps = np.linalg.norm(slots[:, None] - slots[None], axis=-1)
    assert np.allclose(np.sort(gaps, axis=1)[:, 1:3], 1.4)


def test_four_bodies_have_separate_bearings_for_every_sensor():
    place = make_layout("square", 3)
    slots = np.concatenate([place.dancers, [place.robot]])
    for mount in place.mounts:
        offset = slots - mount.position[:2]
        angles = np.sort(np.arctan2(offset @ mount.world_from_sensor[:2, 0], offset @ mount.world_from_sensor[:2, 2]))
        assert np.degrees(np.diff(angles)).min() > 5.0
        assert np.degrees(np.abs(angles)).max() < 35.3


def test_sensors_stand_at_the_cardinal_points_and_face_the_centre():
    for mount, bearing in zip(make_layout("square", 3).mounts, ([0, 1], [-1, 0], [0, -1], [1, 0]), strict=True):
        assert np.allclose(mount.position, [3.4 * bearing[0], 3.4 * bearing[1], 0.91])

        rotation = mount.world_from_sensor
        assert np.allclose(rotation.T @ rotation, np.eye(3))
        assert np.linalg.det(rotation) == pytest.approx(1.0)
        assert np.allclose(rotation[:, 1], [0, 0, 1])
        assert np.allclose(rotation[:, 2], [-bearing[0], -bearing[1], 0])

    assert [mount.name for mount in make_layout("square", 3).mounts] == ["north", "west", "south", "east"]
