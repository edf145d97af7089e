"""Contacts of robot and dancers, compared with MuJoCo's list of contacts."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from sjasim.config import RobotConfig


def move_robot(physics, x_m: float, y_m: float) -> None:
    """Put the robot somewhere, and compute contacts without a physics step."""
    root = physics.model.joint("robot/root").qposadr[0]
    physics.data.qpos[root : root + 2] = x_m, y_m
    mujoco.mj_forward(physics.model, physics.data)


def robot_dancer_contacts(physics) -> list[int]:
    """Indices of MuJoCo's contacts between the robot and the first dancer."""
    found = []
    for index, contact in enumerate(physics.data.contact):
        owners = {physics.model.geom(geom).name.partition("/")[0] for geom in contact.geom}
        if owners == {"robot", "dancer_1"}:
            found.append(index)
    return found


def test_touch_and_force_agree_with_mujocos_contacts(make_floor):
    physics = make_floor(1, robot=RobotConfig()).physics
    pelvis_m = physics.states().root[0, :2]
    force = np.zeros(6)
    touched = []
    for distance_m in np.arange(0.8, 0.0, -0.02):
        move_robot(physics, pelvis_m[0], pelvis_m[1] + distance_m)
        contacts = robot_dancer_contacts(physics)
        touched.append(bool(contacts))
        assert physics.contacts.robot_touches_dancer() == touched[-1]

        normal_n = 0.0
        for index in contacts:
            mujoco.mj_contactForce(physics.model, physics.data, index, force)
            normal_n += force[0]
        assert physics.contacts.contact_force_n() == pytest.approx(normal_n, rel=1e-9)
    assert (touched[0], touched[-1]) == (False, True)


def test_without_a_robot_nothing_touches(make_floor):
    physics = make_floor(2).run(0.2).physics
    assert len(physics.data.contact) > 0
    assert not physics.contacts.robot_touches_dancer()
    assert physics.contacts.contact_force_n() == 0.0
