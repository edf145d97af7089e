"""The occlusion test against MuJoCo's rays: the same points are occluded, whatever stands in between."""

from __future__ import annotations

from functools import cache

import mujoco
import numpy as np
import pytest

from sjasim.core import Solids
from sjasim.sensors.raycast.occlusion import bounding_shapes

from .reference_rays import occluded

GEOMS = {
    "plane": 'type="plane" size="3 3 .1" pos="0 0 -1"',
    "sphere": 'type="sphere" size=".4" pos=".3 .2 .1"',
    "capsule": 'type="capsule" size=".2 .5" pos="-.2 .4 .1" euler="40 20 70"',
    "ellipsoid": 'type="ellipsoid" size=".2 .5 .3" pos=".5 -.4 .3" euler="10 50 30"',
    "cylinder": 'type="cylinder" size=".3 .4" pos="-.5 -.3 .2" euler="70 10 20"',
    "box": 'type="box" size=".3 .2 .4" pos=".1 .1 .6" euler="25 35 45"',
}
OWNERS = np.array([-1, 0, 0, 1, 1, 2])
"""Owner of each geom."""


@cache
def scene(names: tuple[str, ...]) -> tuple[mujoco.MjModel, mujoco.MjData]:
    geoms = "".join(f"<geom {GEOMS[name]}/>" for name in names)
    model = mujoco.MjModel.from_xml_string(f"<mujoco><worldbody>{geoms}</worldbody></mujoco>")
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return model, data


def occluded_by_mujoco(
    origin: np.ndarray, points: np.ndarray, owners: np.ndarray, body_depth_m: float
) -> np.ndarray:  # fmt: skip
    """Return which points are occluded, with one MuJoCo ray per point in a scene of each geom alone."""
    out = []
    for point, owner in zip(points, owners, strict=True):
        ray = point - origin
        length = np.linalg.norm(ray)
        visible = True
        for geom, name in enumerate(GEOMS):
            model, data = scene((name,))
            distance = mujoco.mj_ray(model, data, origin, ray / length, None, 1, -1, np.zeros(1, np.int32), None)
            limit = length - (body_depth_m if OWNERS[geom] == owner else 0.0)
            visible = visible and not 0.0 <= distance < limit
        out.append(not visible)
    return np.array(out)


@pytest.mark.parametrize("body_depth_m", [0.0, 0.2])
@pytest.mark.parametrize("origin", [(3.0, 0.5, 0.9), (-2.0, -2.5, 0.2)])
def test_the_same_points_are_occluded_as_by_mujocos_rays(origin: tuple[float, float, float], body_depth_m: float):
    model, data = scene(tuple(GEOMS))
    rows = np.column_stack([np.arange(model.ngeom), OWNERS, model.geom_type.astype(np.int64)])
    geoms = Solids(rows, bounding_shapes(rows[:, 2], model.geom_size), data.geom_xpos, data.geom_xmat)

    rng = np.random.default_rng(1)
    points = rng.uniform([-1.5, -1.5, -0.9], [1.5, 1.5, 1.5], size=(200, 3))
    owners = rng.integers(0, 3, size=200)
    found = occluded(np.array(origin), points, owners, np.full(200, body_depth_m), geoms)
    assert np.array_equal(found, occluded_by_mujoco(np.array(origin), points, owners, body_depth_m))
    assert 0.1 < found.mean() < 0.9
