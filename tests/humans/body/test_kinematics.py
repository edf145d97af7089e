"""Tests of kinematics against MuJoCo."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from sjasim.assets.names import ACTUATED, ACTUATED_INDEX, JOINT_INDEX, JOINTS, LEG_JOINTS
from sjasim.config import BodyConfig
from sjasim.humans.body.anatomy import Build
from sjasim.humans.body.kinematics import com_offsets, joint_positions, leg_angles
from sjasim.humans.body.mjcf import dancer_spec
from sjasim.humans.body.proportions import scaled_anatomy
from sjasim.humans.motion.planner import LEG_COLUMNS

BUILDS = [Build(), Build(1.52, 95.0), Build(1.93, 55.0)]
ANKLES = [JOINT_INDEX["AnkleLeft"], JOINT_INDEX["AnkleRight"]]
HIPS = [JOINT_INDEX["HipLeft"], JOINT_INDEX["HipRight"]]


class Model:
    """A MuJoCo model of a dancer that takes given postures."""

    def __init__(self, build: Build) -> None:
        self.body = scaled_anatomy(build)
        self.model = dancer_spec(self.body, 0, 1, BodyConfig()).compile()
        self.data = mujoco.MjData(self.model)

    def pose(self, q: np.ndarray, pelvis: np.ndarray, yaw: float) -> None:
        for name, angle in zip(ACTUATED, q, strict=True):
            self.data.joint(name).qpos[0] = angle
        for name, value in zip(("root_x", "root_y", "root_z", "root_yaw"), (*pelvis, yaw), strict=True):
            self.data.joint(name).qpos[0] = value
        mujoco.mj_forward(self.model, self.data)

    @property
    def joints(self) -> np.ndarray:
        return np.array([self.data.site(name).xpos for name in JOINTS])

    @property
    def com(self) -> np.ndarray:
        return self.data.subtree_com[self.model.body("pelvis").id].copy()

    def postures(self, count: int, seed: int):
        rng = np.random.default_rng(seed)
        ranges = np.array([self.model.joint(name).range for name in ACTUATED])
        for _ in range(count):
            yield rng.uniform(*ranges.T), rng.normal(0, 1, 3), float(rng.uniform(-np.pi, np.pi))


@pytest.mark.parametrize("build", BUILDS, ids=str)
def test_joints_lie_where_mujoco_puts_them(build):
    model = Model(build)
    chains = model.body.chains()
    for q, pelvis, yaw in model.postures(20, 1):
        model.pose(q, pelvis, yaw)
        assert np.abs(joint_positions(chains, q, pelvis, yaw) - model.joints).max() < 1e-9


@pytest.mark.parametrize("build", BUILDS, ids=str)
def test_the_centre_of_mass_is_that_of_mujoco(build):
    model = Model(build)
    chains = model.body.chains()
    for q, pelvis, yaw in model.postures(20, 2):
        model.pose(q, pelvis, yaw)
        offset = com_offsets(chains, q[None], np.array([yaw]))
        assert np.abs(pelvis + offset[0] - model.com).max() < 1e-9


def reachable(body, seed: int, count: int = 200):
    """Pelvis, its yaw, ankles and foot yaws as they occur in steps and turns."""
    rng = np.random.default_rng(seed)
    pelvis = np.c_[rng.normal(0, 1, (count, 2)), body.standing_m - rng.uniform(0.02, 0.15, count)]
    yaw = rng.uniform(-np.pi, np.pi, count)
    left = np.stack([-np.sin(yaw), np.cos(yaw)], axis=1)
    ankles = np.empty((count, 2, 3))
    for side, sign in enumerate((1, -1)):
        ankles[:, side, :2] = pelvis[:, :2] + sign * body.hip_m * left + rng.uniform(-0.12, 0.12, (count, 2))
        ankles[:, side, 2] = body.ankle_m + rng.uniform(0, 0.06, count)
    return pelvis, yaw, ankles, yaw[:, None] + rng.uniform(-0.6, 0.6, (count, 2))


@pytest.mark.parametrize("build", BUILDS, ids=str)
def test_leg_angles_reach_the_ankles_with_flat_soles(build):
    model = Model(build)
    chains = model.body.chains()
    pelvis, yaw, ankles, foot_yaw = reachable(model.body, 3)
    q = np.zeros((len(pelvis), 25))
    leg_angles(pelvis, yaw, ankles, foot_yaw, chains.leg, q, LEG_COLUMNS)
    for t in range(len(pelvis)):
        joints = joint_positions(chains, q[t], pelvis[t], yaw[t])
        assert np.abs(joints[ANKLES] - ankles[t]).max() < 1e-9
        model.pose(q[t], pelvis[t], yaw[t])
        for side, name in enumerate(("foot_L", "foot_R")):
            foot = model.data.body(name).xmat.reshape(3, 3)
            assert foot[:, 2] == pytest.approx([0, 0, 1], abs=1e-9)
            assert foot[:2, 0] == pytest.approx([np.cos(foot_yaw[t, side]), np.sin(foot_yaw[t, side])], abs=1e-9)


def test_knees_bend_forward_only():
    body = scaled_anatomy(Build())
    pelvis, yaw, ankles, foot_yaw = reachable(body, 4)
    q = np.zeros((len(pelvis), 25))
    leg_angles(pelvis, yaw, ankles, foot_yaw, body.chains().leg, q, LEG_COLUMNS)
    assert (q[:, LEG_COLUMNS[:, LEG_JOINTS.index("knee")]] > 0).all()


def test_a_place_out_of_reach_gives_the_stretched_leg_that_points_at_it():
    body = scaled_anatomy(Build())
    chains = body.chains()
    pelvis, yaw, ankles, foot_yaw = reachable(body, 5, 50)
    pelvis[:, 2] += 0.4
    q = np.zeros((len(pelvis), 25))
    leg_angles(pelvis, yaw, ankles, foot_yaw, chains.leg, q, LEG_COLUMNS)
    assert np.isfinite(q).all()
    for t in range(len(pelvis)):
        joints = joint_positions(chains, q[t], pelvis[t], yaw[t])
        leg, wish = joints[ANKLES] - joints[HIPS], ankles[t] - joints[HIPS]
        length = np.linalg.norm(leg, axis=1)
        assert length == pytest.approx(body.thigh_m + body.shank_m - 0.002, abs=1e-9)
        assert leg / length[:, None] == pytest.approx(wish / np.linalg.norm(wish, axis=1, keepdims=True), abs=1e-9)


def test_leg_angles_leave_other_columns_unchanged():
    body = scaled_anatomy(Build())
    q = np.full((1, 25), 0.123)
    pelvis, yaw, ankles, foot_yaw = reachable(body, 6, 1)
    leg_angles(pelvis, yaw, ankles, foot_yaw, body.chains().leg, q, LEG_COLUMNS)
    others = np.setdiff1d(np.arange(25), LEG_COLUMNS)
    assert (q[:, others] == 0.123).all()
    assert ACTUATED_INDEX["knee_L"] not in others
