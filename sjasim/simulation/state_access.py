"""Index maps into MuJoCo's model and data, and the kernel that reads the dancers' states through them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import NamedTuple

import mujoco
import numpy as np

from ..assets.names import (
    ACTUATED,
    JOINT_INDEX,
    JOINTS,
    ROBOT_PREFIX,
    ROOT_JOINTS,
    TETHERED,
    dancer_prefix,
)
from ..core import Array, IntArray
from ..core.bodies import StateColumn
from ..core.compiled import compiled_entry
from ..humans.body.body_model import BodyModel

LOGGED_JOINTS = [JOINT_INDEX[name] for name in ("AnkleLeft", "AnkleRight", "HandLeft", "HandRight")]
"""Joints whose positions are part of a dancer's state, in the order of `StateColumn`."""


class IndexColumn(IntEnum):
    """First column of each part of `DancerIndices.kernel`."""

    PELVIS = 0
    """Body of the pelvis."""
    ROOT_BODY = 1
    """Root of the dancer's kinematic tree."""
    END_BODY = 2
    """Body after the dancer's last one."""
    ROOT_QPOS = 3
    """Coordinates of the root (6)."""
    ROOT_DOF = 9
    """Degrees of freedom of the root (6)."""
    SITES = 15
    """Sites of `LOGGED_JOINTS` (4)."""
    TETHER = 19
    """Actuators of the balance support (5); -1 without one."""


INDEX_WIDTH = 24
"""Number of columns of `DancerIndices.kernel`."""


@dataclass(frozen=True, slots=True)
class DancerIndices:
    """Where each dancer's parts are in MuJoCo's arrays. D dancers, H hinges of their body model.

    Attributes:
        pelvis: (D,) bodies.
        joint_sites: (D, 25) sites of the joints, in the order of `assets.names.JOINTS`.
        root_qpos: (D, 6) coordinates of the root: x, y, z, yaw, pitch, roll.
        root_dof: (D, 6) its degrees of freedom.
        hinge_qpos: (D, H) coordinates of the hinges.
        hinge_actuators: (D, H) their actuators.
        leading_actuators: (D, 25) actuators that stand for the planned hinges, see `BodyModel.leading`.
        tether_actuators: (D, 5) actuators of the balance support; (0, 5) without one.
        geom_owner: (all geoms,) dancer of each geom, -1 for floor and robot.
        kernel: (D, `INDEX_WIDTH`) the rows that `read_dancer_states` takes.
    """

    pelvis: IntArray
    joint_sites: IntArray
    root_qpos: IntArray
    root_dof: IntArray
    hinge_qpos: IntArray
    hinge_actuators: IntArray
    leading_actuators: IntArray
    tether_actuators: IntArray
    geom_owner: IntArray
    kernel: IntArray

    @classmethod
    def of(cls, model: mujoco.MjModel, body: BodyModel, dancers: int, *, tethered: bool) -> DancerIndices:
        """Look up the names of a compiled scene."""
        prefixes = [dancer_prefix(index) for index in range(dancers)]
        pelvis = np.array([model.body(f"{prefix}pelvis").id for prefix in prefixes])
        joint_sites = _ids(model.site, prefixes, JOINTS)
        root_qpos = np.array([[model.joint(p + name).qposadr[0] for name in ROOT_JOINTS] for p in prefixes])
        root_dof = np.array([[model.joint(p + name).dofadr[0] for name in ROOT_JOINTS] for p in prefixes])
        hinge_qpos = np.array([[model.joint(p + name).qposadr[0] for name in body.hinges] for p in prefixes])
        tether = _ids(model.actuator, prefixes if tethered else [], TETHERED).reshape(-1, len(TETHERED))

        kernel = np.full((dancers, INDEX_WIDTH), -1, dtype=np.int64)
        kernel[:, IndexColumn.PELVIS] = pelvis
        kernel[:, IndexColumn.ROOT_BODY] = model.body_rootid[pelvis]
        kernel[:, IndexColumn.END_BODY] = [_end_of_subtree(model, body_id) for body_id in pelvis]
        kernel[:, IndexColumn.ROOT_QPOS : IndexColumn.ROOT_DOF] = root_qpos
        kernel[:, IndexColumn.ROOT_DOF : IndexColumn.SITES] = root_dof
        kernel[:, IndexColumn.SITES : IndexColumn.TETHER] = joint_sites[:, LOGGED_JOINTS]
        if tethered:
            kernel[:, IndexColumn.TETHER :] = tether

        names = [model.geom(geom).name for geom in range(model.ngeom)]
        geom_owner = np.full(model.ngeom, -1, dtype=np.int64)
        for index, prefix in enumerate(prefixes):
            geom_owner[[name.startswith(prefix) for name in names]] = index

        return cls(
            pelvis=pelvis,
            joint_sites=joint_sites,
            root_qpos=root_qpos,
            root_dof=root_dof,
            hinge_qpos=hinge_qpos,
            hinge_actuators=_ids(model.actuator, prefixes, body.hinges),
            leading_actuators=_ids(model.actuator, prefixes, body.leading),
            tether_actuators=tether,
            geom_owner=geom_owner,
            kernel=kernel,
        )

    def target_actuators(self, *, planned_hinges: bool) -> tuple[IntArray, IntArray]:
        """Actuators that take the balance controller's targets directly.

        Args:
            planned_hinges: whether the body's hinges are the planned ones; else only the balance support takes targets.

        Returns:
            actuators, and the places of their values in the flattened (D, 30) targets: 25 hinges, then 5 of the balance
            support.
        """
        dancers = len(self.pelvis)
        actuators = np.full((dancers, len(ACTUATED) + len(TETHERED)), -1, dtype=np.int64)
        if planned_hinges:
            actuators[:, : len(ACTUATED)] = self.hinge_actuators
        if len(self.tether_actuators):
            actuators[:, len(ACTUATED) :] = self.tether_actuators

        places = np.flatnonzero(actuators >= 0)
        return actuators.reshape(-1)[places], places


