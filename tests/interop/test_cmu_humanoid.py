"""The CMU humanoid as a dancer: its model agrees with its tables, and it dances as sjasim's own body does."""

from __future__ import annotations

import subprocess
import sys

import gymnasium as gym
import numpy as np
import pytest

import sjasim
from sjasim.assets.names import ACTUATED, ACTUATED_INDEX, FLOOR_BIT, JOINTS, ROOT_JOINTS, TETHERED
from sjasim.config import BodyConfig, DanceConfig
from sjasim.core import registry
from sjasim.core.errors import PluginError
from sjasim.humans.body.anatomy import Build
from sjasim.humans.body.body_model import body_model
from sjasim.humans.body.kinematics import com_offsets, joint_positions
from sjasim.humans.motion.arms import arm_poses

BUILDS = (Build(), Build(1.60, 58.0), Build(1.85, 88.0))


@pytest.fixture(scope="module")
def body():
    pytest.importorskip("dm_control", reason="dm-control is not installed (Python 3.13 and newer have none)")
    return body_model("cmu")


class Posed:
    """A compiled humanoid in a planned posture, with the pelvis at (1.0, 2.0, 0.9) m and the heading 0.7 rad."""

    def __init__(self, body, build, planned):
        import mujoco

        self.tables = body.anatomy(build)
        self.model = body.spec(self.tables, 0, 3, BodyConfig()).compile()
        self.data = mujoco.MjData(self.model)
        for name, angle in zip(body.hinges, body.angles(planned[None])[0], strict=True):
            self.data.joint(name).qpos[0] = angle
        for name, value in zip(ROOT_JOINTS, (1.0, 2.0, 0.9, 0.7, 0.0, 0.0), strict=True):
            self.data.joint(name).qpos[0] = value
        mujoco.mj_forward(self.model, self.data)


def postures():
    """Zero angles and three random postures, without roll of the ankles, which it lacks, and with bent knees."""
    rng = np.random.default_rng(0)
    rows = [np.zeros(25), *rng.uniform(-0.5, 0.5, (3, 25))]
    for row in rows:
        for side in "LR":
            row[ACTUATED_INDEX[f"ankle_x_{side}"]] = 0.0
            row[ACTUATED_INDEX[f"knee_{side}"]] = abs(row[ACTUATED_INDEX[f"knee_{side}"]]) + 0.02
    return rows


@pytest.mark.parametrize("build", BUILDS, ids=lambda build: f"{build.stature_m} m")
@pytest.mark.parametrize("planned", postures())
def test_joints_and_centre_of_mass_are_where_the_tables_put_them(body, build, planned):
    posed = Posed(body, build, planned)
    there = np.array([posed.data.site(name).xpos for name in JOINTS])
    chains = posed.tables.chains()
    assert np.allclose(there, joint_positions(chains, planned, np.array([1.0, 2.0, 0.9]), 0.7), atol=1e-6)
    offset = com_offsets(chains, planned[None], np.array([0.7]))[0]
    assert np.allclose(posed.data.subtree_com[1], np.array([1.0, 2.0, 0.9]) + offset, atol=1e-6)


@pytest.mark.parametrize("build", BUILDS, ids=lambda build: f"{build.stature_m} m")
def test_stature_and_mass_are_those_of_the_build_and_the_soles_are_flat(body, build):
    posed = Posed(body, build, np.zeros(25))
    model, data = posed.model, posed.data
    assert model.body_subtreemass[0] == pytest.approx(build.mass_kg)
    head = model.geom("head")
    low = 0.9 - posed.tables.ankle_m - posed.tables.thigh_m - posed.tables.shank_m
    assert data.geom("head").xpos[2] + head.size[0] + head.size[1] - low == pytest.approx(build.stature_m)
    soles = [index for index in range(model.ngeom) if model.geom_conaffinity[index] & FLOOR_BIT]
    assert {model.geom(index).name[1:5] for index in soles} == {"foot", "toes"}
    for side in "lr":
        toes = data.geom(f"{side}toes0").xpos[2] - model.geom(f"{side}toes0").size[0]
        assert toes == pytest.approx(low, abs=0.003)


