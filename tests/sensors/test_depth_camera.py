"""The depth camera against MuJoCo's rays, for every form of geom at any orientation."""

from __future__ import annotations

import math

import mujoco
import numpy as np
import pytest

from sjasim.choreography.layout import layout
from sjasim.config import SessionConfig
from sjasim.core import Geoms
from sjasim.sensors.depth_camera import DepthCamera, Intrinsics
from sjasim.skeleton_training.trials import Trial, prepare_trial

NORTH = layout(SessionConfig()).mounts[0]
FOV = math.radians(70.6), math.radians(60.0)
FORMS = {
    "plane": (0, (0.5, 0.3, 0.1)),
    "sphere": (2, (0.3, 0.0, 0.0)),
    "capsule": (3, (0.12, 0.4, 0.0)),
    "ellipsoid": (4, (0.4, 0.15, 0.25)),
    "cylinder": (5, (0.25, 0.3, 0.0)),
    "box": (6, (0.3, 0.1, 0.2)),
}


def random_scene(forms: list[str], seed: int) -> tuple[mujoco.MjModel, mujoco.MjData, Geoms]:
    """Return a floor and one geom of each form, at random positions and orientations."""
    rng = np.random.default_rng(seed)
    spec = mujoco.MjSpec()
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[8, 8, 0.1])
    for form in forms:
        code, size = FORMS[form]
        spec.worldbody.add_geom(
            type=mujoco.mjtGeom(code), size=size, quat=rng.normal(size=4),
            pos=[rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(0.1, 1.5)],
        )  # fmt: skip
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    geoms = Geoms(
        model.geom_type.astype(np.int64), model.geom_size.copy(), data.geom_xpos.copy(),
        data.geom_xmat.reshape(-1, 3, 3).copy(), np.full(model.ngeom, -1),
    )  # fmt: skip
    return model, data, geoms


def rays(intrinsics: Intrinsics) -> np.ndarray:
    """Return (H, W, 3) directions in the world, of unit depth."""
    u, v = np.meshgrid(np.arange(intrinsics.width), np.arange(intrinsics.height))
    x = (u - (intrinsics.width - 1) / 2) / intrinsics.fx
    y = ((intrinsics.height - 1) / 2 - v) / intrinsics.fy
    return np.stack([x, y, np.ones(x.shape)], axis=-1) @ NORTH.world_from_sensor.T


def render_by_mujoco(model: mujoco.MjModel, data: mujoco.MjData, intrinsics: Intrinsics) -> tuple[np.ndarray, ...]:
    """Return depth [m], geom and cosine of incidence by mj_multiRay."""
    directions = rays(intrinsics)
    length = np.linalg.norm(directions, axis=2)
    flat = (directions / length[..., None]).reshape(-1, 3)
    count = len(flat)
    geom = np.empty(count, np.int32)
    distance = np.empty(count)
    normal = np.empty((count, 3))
    mujoco.mj_multiRay(
        model, data, NORTH.position, flat.ravel(), None, 1, -1, geom, distance, normal.ravel(), count, 1e3
    )
    depth = np.where(distance < 0, np.inf, distance / length.ravel())
    cosine = np.abs((normal * flat).sum(axis=1))
    return tuple(values.reshape(length.shape) for values in (depth, geom, cosine))


@pytest.mark.parametrize("forms", [[name] for name in FORMS] + [[*FORMS, *FORMS]])
def test_every_form_at_any_orientation_is_rendered_as_by_mujoco(forms: list[str]):
    intrinsics = Intrinsics.from_field_of_view(256, *FOV)
    camera = DepthCamera(NORTH, intrinsics)
    rendered: set[int] = set()
    for seed in range(6):
        model, data, geoms = random_scene(forms, seed)
        image = camera.render(geoms)
        depth, geom, cosine = render_by_mujoco(model, data, intrinsics)

        assert (image.geom == geom).all()
        hit = geom >= 0
        assert np.abs(image.depth_m[hit] - depth[hit]).max() < 1e-6
        assert np.isinf(image.depth_m[~hit]).all()
        assert np.abs(image.incidence[hit] - cosine[hit]).max() < 1e-4
        rendered |= set(geom.ravel())
    assert rendered >= set(range(len(forms) + 1))


def test_the_two_resolutions_have_the_kinects_focal_lengths():
    full, half = Intrinsics.from_field_of_view(512, *FOV), Intrinsics.from_field_of_view(256, *FOV)
    assert (full.width, full.height, half.width, half.height) == (512, 424, 256, 212)
    assert (full.fx, full.fy) == pytest.approx((361.6, 367.2), abs=0.1)
    assert (2 * half.fx, 2 * half.fy) == pytest.approx((full.fx, full.fy))


def test_columns_grow_to_the_sensors_left_and_rows_downwards():
    position = NORTH.position + NORTH.world_from_sensor @ [0.5, 0.4, 2.0]
    ball = Geoms(np.array([2]), np.array([[0.1, 0, 0]]), position[None], np.eye(3)[None], np.array([0]))
    intrinsics = Intrinsics.from_field_of_view(256, *FOV)
    rows, columns = np.nonzero(DepthCamera(NORTH, intrinsics).render(ball).geom == 0)
    assert columns.mean() == pytest.approx(127.5 + 0.25 * intrinsics.fx, abs=1.0)
    assert rows.mean() == pytest.approx(105.5 - 0.2 * intrinsics.fy, abs=1.0)


def test_a_geom_behind_the_camera_is_not_rendered():
    position = NORTH.position - 2.0 * NORTH.world_from_sensor[:, 2]
    ball = Geoms(np.array([2]), np.array([[0.1, 0, 0]]), position[None], np.eye(3)[None], np.array([0]))
    image = DepthCamera(NORTH, Intrinsics.from_field_of_view(256, *FOV)).render(ball)
    assert (image.geom == -1).all()
    assert np.isinf(image.depth_m).all()
    assert not image.incidence.any()


def first_hits(physics, directions):
    """Return distance and the dancer that is hit, or -1, by MuJoCo's rays from the north sensor."""
    count = len(directions)
    geom = np.empty(count, dtype=np.int32)
    distance = np.empty(count)
    groups = np.array([1, 1, 1, 0, 1, 1], dtype=np.uint8)
    mujoco.mj_multiRay(
        physics.model,
        physics.data,
        NORTH.position,
        directions.ravel(),
        groups,
        1,
        -1,
        geom,
        distance,
        None,
        count,
        10.0,
    )
    names = [physics.model.geom(int(index)).name if index >= 0 else "" for index in geom]
    return distance, np.array([int(name[7]) - 1 if name.startswith("dancer_") else -1 for name in names])


def test_dancers_and_robot_are_rendered_as_by_the_scenes_own_rays():
    view, layout_ = prepare_trial(Trial(5, 4.0))
    intrinsics = Intrinsics.from_field_of_view(256, *FOV)
    image = DepthCamera(layout_.mounts[0], intrinsics).render(view.geoms)
    directions = rays(intrinsics)
    length = np.linalg.norm(directions, axis=2)
    rows, columns = np.nonzero(image.depth_m * length < 9.9)
    rows = rows[::7]
    columns = columns[::7]
    unit = directions[rows, columns] / length[rows, columns, None]
    distance, owner = first_hits(view._physics, np.ascontiguousarray(unit))
    assert np.abs(image.depth_m[rows, columns] * length[rows, columns] - distance).max() < 1e-6
    assert (view.geoms.owner[image.geom[rows, columns]] == owner).all()
    assert set(owner) == {-1, 0, 1, 2}
