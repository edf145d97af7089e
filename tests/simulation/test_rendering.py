"""Pictures of a stage: the right size, not empty, and without any effect on the session."""

import numpy as np
import pytest

from sjasim.choreography.layout import layout
from sjasim.choreography.timetable import timetable
from sjasim.config import SessionConfig
from sjasim.simulation.physics_world import PhysicsWorld
from sjasim.simulation.rendering import CAMERAS, Renderer, RenderError
from sjasim.simulation.video import add_captions


@pytest.fixture(scope="module")
def world():
    config = SessionConfig(iterations=1)
    place = layout(config)
    return PhysicsWorld(config, timetable(config), place, robot=True), place.mounts


@pytest.fixture(scope="module")
def renderer(world):
    try:
        with Renderer(world[0].physics, 160, 90, world[1], fine=False) as found:
            yield found
    except RenderError as error:
        pytest.skip(str(error))


@pytest.mark.parametrize("camera", CAMERAS)
def test_every_camera_sees_the_group(renderer, camera):
    picture = renderer.render(camera, active="north")
    assert picture.shape == (90, 160, 3)
    assert picture.dtype == np.uint8
    red, green, blue = (picture[..., channel].astype(int) for channel in range(3))
    assert ((red > blue + 60) & (red > green + 20)).sum() > 15  # the first dancer's shirt
    assert (blue > red + 60).sum() > 15  # the third one's


def test_the_active_sensor_is_lit(renderer):
    assert (renderer.render("scene", "north") != renderer.render("scene", "")).any()


def test_looking_changes_nothing(world, renderer):
    before = world[0].physics.data.qpos.copy(), world[0].physics.data.time
    renderer.render()
    assert np.array_equal(world[0].physics.data.qpos, before[0])
    assert world[0].physics.data.time == before[1]


def test_unknown_cameras_and_sizes_are_refused(world, renderer):
    with pytest.raises(RenderError, match="known are scene"):
        renderer.render("attic")
    with pytest.raises(RenderError, match="not allowed"):
        Renderer(world[0].physics, 8, 8)


def test_without_opengl_the_package_is_named(world, monkeypatch):
    import mujoco

    def missing(*sizes):
        raise mujoco.FatalError("gladLoadGL error")

    monkeypatch.setattr(mujoco, "Renderer", missing)
    with pytest.raises(RenderError, match="libegl1"):
        Renderer(world[0].physics)


def test_captions_are_drawn_over_the_picture():
    blank = np.full((180, 320, 3), 128, dtype=np.uint8)
    picture = add_captions(blank, "1.0 s", [("dancer_1 claps", (200, 0, 0))])
    assert (picture[:20] != 128).any()
    assert (picture[-20:] != 128).any()
    assert (picture[60:120] == 128).all()
