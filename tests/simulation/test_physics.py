"""The stage: weight is carried by feet, rays and contacts are MuJoCo's, and the rest stays put."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from sjasim.assets.names import JOINTS
from sjasim.config import BodyConfig, RobotConfig, SessionConfig
from sjasim.core import Move
from sjasim.core.errors import SjasimError
from sjasim.humans.body.anatomy import Build
from sjasim.humans.body.proportions import scaled_anatomy

from ..humans.dancing import HZ, Floor, builds, walk_cue
from ..sensors.raycast.reference_rays import occluded


def floor(count: int = 1, seconds: float = 6.0, **options) -> Floor:
    return Floor(builds(count, 2), seconds, **options)


def test_standing_feet_carry_the_weight():
    standing = floor(3).run(3.0)
    loads = standing.column("loads")[HZ:].mean(axis=0)
    assert loads == pytest.approx(standing.physics.servos.weight, rel=0.01)
    masses = [body.build.mass_kg * 9.81 for body in standing.bodies]
    assert standing.physics.servos.weight == pytest.approx(masses, rel=1e-6)


def test_what_is_felt_of_the_floor_is_the_force_of_its_contacts_and_kept_until_felt_anew():
    physics = floor(2).run(1.0).physics
    found, force = np.zeros(2), np.zeros(6)
    for index, contact in enumerate(physics.data.contact):
        owners = [physics.model.geom(geom).name for geom in contact.geom]
        dancer = [name.startswith("dancer_2") for name in owners if name != "floor"]
        mujoco.mj_contactForce(physics.model, physics.data, index, force)
        found[int(dancer[0])] += force[0]
    physics.measure_load()
    assert physics.states().load == pytest.approx(found, rel=1e-6)
    felt = physics.states().load
    physics.step_to(physics.tick + 2)
    assert physics.states().load.tolist() == felt.tolist()


def test_everybody_starts_as_planned():
    start = floor(3)
    assert start.physics.states().root[:, :3] == pytest.approx(start.reference.pelvis[:, 0])
    assert start.physics.time_s == 0.0
    assert start.physics.joints_m.shape == (3, len(JOINTS), 3)
    assert start.physics.yaw_rad == pytest.approx(np.pi / 2)
    ankles = start.physics.states().ankles
    assert ankles == pytest.approx(start.reference.ankles[:, 0], abs=1e-6)


def test_what_is_hidden_agrees_with_single_rays():
    physics = floor(3, robot=RobotConfig()).run(0.5).physics
    rng = np.random.default_rng(0)
    origin = np.array([0.3, 3.0, 1.0])
    points = rng.uniform([-1.5, -1.5, 0.05], [1.5, 1.5, 1.9], (400, 3))
    whose = rng.integers(0, 3, 400)
    told = occluded(origin, points, whose, np.zeros(400), physics.solids)
    groups = np.array([1, 1, 1, 0, 1, 1], dtype=np.uint8)
    for point, one in zip(points, told, strict=True):
        way = point - origin
        length = np.linalg.norm(way)
        single = mujoco.mj_ray(
            physics.model, physics.data, origin, way / length, groups, 1, -1, np.zeros(1, dtype=np.int32)
        )
        assert one == (0.0 <= single < length)
    assert 0.1 < told.mean() < 0.9


def test_palms_touch_at_a_clap():
    dancing = floor(seconds=4.0)
    dancing.plan(0, [walk_cue(Move.CLAP, 2.0, 0.0)], 0.0)
    physics = dancing.physics
    hands = {physics.model.geom(f"dancer_1/hand_{side}").id for side in "LR"}
    touched = []
    while dancing.tick < 3 * HZ:
        dancing.run(1 / HZ)
        pairs = [set(pair) for pair in physics.data.contact.geom]
        touched += [physics.time_s] * (hands in pairs)
    assert touched
    assert touched[0] == pytest.approx(2.0, abs=0.1)
    assert touched[-1] < 2.5


def test_a_robot_that_is_not_driven_stays_put():
    physics = floor(robot=RobotConfig()).run(3.0).physics
    x, y, heading = physics.robot_pose()
    assert (x, y) == pytest.approx(tuple(_robot_slot()), abs=2e-3)
    assert heading == pytest.approx(np.pi / 2, abs=5e-3)
    reading = physics.wheel_reading()
    assert (reading.left_rad, reading.right_rad) == pytest.approx((0.0, 0.0), abs=0.05)
    assert reading.yaw_rate_rad_s == pytest.approx(0.0, abs=0.02)


def _robot_slot():
    from sjasim.choreography.layout import layout

    return layout(SessionConfig(dancers=1)).robot


def test_it_bumps_where_a_contact_says_so():
    physics = floor(1, robot=RobotConfig()).physics
    pelvis, at = physics.states().root[0, :2], physics.model.joint("robot/root").qposadr[0]
    touched = []
    for away_m in np.arange(0.8, 0.0, -0.02):
        physics.data.qpos[at : at + 2] = pelvis[0], pelvis[1] + away_m
        mujoco.mj_forward(physics.model, physics.data)
        names = [[physics.model.geom(geom).name.partition("/")[0] for geom in one.geom] for one in physics.data.contact]
        touched.append(any({"robot", "dancer_1"} == set(pair) for pair in names))
        assert physics.contacts.robot_touches_dancer() == touched[-1]
    assert (touched[0], touched[-1]) == (False, True)


def test_who_is_let_go_falls_and_the_others_stand():
    dancing = floor(2, 8.0)
    dancing.run(0.5)
    dancing.physics.make_limp(0)
    dancing.run(2.5)
    heights = [dancing.physics.height_m(k) / body.standing_m for k, body in enumerate(dancing.bodies)]
    assert heights[0] < 0.65
    assert heights[1] > 0.95
    dancing.run(3.0)
    assert 0.0 < dancing.physics.height_m(0) < 0.45  # on the floor, not below it
    assert np.abs(dancing.physics.data.qvel).max() < 3.0


def test_a_push_moves_a_dancer_and_ends():
    dancing = floor(2)
    dancing.run(1.0)
    dancing.physics.push(0, np.array([40.0, 0.0, 0.0]))
    dancing.run(0.2)
    dancing.physics.push(0, np.zeros(3))
    moved = np.abs(dancing.physics.states().root[:, 0] - dancing.reference.pelvis[:, 0, 0])
    assert moved[0] > 3e-3
    assert moved[1] < 3e-3
    dancing.run(2.5)
    assert not dancing.fell


def test_without_a_tether_nothing_pulls():
    dancing = floor(2, body=BodyConfig(balance_support="none")).run(0.3)
    assert (dancing.column("tether") == 0).all()


def test_an_unstable_simulation_says_so():
    physics = floor().physics
    physics.data.qvel[:] = 1e9
    physics.step_to(50)
    with pytest.raises(SjasimError, match="unstable"):
        physics.check()


def test_the_time_is_ticks_over_rate():
    physics = floor().physics
    physics.step_to(5)
    assert physics.time_s == pytest.approx(5 / physics.ticks.rate_hz)
    physics.step_to(3)
    assert physics.tick == 5


@pytest.mark.parametrize("build", [Build(1.5, 50.0), Build(1.5, 100.0), Build(1.95, 50.0), Build(1.95, 100.0)], ids=str)
def test_extreme_builds_stand_still(build):
    standing = Floor([scaled_anatomy(build)], 3.0).run(2.0)
    assert not standing.fell
    assert standing.pelvis_errors()[-1] == pytest.approx(0.0, abs=0.02)
    assert np.abs(standing.physics.data.qvel).max() < 0.02  # a stiff joint on a soft floor must not quiver
