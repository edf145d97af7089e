"""Tests of the anatomy tables, alone and against the compiled MuJoCo model."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from sjasim.assets.names import JOINTS
from sjasim.config import BodyConfig
from sjasim.core.errors import ConfigError
from sjasim.humans.body.anatomy import Build
from sjasim.humans.body.mjcf import dancer_spec
from sjasim.humans.body.proportions import scaled_anatomy

BUILDS = [Build(), Build(1.50, 50.0), Build(1.95, 100.0), Build(1.50, 100.0), Build(1.95, 50.0)]


@pytest.mark.parametrize("build", BUILDS, ids=str)
def test_masses_add_up_to_the_build(build):
    body = scaled_anatomy(build)
    model = dancer_spec(body, 0, 1, BodyConfig()).compile()
    assert body.chains().mass.sum() == pytest.approx(build.mass_kg, rel=1e-12)
    assert model.body_mass.sum() == pytest.approx(build.mass_kg, rel=1e-9)


@pytest.mark.parametrize("build", BUILDS, ids=str)
def test_segments_have_the_models_mass_and_centre(build):
    body = scaled_anatomy(build)
    chains = body.chains()
    model = dancer_spec(body, 0, 1, BodyConfig()).compile()
    for row, segment in enumerate(body.segments):
        known = model.body(segment.name)
        assert known.mass[0] == pytest.approx(chains.mass[row], rel=1e-9)
        assert known.ipos == pytest.approx(chains.centre[row], abs=1e-9)


@pytest.mark.parametrize("build", BUILDS, ids=str)
def test_the_top_of_the_head_is_at_the_stature(build):
    body = scaled_anatomy(build)
    model = dancer_spec(body, 0, 1, BodyConfig()).compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    head = model.geom("head").id
    top = data.geom_xpos[head, 2] + model.geom_size[head, 2]
    floor = data.site("AnkleLeft").xpos[2] - body.ankle_m
    assert top - floor == pytest.approx(build.stature_m, rel=0.03)


def test_every_kinect_joint_has_a_place():
    body = scaled_anatomy(Build())
    assert set(body.joints) == set(JOINTS)
    left, right = (np.array(body.joints[f"Ankle{side}"][1]) for side in ("Left", "Right"))
    assert left == pytest.approx(right)


def test_parents_come_before_children():
    assert all(segment.parent < row for row, segment in enumerate(scaled_anatomy(Build()).segments))


@pytest.mark.parametrize(
    ("values", "field", "allowed"),
    [
        ((1.49, 75.0), "build.stature_m", "1.50 to 1.95"),
        ((1.96, 75.0), "build.stature_m", "1.50 to 1.95"),
        ((float("nan"), 75.0), "build.stature_m", "1.50 to 1.95"),
        ((1.75, 49.0), "build.mass_kg", "50 to 100"),
        ((1.75, 101.0), "build.mass_kg", "50 to 100"),
    ],
)
def test_a_build_outside_the_range_is_refused(values, field, allowed):
    with pytest.raises(ConfigError, match=allowed) as caught:
        Build(*values)
    assert caught.value.field == field
