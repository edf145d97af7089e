"""Tests of the MuJoCo model of a dancer: actuators, balance support and contacts."""

from __future__ import annotations

import numpy as np
import pytest

from sjasim.assets.names import ACTUATED, FLOOR_BIT, HAND_BIT, ROBOT_BIT, TETHERED, dancer_bit
from sjasim.config import BodyConfig
from sjasim.humans.body.anatomy import Build
from sjasim.humans.body.mjcf import GAINS, dancer_spec
from sjasim.humans.body.proportions import scaled_anatomy


def model(build=None, index=0, group=1, config=None):
    return dancer_spec(scaled_anatomy(build or Build()), index, group, config or BodyConfig()).compile()


@pytest.mark.parametrize("build", [Build(1.5, 50.0), Build(1.95, 100.0), Build(1.6, 90.0)], ids=str)
def test_gains_and_limits_scale_with_the_build(build):
    usual, other = model(), model(build)
    scale = build.mass_kg / 75.0 * (build.stature_m / 1.75) ** 2
    for name in ACTUATED:
        a, b = usual.actuator(name), other.actuator(name)
        assert b.gainprm[0] == pytest.approx(scale * a.gainprm[0])
        assert b.forcerange == pytest.approx(scale * a.forcerange)
        assert a.gainprm[0] == GAINS[name.removesuffix("_L").removesuffix("_R")][0]


def test_servos_are_damped():
    one = model()
    damping = np.array([-one.actuator(name).biasprm[2] for name in ACTUATED])
    assert (damping > 0).all()


def test_balance_support_acts_on_all_but_the_vertical_within_its_limits():
    one = model(config=BodyConfig(support_force_n=33.0, support_torque_nm=11.0))
    for name in TETHERED:
        limit = 33.0 if name in ("root_x", "root_y") else 11.0
        assert one.actuator(name).forcerange == pytest.approx([-limit, limit])
    assert one.nu == len(ACTUATED) + len(TETHERED)
    assert "root_z" not in [one.actuator(k).name for k in range(one.nu)]
    assert model(config=BodyConfig(balance_support="none")).nu == len(ACTUATED)


def collide(a, b) -> bool:
    """Whether MuJoCo lets two geoms make contact."""
    return bool(a.contype[0] & b.conaffinity[0] or b.contype[0] & a.conaffinity[0])


def test_which_parts_make_contact():
    first, second = model(index=0, group=3), model(index=1, group=3)
    hands = [first.geom(f"hand_{side}") for side in "LR"]
    assert collide(*hands)
    assert not collide(hands[0], first.geom("chest"))
    assert not collide(first.geom("thigh_L"), first.geom("thigh_R"))
    assert collide(first.geom("chest"), second.geom("hand_L"))
    for soles in (first.geom("heel_out_L"), second.geom("toe_in_R")):
        assert int(soles.conaffinity[0]) == FLOOR_BIT
        assert int(soles.contype[0]) == 0
        assert not collide(soles, first.geom("chest"))
    assert int(first.geom("chest").conaffinity[0]) & ROBOT_BIT
    assert int(first.geom("chest").conaffinity[0]) & FLOOR_BIT == 0


def test_every_dancer_of_the_largest_group_has_its_own_contact_bit():
    bits = [dancer_bit(index) for index in range(8)] + [FLOOR_BIT, HAND_BIT, ROBOT_BIT]
    assert len(set(bits)) == 11
    assert all(bit & (bit - 1) == 0 for bit in bits)


def test_soles_are_hidden_from_sensors():
    one = model()
    soles = [k for k in range(one.ngeom) if one.geom_contype[k] == 0]
    assert soles
    assert (one.geom_group[soles] == 3).all()
