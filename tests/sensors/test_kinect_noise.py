"""The sensor's noise: sizes as published, holes where they belong, nothing else touched."""

from __future__ import annotations

import numpy as np
import pytest

from sjasim.core.clock import stream
from sjasim.sensors import kinect_noise
from sjasim.sensors.depth_camera import RenderedDepth
from sjasim.sensors.raycast.primitives import BOX, PLANE

FX = 180.8
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


def sensed(picture: RenderedDepth, seed: int = 0) -> np.ndarray:
    return kinect_noise.add_kinect_noise(picture, FORM, FX, RANGE_M, stream(seed, "noise")) / 1000.0


def published_m(z: float, theta: float) -> float:
    """Fankhauser and others 2015, in millimetres: 1.5 - .5 z + .3 z^2 + .1 z^1.5 theta^2 / (pi/2 - theta)^2."""
    return 1e-3 * (1.5 - 0.5 * z + 0.3 * z**2 + 0.1 * z**1.5 * theta**2 / (np.pi / 2 - theta) ** 2)


@pytest.mark.parametrize("depth_m", [1.0, 2.0, 3.0, 4.0])
@pytest.mark.parametrize("incidence_rad", [0.0, 0.6, 1.1])
def test_axial_noise_has_the_published_size(depth_m: float, incidence_rad: float):
    seen = sensed(wall(depth_m, incidence_rad))
    expected = np.hypot(published_m(depth_m, incidence_rad), 0.001 / np.sqrt(12))
    assert seen.std() == pytest.approx(expected, rel=0.04)
    wiggle = kinect_noise.WIGGLE_M * np.sin(2 * np.pi * depth_m / kinect_noise.WIGGLE_PERIOD_M)
    assert seen.mean() - depth_m == pytest.approx(wiggle, abs=0.0002)


def test_pixels_mix_and_vanish_at_edges_only():
    picture = wall(2.0)
    picture.depth_m[:, 80:] = 3.0
    seen = sensed(picture)
    edge = seen[:, 79:81]
    assert (edge == 0).mean() == pytest.approx(kinect_noise.EDGE_DROPOUT, abs=0.08)
    between = (edge > 2.05) & (edge < 2.95)
    assert between.mean() == pytest.approx(0.9 * kinect_noise.EDGE_MIXING, abs=0.08)
    assert not (seen[:, :78] == 0).any()
    assert np.abs(seen[:, :78] - 2.0).max() < 0.02


def test_lateral_noise_moves_edges_by_a_pixel_at_most_when_near():
    picture = wall(0.6)
    picture.depth_m[:, 80:] = 4.0  # too far apart to mix
    moved = np.abs(sensed(picture) - picture.depth_m) > 1.0
    assert 0 < moved[:, 78:82].mean() < 0.5
    assert not moved[:, :77].any()


def test_lateral_noise_acts_on_a_slope_by_what_it_moves_there():
    picture, slope_m = wall(2.5), 0.03
    picture.depth_m[:] = 2.5 + slope_m * (np.arange(picture.depth_m.shape[1]) % 2)  # steps that do not mix
    off = (sensed(picture) - picture.depth_m)[2:-2, 2:-2]
    across = off[:, picture.depth_m[0, 2:-2] == 2.5]
    flat = (sensed(wall(2.5)) - 2.5).std()
    moved_px = kinect_noise.LATERAL_M * FX / 2.5
    half_normal = np.sqrt(2.0 / np.pi)
    assert across.mean() - (sensed(wall(2.5)) - 2.5).mean() == pytest.approx(slope_m * moved_px * half_normal, rel=0.1)
    assert across.std() == pytest.approx(np.hypot(flat, slope_m * moved_px * np.sqrt(1 - 2 / np.pi)), rel=0.05)


def test_lateral_noise_passes_an_edge_as_often_as_it_reaches_between_pixels():
    picture = wall(2.5)
    picture.depth_m[:, 80:] = np.inf  # nothing to mix with
    before, away = sensed(picture)[:, 79], sensed(picture)[:, 78]
    moved_px = kinect_noise.LATERAL_M * FX / 2.5
    assert (before == 0).mean() == pytest.approx(0.5 * moved_px * np.sqrt(2.0 / np.pi), abs=0.03)
    assert not (away == 0).any()


def test_grazing_surfaces_lose_pixels():
    assert (sensed(wall(2.0, 1.5)) == 0).mean() == pytest.approx(kinect_noise.GRAZING_DROPOUT, abs=0.02)
    assert not (sensed(wall(2.0, 1.4)) == 0).any()


def test_range_is_limited_and_depth_comes_in_whole_millimetres():
    for depth_m in (0.3, 4.7, np.inf):
        assert not sensed(wall(depth_m)).any()
    picture = wall(2.0)
    assert kinect_noise.add_kinect_noise(picture, FORM, FX, RANGE_M, stream(0, "noise")).dtype == np.uint16


def test_floor_among_floor_is_left_alone():
    picture = wall(2.0, geom=0)
    picture.geom[50, 60] = 1
    seen = sensed(picture)
    touched = np.argwhere(seen != 2.0)
    assert len(touched) <= 5
    assert (np.abs(touched - [50, 60]).sum(axis=1) <= 1).all()


def test_noise_differs_between_frames_and_repeats_with_the_seed():
    rng, picture = stream(0, "noise"), wall(2.0)
    first, second = (kinect_noise.add_kinect_noise(picture, FORM, FX, RANGE_M, rng) for _ in range(2))
    assert (first != second).any()
    assert (np.rint(sensed(picture) * 1000) == first).all()
    assert abs(np.corrcoef(first.ravel(), second.ravel())[0, 1]) < 0.03
    assert abs(np.corrcoef(first[:, 1:].ravel(), first[:, :-1].ravel())[0, 1]) < 0.03