class RobotIndices(NamedTuple):
    """Where the robot's parts are in MuJoCo's arrays.

    Attributes:
        base: body.
        left_wheel_qpos: coordinate of the left wheel's angle.
        right_wheel_qpos: the same of the right wheel.
        left_motor: actuator.
        right_motor: actuator.
        gyro_z: place of the yaw rate in ``sensordata``.
        root_qpos: first of the seven coordinates of its free joint.
        geoms: its geoms.
    """

    base: int
    left_wheel_qpos: int
    right_wheel_qpos: int
    left_motor: int
    right_motor: int
    gyro_z: int
    root_qpos: int
    geoms: IntArray

    @classmethod
    def of(cls, model: mujoco.MjModel) -> RobotIndices:
        """Look up the names of a compiled scene with a robot."""
        names = [model.geom(geom).name for geom in range(model.ngeom)]
        return cls(
            base=model.body(f"{ROBOT_PREFIX}base").id,
            left_wheel_qpos=int(model.joint(f"{ROBOT_PREFIX}wheel_l").qposadr[0]),
            right_wheel_qpos=int(model.joint(f"{ROBOT_PREFIX}wheel_r").qposadr[0]),
            left_motor=model.actuator(f"{ROBOT_PREFIX}wheel_l").id,
            right_motor=model.actuator(f"{ROBOT_PREFIX}wheel_r").id,
            gyro_z=int(model.sensor(f"{ROBOT_PREFIX}gyro").adr[0]) + 2,
            root_qpos=int(model.joint(f"{ROBOT_PREFIX}root").qposadr[0]),
            geoms=np.flatnonzero([name.startswith(ROBOT_PREFIX) for name in names]),
        )