def test_every_hinge_has_a_servo_and_every_planned_hinge_a_leading_one(body):
    model = body.spec(body.anatomy(Build()), 0, 1, BodyConfig()).compile()
    names = {model.actuator(index).name for index in range(model.nu)}
    assert names == {*body.hinges, *TETHERED}
    assert len(body.hinges) == 56
    assert len(body.leading) == len(ACTUATED) == len(set(body.leading))
    assert set(body.leading) <= set(body.hinges)
    bare = body.spec(body.anatomy(Build()), 0, 1, BodyConfig(balance_support="none")).compile()
    assert bare.nu == 56


def test_palms_meet_in_a_clap(body):
    for pose, gap in ((arm_poses("cmu").closed, (-0.02, 0.0)), (arm_poses("cmu").open, (0.3, 0.6))):
        planned = np.zeros(25)
        for name, angle in zip(("shoulder_y", "shoulder_x", "shoulder_z", "elbow"), pose, strict=True):
            planned[[ACTUATED_INDEX[f"{name}_L"], ACTUATED_INDEX[f"{name}_R"]]] = angle
        posed = Posed(body, Build(), planned)
        left, right = (posed.data.site(f"Hand{word}").xpos for word in ("Left", "Right"))
        assert gap[0] < np.linalg.norm(left - right) - 2 * posed.tables.hand_half_m < gap[1]
        palms = [posed.data.body(f"{side}hand").xmat.reshape(3, 3)[:, 2] for side in "lr"]
        assert palms[0] @ palms[1] < -0.7


def test_an_environment_can_use_it(body):
    assert "cmu" in registry.names("body")
    env = gym.make("sjasim/Dance-v0", body={"model": "cmu"}, dance={"rehearsal": False}, disable_env_checker=True)
    observation, _ = env.reset(seed=4)
    for _ in range(15):
        observation, *_ = env.step(0)
    assert all(np.isfinite(part).all() for part in observation.values())
    physics = env.unwrapped.session.world.physics
    assert (physics.joints_m[:, JOINTS.index("SpineBase"), 2] > 0.75).all()
    assert physics.model.nu == 3 * 61 + 2
    env.close()


@pytest.mark.slow
@pytest.mark.parametrize("seed", [5011, 5012, 5013])
def test_it_dances_an_iteration_without_falls_and_is_detected(body, seed):
    config = sjasim.SessionConfig(
        method="sia",
        sensing="joints",
        iterations=1,
        seed=seed,
        dance=DanceConfig(rehearsal=False),
        body=BodyConfig(model="cmu"),
    )
    log = sjasim.run_session(config)
    figures = sjasim.measures(log)
    assert figures.bodies.falls == 0
    assert figures.bodies.feet_load_share > 0.97
    assert figures.bodies.tether_rms_n < 25.0
    assert figures.detector.recall >= 0.9
    assert figures.detector.precision >= 0.9
    from_first_frame = ("spine_seen", "hands_seen")  # NaN before it
    assert all(np.isfinite(column).all() for name, column in log.truth.items() if name not in from_first_frame)
    planned = sum(len(cue.events()) for cue in log.cues if cue.move != "turn")
    assert abs(figures.detector.true - planned) <= 0.1 * planned


def test_without_dm_control_the_error_says_so_in_one_line(monkeypatch):
    probe = (
        "import sys; sys.modules['dm_control'] = None\n"
        "from sjasim.humans.body.body_model import body_model\n"
        "try:\n body_model('cmu')\nexcept Exception as e: print(type(e).__name__, e)"
    )
    answer = subprocess.run([sys.executable, "-c", probe], capture_output=True, text=True, check=True)
    assert answer.stdout.startswith(f"{PluginError.__name__} body 'cmu': sjasim.interop needs dm_control")
    assert answer.stdout.count("\n") == 1
