"""Persons' pixels: floor away, points to those who are near, strangers and low things found."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sjasim.assets.names import JOINTS
from sjasim.sensors.depth_camera import Intrinsics
from sjasim.sensors.skeleton import segmentation
from sjasim.sensors.skeleton.segmentation import LOW_OBJECT, UNASSIGNED, Foreground

PINHOLE = Intrinsics.from_field_of_view(256, math.radians(70.6), math.radians(60.0))
HEIGHT_M = 0.91
NO_LOW = np.full(2, np.nan)


def image(*panels: tuple[float, float, float, float]) -> np.ndarray:
    """A floor and upright panels: x, z, width, top [m], each .05 m off the floor."""
    row, column = np.mgrid[: PINHOLE.height, : PINHOLE.width]
    x = (column - (PINHOLE.width - 1) / 2) / PINHOLE.fx
    y = ((PINHOLE.height - 1) / 2 - row) / PINHOLE.fy
    with np.errstate(divide="ignore"):
        depth = np.where(y < 0, -HEIGHT_M / y, np.inf)
    depth[depth > 4.5] = 0.0
    for at, z, width, top in sorted(panels, key=lambda panel: -panel[1]):
        up = HEIGHT_M + y * z
        depth[(np.abs(x * z - at) < width / 2) & (up > 0.05) & (up < top)] = z
    return np.rint(1000 * depth).astype(np.uint16)


def seen(*panels: tuple[float, float, float, float]) -> Foreground:
    scene = Foreground.allocate(PINHOLE)
    segmentation.extract_foreground(image(*panels), PINHOLE, HEIGHT_M, scene)
    return scene


PER_PIXEL = 1.0 / (PINHOLE.fx * PINHOLE.fy)


def share(scene: Foreground, places: list[tuple[float, float]], low: np.ndarray = NO_LOW) -> np.ndarray:
    joints = np.zeros((len(places), len(JOINTS), 3))
    joints[:, :, 1] = np.linspace(0.1, 1.7, len(JOINTS))
    joints[:, :, [0, 2]] = np.array(places).reshape(-1, 1, 2)
    segmentation.assign_owners(scene, np.array(places).reshape(-1, 2), joints, low)
    return scene.owner[: scene.count]


def test_the_floor_is_removed_and_points_lie_where_they_are():
    assert seen().count == 0
    scene = seen((0.5, 3.0, 0.4, 1.7))
    points = scene.point[: scene.count]
    assert points[:, 2] == pytest.approx(3.0)
    assert points[:, 0].min() == pytest.approx(0.3, abs=0.02)
    assert points[:, 0].max() == pytest.approx(0.7, abs=0.02)
    assert points[:, 1].max() == pytest.approx(1.7, abs=0.02)


def test_points_go_to_the_person_they_are_near():
    scene = seen((-0.5, 3.0, 0.4, 1.7), (0.5, 2.5, 0.4, 1.7))
    owner = share(scene, [(-0.5, 3.1), (0.5, 2.6)])
    left = scene.point[: scene.count, 0] < 0
    assert set(owner[left]) == {0}
    assert set(owner[~left]) == {1}


def test_two_who_pass_each_other_keep_their_points():
    scene = seen((0.0, 3.2, 0.4, 1.8), (0.3, 2.7, 0.4, 1.6))
    owner = share(scene, [(0.0, 3.3), (0.3, 2.8)])
    far = scene.point[: scene.count, 2] > 3.0
    assert (owner[far] == 0).all()
    assert (owner[~far] == 1).mean() > 0.98


def test_a_stranger_near_somebody_is_not_swallowed():
    scene = seen((0.0, 2.5, 0.4, 1.7), (0.5, 3.1, 0.4, 1.7))
    owner = share(scene, [(0.0, 2.6)])
    other = scene.point[: scene.count, 2] > 3.0
    assert (owner[other] == UNASSIGNED).mean() > 0.9
    places = segmentation.find_new_persons(scene, PINHOLE, 0.04, 0.5)
    assert len(places) == 1
    assert places[0] == pytest.approx((0.5, 3.1), abs=0.1)


def test_a_robot_is_nobody_and_keeps_its_points_beside_a_leg():
    scene = seen((1.0, 3.0, 0.35, 0.42))
    assert (share(scene, []) == UNASSIGNED).all()
    assert segmentation.find_new_persons(scene, PINHOLE, 0.04, 0.5) == []
    low = segmentation.locate_low_object(scene, NO_LOW, PINHOLE, 0.01)
    assert low == pytest.approx([1.0, 3.0], abs=0.05)
    owner = share(scene, [(0.55, 3.0)], low)
    assert (owner == LOW_OBJECT).mean() > 0.8


def test_a_person_is_measured():
    scene = seen((0.2, 3.0, 0.4, 1.7))
    share(scene, [(0.1, 3.1)])
    count, x, z, crown, width = segmentation.measure_persons(scene, np.array([[0.1, 3.1]]), np.ones(1), PER_PIXEL)[0]
    assert count == scene.count
    assert (x, z) == pytest.approx((0.2, 3.0), abs=0.03)
    assert crown == pytest.approx(1.7, abs=0.04)
    assert width == pytest.approx(0.8 * 0.4, abs=0.04)


def test_the_crown_is_the_same_whatever_is_seen_of_the_rest():
    heads = []
    for width, height in ((0.2, 1.6), (0.7, 1.6)):
        scene = seen((0.0, 3.0, width, height), (0.0, 2.99, 0.16, 1.7))
        share(scene, [(0.0, 3.0)])
        heads.append(segmentation.measure_persons(scene, np.array([[0.0, 3.0]]), np.ones(1), PER_PIXEL)[0, 3])
    assert heads[0] == pytest.approx(heads[1], abs=0.005)


def test_nobody_in_view_is_no_error():
    scene = seen()
    assert len(share(scene, [(0.0, 3.0)])) == 0
    assert not segmentation.measure_persons(scene, np.array([[0.0, 3.0]]), np.ones(1), PER_PIXEL).any()
    assert segmentation.find_new_persons(scene, PINHOLE, 0.04, 0.5) == []
    assert np.isnan(segmentation.locate_low_object(scene, NO_LOW, PINHOLE, 0.01)).all()
