"""The Kinect's noise: its size as published, mixed and missing pixels only where they belong."""

from __future__ import annotations

import numpy as np
import pytest

from sjasim.core.clock import stream
from sjasim.sensors import kinect_noise
from sjasim.sensors.depth_camera import RenderedDepth
from sjasim.sensors.raycast.primitives import BOX, PLANE

FX = 180.8
"""Focal length in pixels, of an image of half the Kinect's resolution."""

RANGE_M = (0.5, 4.5)
FORM = np.array([PLANE, BOX])


def wall(
    depth_m: float, incidence_rad: float = 0.0, shape: tuple[int, int] = (120, 160), geom: int = 1
) -> RenderedDepth:
    return RenderedDepth(
        np.full(shape, depth_m),
        np.full(shape, geom, np.int16),
        np.full(shape, np.cos(incidence_rad), np.float32),
    )


def measured_m(image: RenderedDepth, seed: int = 0) -> np.ndarray:
    """Return the noisy depth image of an exact one."""
    return kinect_noise.add_kinect_noise(image, FORM, FX, RANGE_M, stream(seed, "noise")) / 1000.0


def published_m(z: float, theta: float) -> float:
    """Return the axial standard deviation of fankhauser2015, eq. (6), whose constants are in millimetres."""
    return 1e-3 * (1.5 - 0.5 * z + 0.3 * z**2 + 0.1 * z**1.5 * theta**2 / (np.pi / 2 - theta) ** 2)


@pytest.mark.parametrize("depth_m", [1.0, 2.0, 3.0, 4.0])
@pytest.mark.parametrize("incidence_rad", [0.0, 0.6, 1.1])
def test_axial_noise_has_the_published_size(depth_m: float, incidence_rad: float):
    measured = measured_m(wall(depth_m, incidence_rad))
    expected = np.hypot(published_m(depth_m, incidence_rad), 0.001 / np.sqrt(12))
    assert measured.std() == pytest.approx(expected, rel=0.04)
    wiggle = kinect_noise.WIGGLE_M * np.sin(2 * np.pi * depth_m / kinect_noise.WIGGLE_PERIOD_M)
    assert measured.mean() - depth_m == pytest.approx(wiggle, abs=0.0002)


def test_pixels_are_mixed_or_missing_at_edges_only():
    image = wall(2.0)
    image.depth_m[:, 80:] = 3.0
    measured = measured_m(image)
    edge = measured[:, 79:81]
    assert (edge == 0).mean() == pytest.approx(kinect_noise.EDGE_DROPOUT, abs=0.08)
    between = (edge > 2.05) & (edge < 2.95)
    assert between.mean() == pytest.approx(0.9 * kinect_noise.EDGE_MIXING, abs=0.08)
    assert not (measured[:, :78] == 0).any()
    assert np.abs(measured[:, :78] - 2.0).max() < 0.02


def test_lateral_noise_moves_edges_by_a_pixel_at_most_when_near():
    image = wall(0.6)
    image.depth_m[:, 80:] = 4.0  # too far apart to mix
    moved = np.abs(measured_m(image) - image.depth_m) > 1.0
    assert 0 < moved[:, 78:82].mean() < 0.5
    assert not moved[:, :77].any()


def test_lateral_noise_on_a_slope_is_the_depth_at_the_displaced_pixel():
    image = wall(2.5)
    slope_m = 0.03
    image.depth_m[:] = 2.5 + slope_m * (np.arange(image.depth_m.shape[1]) % 2)  # steps that do not mix
    off = (measured_m(image) - image.depth_m)[2:-2, 2:-2]
    across = off[:, image.depth_m[0, 2:-2] == 2.5]
    flat = (measured_m(wall(2.5)) - 2.5).std()
    moved_px = kinect_noise.LATERAL_M * FX / 2.5
    half_normal = np.sqrt(2.0 / np.pi)
    assert across.mean() - (measured_m(wall(2.5)) - 2.5).mean() == pytest.approx(
        slope_m * moved_px * half_normal, rel=0.1
    )
    assert across.std() == pytest.approx(np.hypot(flat, slope_m * moved_px * np.sqrt(1 - 2 / np.pi)), rel=0.05)


def test_lateral_noise_crosses_an_edge_as_often_as_it_reaches_between_pixels():
    image = wall(2.5)
    image.depth_m[:, 80:] = np.inf  # nothing to mix with
    measured = measured_m(image)
    at_edge = measured[:, 79]
    beside_it = measured[:, 78]
    moved_px = kinect_noise.LATERAL_M * FX / 2.5
    assert (at_edge == 0).mean() == pytest.approx(0.5 * moved_px * np.sqrt(2.0 / np.pi), abs=0.03)
    assert not (beside_it == 0).any()


def test_grazing_surfaces_lose_pixels():
    assert (measured_m(wall(2.0, 1.5)) == 0).mean() == pytest.approx(kinect_noise.GRAZING_DROPOUT, abs=0.02)
    assert not (measured_m(wall(2.0, 1.4)) == 0).any()


def test_range_is_limited_and_depth_comes_in_whole_millimetres():
    for depth_m in (0.3, 4.7, np.inf):
        assert not measured_m(wall(depth_m)).any()
    image = wall(2.0)
    assert kinect_noise.add_kinect_noise(image, FORM, FX, RANGE_M, stream(0, "noise")).dtype == np.uint16


def test_floor_surrounded_by_floor_has_no_noise():
    image = wall(2.0, geom=0)
    image.geom[50, 60] = 1
    measured = measured_m(image)
    touched = np.argwhere(measured != 2.0)
    assert len(touched) <= 5
    assert (np.abs(touched - [50, 60]).sum(axis=1) <= 1).all()


def test_noise_differs_between_frames_and_repeats_with_the_seed():
    rng = stream(0, "noise")
    image = wall(2.0)
    first, second = (kinect_noise.add_kinect_noise(image, FORM, FX, RANGE_M, rng) for _ in range(2))
    assert (first != second).any()
    assert (np.rint(measured_m(image) * 1000) == first).all()
    assert abs(np.corrcoef(first.ravel(), second.ravel())[0, 1]) < 0.03
    assert abs(np.corrcoef(first[:, 1:].ravel(), first[:, :-1].ravel())[0, 1]) < 0.03
