"""Our rays against MuJoCo's: the same points are hidden, whatever stands in between."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from sjasim.core import Solids
from sjasim.sensors.raycast.occlusion import bounding_shapes

from .reference_rays import hidden

SHAPES = {
    "plane": 'type="plane" size="3 3 .1" pos="0 0 -1"',
    "sphere": 'type="sphere" size=".4" pos=".3 .2 .1"',
    "capsule": 'type="capsule" size=".2 .5" pos="-.2 .4 .1" euler="40 20 70"',
    "ellipsoid": 'type="ellipsoid" size=".2 .5 .3" pos=".5 -.4 .3" euler="10 50 30"',
    "cylinder": 'type="cylinder" size=".3 .4" pos="-.5 -.3 .2" euler="70 10 20"',
    "box": 'type="box" size=".3 .2 .4" pos=".1 .1 .6" euler="25 35 45"',
}


def scene(names):
    geoms = "".join(f"<geom {SHAPES[name]}/>" for name in names)
    model = mujoco.MjModel.from_xml_string(f"<mujoco><worldbody>{geoms}</worldbody></mujoco>")
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return model, data


def by_mujoco(model, data, origin, points, whose, flesh_m, owners):
    out = []
    for point, mine in zip(points, whose, strict=True):
        way = point - origin
        length = np.linalg.norm(way)
        seen = True
        for geom in range(model.ngeom):
            normal = None
            alone = np.zeros(model.ngeom, dtype=bool)
            alone[geom] = True
            only, _ = scene_of(model, geom)
            distance = mujoco.mj_ray(only[0], only[1], origin, way / length, None, 1, -1, np.zeros(1, np.int32), normal)
            limit = length - (flesh_m if owners[geom] == mine else 0.0)
            seen = seen and not 0.0 <= distance < limit
        out.append(not seen)
    return np.array(out)


_ALONE: dict[int, tuple] = {}


def scene_of(model, geom):
    if geom not in _ALONE:
        name = list(SHAPES)[geom]
        _ALONE[geom] = scene([name])
    return _ALONE[geom], None


@pytest.mark.parametrize("flesh_m", [0.0, 0.2])
def test_the_same_points_are_hidden_as_by_mujocos_rays(flesh_m):
    model, data = scene(SHAPES)
    rng = np.random.default_rng(1)
    owners = np.array([-1, 0, 0, 1, 1, 2])
    rows = np.column_stack([np.arange(model.ngeom), owners, model.geom_type.astype(np.int64)])
    solids = Solids(rows, bounding_shapes(rows[:, 2], model.geom_size), data.geom_xpos, data.geom_xmat)
    for origin in (np.array([3.0, 0.5, 0.9]), np.array([-2.0, -2.5, 0.2])):
        points = rng.uniform([-1.5, -1.5, -0.9], [1.5, 1.5, 1.5], size=(200, 3))
        whose = rng.integers(0, 3, size=200)
        out = hidden(origin, points, whose, np.full(200, flesh_m), solids)
        assert np.array_equal(out, by_mujoco(model, data, origin, points, whose, flesh_m, owners))
        assert 0.1 < out.mean() < 0.9
