"""Slots and sensors."""

import numpy as np
import pytest

from sjasim.choreography.layout import layout
from sjasim.config import RoomConfig, SensorConfig
from sjasim.errors import ConfigError


def laid(name="square", group=3, **room):
    return layout(name, group, RoomConfig(**room), SensorConfig())


@pytest.mark.parametrize("name", ["square", "rows"])
def test_four_bodies_on_the_corners_of_a_square(name):
    place = laid(name)
    slots = np.concatenate([place.dancers, [place.robot]])
    assert np.allclose(slots.mean(axis=0), 0.0)
    assert np.allclose(np.linalg.norm(slots, axis=1), 0.7 * np.sqrt(2))
    gaps = np.linalg.norm(slots[:, None] - slots[None], axis=-1)
    assert np.allclose(np.sort(gaps, axis=1)[:, 1:3], 1.4)


def test_the_turned_square_lets_every_sensor_see_four_bodies_apart():
    place = laid()
    slots = np.concatenate([place.dancers, [place.robot]])
    for mount in place.mounts:
        offset = slots - mount.position[:2]
        angles = np.sort(np.arctan2(offset @ mount.world_from_sensor[:2, 0], offset @ mount.world_from_sensor[:2, 2]))
        assert np.degrees(np.diff(angles)).min() > 5.0
        assert np.degrees(np.abs(angles)).max() < 35.3


def test_sensors_stand_at_the_cardinal_points_level_and_look_at_the_centre():
    for mount, bearing in zip(laid().mounts, ([0, 1], [-1, 0], [0, -1], [1, 0]), strict=True):
        assert np.allclose(mount.position, [3.4 * bearing[0], 3.4 * bearing[1], 0.91])
        rotation = mount.world_from_sensor
        assert np.allclose(rotation.T @ rotation, np.eye(3))
        assert np.linalg.det(rotation) == pytest.approx(1.0)
        assert np.allclose(rotation[:, 1], [0, 0, 1])
        assert np.allclose(rotation[:, 2], [-bearing[0], -bearing[1], 0])
    assert [mount.name for mount in laid().mounts] == ["north", "west", "south", "east"]


@pytest.mark.parametrize(
    ("name", "room", "says"),
    [
        ("square", {"sensor_distance_m": 6.0}, "room.sensor_distance_m"),
        ("square", {"sensor_distance_m": 1.2}, "0.5 to 4.5 m"),
        ("custom", {}, "4 slots"),
        ("custom", {"slots_m": ((0, 0), (0.2, 0), (1, 0), (0, 1))}, "at least .6 m"),
    ],
)
def test_what_does_not_fit_is_refused(name, room, says):
    with pytest.raises(ConfigError, match=says):
        laid(name, **room)


def test_larger_groups_bring_their_own_slots():
    with pytest.raises(ConfigError, match="custom"):
        laid(group=4)
    slots = ((0.8, 0.8), (-0.8, 0.8), (0.8, -0.8), (-0.8, -0.8), (0.0, 0.0))
    place = laid("custom", group=4, slots_m=slots)
    assert place.dancers.shape == (4, 2)
    assert place.robot.tolist() == [0.0, 0.0]
