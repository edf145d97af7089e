"""Tests of inverse dynamics against statics and against MuJoCo, for the same motion and forces of the floor."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from sjasim.assets.names import ACTUATED, ACTUATED_INDEX
from sjasim.config import BodyConfig
from sjasim.core import Move
from sjasim.humans.body.anatomy import Build
from sjasim.humans.body.inverse_dynamics import hinge_torques, place_chains
from sjasim.humans.body.mjcf import dancer_spec
from sjasim.humans.body.proportions import scaled_anatomy
from sjasim.humans.motion.planner import Planner
from sjasim.humans.motion.reference_trajectory import ReferenceTrajectory

from ..dancing import HZ, NORTH, at_rest, walk_cue


def planned(body):
    reference = ReferenceTrajectory.empty(1, 6 * HZ).for_dancer(0)
    planner = Planner(body, np.zeros(2), NORTH, 0.5, NORTH, HZ, reference)
    planner.extend([walk_cue(Move.FORWARD, 2.0, 1.5)], 0.0)
    return at_rest(reference)


def test_torques_of_a_resting_body_are_those_of_statics():
    body = scaled_anatomy(Build())
    chains = body.chains()
    r = planned(body)
    ankle = [r.torque[10, ACTUATED_INDEX[f"ankle_y_{side}"]] for side in "LR"]
    ahead = 0.026 * 1.75
    assert abs(sum(ankle)) == pytest.approx(75 * 9.81 * ahead, rel=0.06)
    q = np.zeros((1, 25))
    q[0, ACTUATED_INDEX["elbow_L"]] = -np.pi / 2
    placed = place_chains(chains, q, np.zeros((1, 3)), np.zeros(1))
    arm = hinge_torques(chains, placed, np.zeros((1, 2, 3)), np.full(1, 0.5), 1 / HZ)
    fore, hand = 0.016 * 75, 0.006 * 75
    length = 0.146 * 1.75
    expected = 9.81 * (fore * (length - 0.02) / 2 + hand * (length + 0.048 * 1.75))
    assert abs(arm[0, ACTUATED_INDEX["elbow_L"]]) == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("build", [Build(), Build(1.55, 90.0)], ids=str)
def test_torques_of_a_walk_are_mujocos(build):
    """MuJoCo's inverse dynamics without contact, while the right foot swings: its leg, the arms and the trunk."""
    body = scaled_anatomy(build)
    r = planned(body)
    model = dancer_spec(body, 0, 1, BodyConfig()).compile()
    model.dof_armature[:] = 0.0
    model.dof_damping[:] = 0.0
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_ACTUATION | mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    data = mujoco.MjData(model)
    names = ("root_x", "root_y", "root_z", "root_yaw", *ACTUATED)
    columns = [int(model.joint(name).dofadr[0]) for name in names]
    path = np.concatenate([r.pelvis, r.yaw[:, None], r.joints], axis=1)
    speed = np.gradient(path, 1 / HZ, axis=0)
    force = np.gradient(speed, 1 / HZ, axis=0)
    swinging = [t for t in range(2, len(path) - 2) if r.landing[t, 1] > 0.05 and r.landing[t - 5, 1] > 0]
    side = [ACTUATED_INDEX[f"{name}_R"] for name in ("hip_y", "knee", "shoulder_y", "elbow")]
    found, expected = [], []
    for t in swinging:
        data.qpos[columns], data.qvel[columns], data.qacc[columns] = path[t], speed[t], force[t]
        mujoco.mj_inverse(model, data)
        torques = data.qfrc_inverse[columns[4:]]
        found.append(r.torque[t, side])
        expected.append(torques[side])
    found, expected = np.array(found), np.array(expected)
    assert len(found) > 20
    scale = np.abs(expected).max(axis=0)
    assert (np.abs(found - expected).mean(axis=0) < 0.08 * scale + 0.3).all()
