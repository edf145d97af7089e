"""Tests of the robot in physics: mass, contacts, accuracy of its motion, and forces on a leg."""

from __future__ import annotations

import math
from dataclasses import replace

import mujoco
import numpy as np
import pytest

from sjasim.assets.names import FLOOR_BIT, ROBOT_BIT, ROBOT_PREFIX, dancer_bit
from sjasim.config import RobotConfig
from sjasim.core import Kind, Move

HALF_DEGREE, DEGREE = math.radians(0.5), math.radians(1.0)


def add_leg(at_m: float, mass: float | None = None):
    """Function that adds a shank at an x: fixed, or sliding along x with a mass."""

    def add_to_scene(scene: mujoco.MjSpec) -> None:
        leg = scene.worldbody.add_body(name="leg", pos=[at_m, 0, 0.26])
        if mass is not None:
            leg.add_joint(name="leg", type=mujoco.mjtJoint.mjJNT_SLIDE, axis=[1, 0, 0])
        leg.add_geom(
            name="leg", type=mujoco.mjtGeom.mjGEOM_CAPSULE, size=[0.05, 0.2, 0], mass=mass or 1.0,
            contype=dancer_bit(0), conaffinity=ROBOT_BIT,
        )  # fmt: skip

    return add_to_scene


def peak_force(rig, seconds: float) -> float:
    """Largest sum of normal forces on the leg [N]."""
    leg, force, peak = rig.model.geom("leg").id, np.zeros(6), 0.0
    for _ in range(round(seconds * rig.ticks.rate_hz)):
        rig.run(1 / rig.ticks.rate_hz)
        total = 0.0
        for index, contact in enumerate(rig.data.contact):
            if leg in (contact.geom1, contact.geom2):
                mujoco.mj_contactForce(rig.model, rig.data, index, force)
                total += force[0]
        peak = max(peak, total)
    return peak


def test_mass_and_names(rig):
    assert rig.model.body(ROBOT_PREFIX + "base").subtreemass[0] == pytest.approx(6.3)
    names = {rig.model.actuator(i).name for i in range(rig.model.nu)}
    assert names == {ROBOT_PREFIX + "wheel_l", ROBOT_PREFIX + "wheel_r"}
    assert rig.model.sensor(ROBOT_PREFIX + "gyro").dim[0] == 3
    assert rig.model.joint(ROBOT_PREFIX + "root").type[0] == mujoco.mjtJoint.mjJNT_FREE


def test_mass_follows_the_configuration(make_rig):
    model = make_rig(RobotConfig(mass_kg=9.0)).model
    assert model.body(ROBOT_PREFIX + "base").subtreemass[0] == pytest.approx(9.0)


def test_parts_collide_with_the_floor_and_the_dancers_only(rig):
    assert rig.model.ngeom > 20
    for index in range(rig.model.ngeom):
        geom = rig.model.geom(index)
        if geom.name == "floor" or geom.name.endswith("bumper"):
            continue
        assert geom.contype[0] == ROBOT_BIT
        assert geom.conaffinity[0] & FLOOR_BIT
        assert all(geom.conaffinity[0] & dancer_bit(dancer) for dancer in range(8))
        assert not geom.conaffinity[0] & ROBOT_BIT


def test_it_stands_still_and_level(rig):
    before = rig.true_pose()
    rig.run(1.0)
    assert rig.true_pose() == pytest.approx(before, abs=1e-5)
    assert abs(rig.data.qpos[2]) < 1e-3
    assert rig.events == []


@pytest.mark.parametrize(("move", "sign"), [(Move.FORWARD, 1), (Move.BACKWARD, -1)])
def test_straight_distance(rig, order, move, sign):
    rig.send(order(1, move))
    rig.run(2.0)
    assert rig.true_velocity()[0] == pytest.approx(sign * 0.25, rel=0.005)  # no droop
    rig.send(order(2, Move.STOP))
    rig.run(1.0)
    x, y, heading = rig.true_pose()
    assert x == pytest.approx(sign * 0.5, abs=0.005)
    assert abs(y) < 1e-3
    assert abs(heading) < math.radians(0.05)
    assert rig.state.x_m == pytest.approx(x, abs=0.002)


