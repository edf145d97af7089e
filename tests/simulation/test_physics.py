"""Physics of a scene: loads and contacts agree with MuJoCo's, dancers stand and clap, the robot stays in place."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from sjasim.assets.names import JOINTS
from sjasim.choreography.layout import layout
from sjasim.config import BodyConfig, RobotConfig, SessionConfig
from sjasim.core import Move
from sjasim.core.errors import SjasimError
from sjasim.humans.body.anatomy import Build
from sjasim.humans.body.proportions import scaled_anatomy

from ..humans.dancing import HZ, Floor, walk_cue
from ..sensors.raycast.reference_rays import occluded


def test_feet_of_standing_dancers_carry_their_weight(make_floor):
    standing = make_floor(3).run(3.0)
    weights_n = [body.build.mass_kg * 9.81 for body in standing.bodies]
    assert standing.physics.servos.weight == pytest.approx(weights_n, rel=1e-6)
    mean_loads_n = standing.column("loads")[HZ:].mean(axis=0)
    assert mean_loads_n == pytest.approx(weights_n, rel=0.01)


def test_measured_load_is_the_force_of_the_floor_contacts_and_stays_until_it_is_measured_again(make_floor):
    physics = make_floor(2).run(1.0).physics
    expected_n = np.zeros(2)
    force = np.zeros(6)
    for index, contact in enumerate(physics.data.contact):
        names = [physics.model.geom(geom).name for geom in contact.geom]
        (dancer,) = [name for name in names if name != "floor"]
        mujoco.mj_contactForce(physics.model, physics.data, index, force)
        expected_n[int(dancer.startswith("dancer_2"))] += force[0]

    physics.measure_load()
    load_n = physics.states().load
    assert load_n == pytest.approx(expected_n, rel=1e-6)

    physics.step_to(physics.tick + 2)
    assert physics.states().load.tolist() == load_n.tolist()


def test_initial_pose_is_the_planned_one(make_floor):
    floor = make_floor(3)
    states = floor.physics.states()
    assert floor.physics.time_s == 0.0
    assert floor.physics.joints_m.shape == (3, len(JOINTS), 3)
    assert floor.physics.yaw_rad == pytest.approx(np.pi / 2)
    assert states.root[:, :3] == pytest.approx(floor.reference.pelvis[:, 0])
    assert states.ankles == pytest.approx(floor.reference.ankles[:, 0], abs=1e-6)


def test_occlusion_of_points_agrees_with_mujocos_rays(make_floor):
    physics = make_floor(3, robot=RobotConfig()).run(0.5).physics
    rng = np.random.default_rng(0)
    origin = np.array([0.3, 3.0, 1.0])
    points = rng.uniform([-1.5, -1.5, 0.05], [1.5, 1.5, 1.9], (400, 3))
    owners = rng.integers(0, 3, 400)
    results = occluded(origin, points, owners, np.zeros(400), physics.solids)

    # Group 3 holds geoms that only collide; sensors do not see them.
    groups = np.array([1, 1, 1, 0, 1, 1], dtype=np.uint8)
    geom = np.zeros(1, dtype=np.int32)
    for point, is_occluded in zip(points, results, strict=True):
        ray = point - origin
        length = np.linalg.norm(ray)
        distance = mujoco.mj_ray(physics.model, physics.data, origin, ray / length, groups, 1, -1, geom)
        assert is_occluded == (0.0 <= distance < length)
    assert 0.1 < results.mean() < 0.9


def test_hands_touch_at_a_clap(make_floor):
    floor = make_floor(seconds=4.0)
    floor.plan(0, [walk_cue(Move.CLAP, 2.0, 0.0)], 0.0)
    physics = floor.physics
    hands = {physics.model.geom(f"dancer_1/hand_{side}").id for side in "LR"}
    touched_s = []
    while floor.tick < 3 * HZ:
        floor.run(1 / HZ)
        if hands in [set(pair) for pair in physics.data.contact.geom]:
            touched_s.append(physics.time_s)
    assert touched_s
    assert touched_s[0] == pytest.approx(2.0, abs=0.1)
    assert touched_s[-1] < 2.5


def test_a_robot_without_commands_stays_in_place(make_floor):
    physics = make_floor(robot=RobotConfig()).run(3.0).physics
    slot = layout(SessionConfig(dancers=1)).robot
    x_m, y_m, heading_rad = physics.robot_pose()
    assert (x_m, y_m) == pytest.approx(tuple(slot), abs=2e-3)
    assert heading_rad == pytest.approx(np.pi / 2, abs=5e-3)
    reading = physics.wheel_reading()
    assert (reading.left_rad, reading.right_rad) == pytest.approx((0.0, 0.0), abs=0.05)
    assert reading.yaw_rate_rad_s == pytest.approx(0.0, abs=0.02)


def test_a_scene_without_a_robot_has_no_robot_to_read(make_floor):
    physics = make_floor().physics
    assert not physics.has_robot
    for read in (physics.robot_pose, physics.wheel_reading):
        with pytest.raises(SjasimError, match="no robot"):
            read()


def test_a_limp_dancer_falls_and_the_others_stand(make_floor):
    floor = make_floor(2, 8.0)
    floor.run(0.5)
    floor.physics.make_limp(0)
    floor.run(2.5)
    shares = [floor.physics.height_m(k) / body.standing_m for k, body in enumerate(floor.bodies)]
    assert shares[0] < 0.65
    assert shares[1] > 0.95

    # The body comes to rest on the floor, neither above nor below it.
    floor.run(3.0)
    assert 0.0 < floor.physics.height_m(0) < 0.45
    assert np.abs(floor.physics.data.qvel).max() < 3.0


def test_a_push_moves_one_dancer_who_recovers(make_floor):
    floor = make_floor(2)
    floor.run(1.0)
    floor.physics.push(0, np.array([40.0, 0.0, 0.0]))
    floor.run(0.2)
    floor.physics.push(0, np.zeros(3))
    moved_m = np.abs(floor.physics.states().root[:, 0] - floor.reference.pelvis[:, 0, 0])
    assert moved_m[0] > 3e-3
    assert moved_m[1] < 3e-3
    floor.run(2.5)
    assert not floor.fell


def test_without_balance_support_its_forces_are_zero(make_floor):
    floor = make_floor(2, body=BodyConfig(balance_support="none")).run(0.3)
    forces = floor.column("support")
    assert forces.shape[:2] == (round(0.3 * HZ), 2)
    assert (forces == 0).all()


def test_an_unstable_simulation_raises(make_floor):
    physics = make_floor().physics
    physics.check()
    physics.data.qvel[:] = 1e9
    physics.step_to(50)
    with pytest.raises(SjasimError, match="unstable"):
        physics.check()


def test_time_is_ticks_over_rate_and_never_goes_back(make_floor):
    physics = make_floor().physics
    physics.step_to(5)
    assert physics.time_s == pytest.approx(5 / physics.ticks.rate_hz)
    physics.step_to(3)
    assert physics.tick == 5


@pytest.mark.parametrize("build", [Build(1.5, 50.0), Build(1.5, 100.0), Build(1.95, 50.0), Build(1.95, 100.0)], ids=str)
def test_extreme_builds_stand_still(build):
    floor = Floor([scaled_anatomy(build)], 3.0).run(2.0)
    assert not floor.fell
    assert floor.pelvis_errors()[-1] == pytest.approx(0.0, abs=0.02)
    # A stiff joint on a soft floor could oscillate.
    assert np.abs(floor.physics.data.qvel).max() < 0.02