def _ids(lookup: object, prefixes: Sequence[str], names: Sequence[str]) -> IntArray:
    """(D, N) numbers of named parts of every dancer."""
    ids = [[lookup(prefix + name).id for name in names] for prefix in prefixes]  # type: ignore[operator]
    return np.array(ids, dtype=np.int64)


def _end_of_subtree(model: mujoco.MjModel, body: int) -> int:
    """First body after the subtree of a body; MuJoCo numbers a subtree without gaps."""
    end = body + 1
    while end < model.nbody and model.body_parentid[end] >= body:
        end += 1
    return end


@compiled_entry
def read_dancer_states(
    qpos: Array,
    qvel: Array,
    subtree_com: Array,
    cvel: Array,
    xipos: Array,
    site_xpos: Array,
    actuator_force: Array,
    masses: Array,
    parents: IntArray,
    load: Array,
    indices: IntArray,
    momentum: Array,
    out: Array,
) -> None:
    """Write every dancer's state.

    The velocity of the centre of mass equals that of MuJoCo's ``mj_subtreeVel`` to the last bit, without its sums over
    the other bodies of the scene.

    Args:
        qpos: coordinates.
        qvel: velocities.
        subtree_com: (B, 3) centres of mass of the bodies' subtrees [m].
        cvel: (B, 6) spatial velocities of the bodies about the centre of mass of their root's subtree.
        xipos: (B, 3) centres of mass of the bodies [m].
        site_xpos: (S, 3) sites [m].
        actuator_force: forces of the actuators.
        masses: (B + D,) masses of the bodies, then of the dancers [kg].
        parents: (B,) parent of each body.
        load: (D,) what the floor carries of each dancer [N].
        indices: (D, `INDEX_WIDTH`) see `DancerIndices.kernel`.
        momentum: (B, 3) work space.
        out: (D, `DANCER_STATE_WIDTH`) output, see `StateColumn`.
    """
    for d in range(len(indices)):
        pelvis = indices[d, IndexColumn.PELVIS]
        root = indices[d, IndexColumn.ROOT_BODY]
        end = indices[d, IndexColumn.END_BODY]

        # Linear momentum of each body, summed from the leaves to the pelvis in MuJoCo's own order.
        for b in range(pelvis, end):
            x = xipos[b, 0] - subtree_com[root, 0]
            y = xipos[b, 1] - subtree_com[root, 1]
            z = xipos[b, 2] - subtree_com[root, 2]
            momentum[b, 0] = (cvel[b, 3] - (y * cvel[b, 2] - z * cvel[b, 1])) * masses[b]
            momentum[b, 1] = (cvel[b, 4] - (z * cvel[b, 0] - x * cvel[b, 2])) * masses[b]
            momentum[b, 2] = (cvel[b, 5] - (x * cvel[b, 1] - y * cvel[b, 0])) * masses[b]
        for b in range(end - 1, pelvis, -1):
            for k in range(3):
                momentum[parents[b], k] += momentum[b, k]

        inverse_mass = 1.0 / masses[len(parents) + d]
        for k in range(3):
            out[d, StateColumn.COM + k] = subtree_com[pelvis, k]
            out[d, StateColumn.COM_VELOCITY + k] = momentum[pelvis, k] * inverse_mass
            for site in range(4):
                out[d, StateColumn.ANKLES + 3 * site + k] = site_xpos[indices[d, IndexColumn.SITES + site], k]
        for k in range(6):
            out[d, StateColumn.ROOT + k] = qpos[indices[d, IndexColumn.ROOT_QPOS + k]]
            out[d, StateColumn.ROOT_VELOCITY + k] = qvel[indices[d, IndexColumn.ROOT_DOF + k]]
        for k in range(5):
            actuator = indices[d, IndexColumn.TETHER + k]
            out[d, StateColumn.TETHER + k] = actuator_force[actuator] if actuator >= 0 else 0.0
        out[d, StateColumn.LOAD] = load[d]