def test_wheels_slip_less_than_one_per_cent(rig, order):
    rig.send(order(1, Move.FORWARD, speed=0.5))
    rig.run(1.0)
    rig.send(order(2, Move.STOP))
    rig.run(1.0)
    rolled = sum(rig.wheel_angles()) / 2 * rig.config.wheel_radius_m
    assert rolled == pytest.approx(rig.true_pose()[0], rel=0.01)
    left, right = rig.wheel_angles()
    rig.send(order(3, Move.TURN, heading=math.pi / 2))
    rig.run(2.0)
    after = rig.wheel_angles()
    turned = (after[1] - right - after[0] + left) * rig.config.wheel_radius_m / rig.config.wheel_separation_m
    assert turned == pytest.approx(rig.true_pose()[2], rel=0.01)


def test_four_quarter_turns_each_within_a_degree(rig, order):
    for quarter in range(1, 5):
        sent = rig.send(order(quarter, Move.TURN, heading=quarter * math.pi / 2))
        rig.run(1.9)
        assert rig.true_pose()[2] == pytest.approx(quarter * math.pi / 2, abs=DEGREE)
        assert rig.state.heading_rad == pytest.approx(quarter * math.pi / 2, abs=HALF_DEGREE)
        assert abs(rig.true_velocity()[1]) < 0.02
        assert rig.events[-1][1] - sent == pytest.approx(0.30, abs=0.03)
    assert [kind for kind, _ in rig.events] == [Kind.TURN] * 4
    x, y, _ = rig.true_pose()
    assert math.hypot(x, y) < 0.005


def test_latency_from_command_to_event(rig, order):
    sent = [rig.send(order(1, Move.FORWARD))]
    for number, move in enumerate((Move.STOP, Move.BACKWARD, Move.STOP), start=2):
        rig.run(1.5)
        sent.append(rig.send(order(number, move)))
    rig.run(1.0)
    kinds = [kind for kind, _ in rig.events]
    assert kinds == [Kind.START_FORWARD, Kind.STOP_FORWARD, Kind.START_BACKWARD, Kind.STOP_BACKWARD]
    delays = [t - t_sent for (_, t), t_sent in zip(rig.events, sent, strict=True)]
    assert delays == pytest.approx([0.29, 0.33, 0.29, 0.33], abs=0.025)


def test_a_lost_link_stops_the_base(rig, order):
    rig.heartbeats = False
    rig.send(order(1, Move.FORWARD))
    rig.run(2.0)
    assert rig.controller.timed_out
    assert abs(rig.true_velocity()[0]) < 1e-3
    assert [kind for kind, _ in rig.events] == [Kind.START_FORWARD, Kind.STOP_FORWARD]


def test_calibration_errors_change_odometry_and_not_the_true_motion(make_rig):
    truth = []
    estimates = []
    for error in (0.0, 0.03):
        config = replace(RobotConfig(), wheel_radius_error=error, gyro_bias_rad_s=error)
        rig = make_rig(config)
        rig.drive = (0.25, 0.0)
        rig.run(1.5)
        truth.append(rig.truth[-1])
        estimates.append((rig.state.x_m, rig.state.heading_rad))
    assert truth[0] == truth[1]
    assert estimates[1][0] == pytest.approx(1.03 * estimates[0][0], rel=0.003)
    assert estimates[1][1] - estimates[0][1] == pytest.approx(0.03 * 1.8, rel=0.03)


def test_running_into_a_leg_is_soft_and_reported_as_blocked(make_rig, order):
    rig = make_rig(add_to_scene=add_leg(0.4))
    rig.send(order(1, Move.FORWARD, speed=0.5))
    assert 20.0 < peak_force(rig, 2.0) < 400.0
    assert rig.controller.blocked
    assert rig.true_pose()[0] < 0.2
    rig.send(order(2, Move.STOP))
    rig.run(1.0)
    assert not rig.controller.blocked


def test_a_leg_that_walks_into_the_robot_pushes_it(make_rig):
    rig = make_rig(add_to_scene=add_leg(0.4, mass=60.0))
    rig.data.joint("leg").qvel[0] = -1.0
    assert peak_force(rig, 0.6) < 500.0
    assert rig.true_pose()[0] < -0.05
    rotation = rig.data.body(ROBOT_PREFIX + "base").xmat
    assert math.degrees(math.acos(rotation[8])) < 20.0
