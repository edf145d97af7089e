"""Rendered pictures: their size and content, and that rendering does not change the session."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from sjasim.choreography.layout import layout
from sjasim.simulation.rendering import CAMERAS, Renderer, RenderError
from sjasim.simulation.video import add_captions


@pytest.fixture(scope="module")
def world(make_world):
    return make_world()


@pytest.fixture(scope="module")
def renderer(world, short_config):
    mounts = layout(short_config).mounts
    try:
        with Renderer(world.physics, 160, 90, mounts, fine=False) as made:
            yield made
    except RenderError as error:
        pytest.skip(str(error))


@pytest.mark.parametrize("camera", CAMERAS)
def test_every_camera_shows_the_dancers(renderer, camera):
    picture = renderer.render(camera, active="north")
    assert picture.shape == (90, 160, 3)
    assert picture.dtype == np.uint8
    red, green, blue = (picture[..., channel].astype(int) for channel in range(3))
    assert ((red > blue + 60) & (red > green + 20)).sum() > 15  # the first dancer's shirt
    assert (blue > red + 60).sum() > 15  # the third dancer's shirt


def test_the_active_sensor_is_drawn_in_another_colour(renderer):
    assert (renderer.render("scene", "north") != renderer.render("scene", "")).any()


def test_rendering_does_not_change_the_state(world, renderer):
    data = world.physics.data
    qpos = data.qpos.copy()
    time_s = data.time
    renderer.render()
    assert np.array_equal(data.qpos, qpos)
    assert data.time == time_s


def test_an_unknown_camera_is_refused(renderer):
    with pytest.raises(RenderError, match="known are scene"):
        renderer.render("attic")


@pytest.mark.parametrize("size", [(8, 90), (160, 8), (4000, 90), (160, 2161), (160.0, 90)])
def test_a_size_that_is_not_allowed_is_refused(world, size):
    with pytest.raises(RenderError, match="not allowed"):
        Renderer(world.physics, *size)


def test_without_opengl_the_error_names_the_package(world, monkeypatch):
    def missing(*sizes):
        raise mujoco.FatalError("gladLoadGL error")

    monkeypatch.setattr(mujoco, "Renderer", missing)
    with pytest.raises(RenderError, match="libegl1"):
        Renderer(world.physics)


def test_captions_are_drawn_at_the_top_and_bottom_of_the_picture():
    blank = np.full((180, 320, 3), 128, dtype=np.uint8)
    picture = add_captions(blank, "1.0 s", [("dancer_1 claps", (200, 0, 0))])
    assert (picture[:20] != 128).any()
    assert (picture[-20:] != 128).any()
    assert (picture[60:120] == 128).all()
