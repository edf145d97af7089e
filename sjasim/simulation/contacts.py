"""Contacts between the robot and the dancers, read from MuJoCo's state."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..core import Array, BoolArray, IntArray
from ..core.compiled import compiled_entry

ROBOT_CODE = 1
"""Code of the robot's geoms; other geoms, such as the floor, have the code 0."""

DANCER_CODE = 2
"""Code of the dancers' geoms. A contact of robot and dancer is one whose two codes add up to 3."""


@compiled_entry
def _spheres_overlap(
    positions: Array, dancer_geoms: IntArray, radii: Array, com: Array, base: int, robot_radius_m: float
) -> bool:
    """Whether the bounding sphere of any of the dancers' geoms overlaps that of the robot.

    Args:
        positions: (G, 3) positions of all geoms [m].
        dancer_geoms: (N,) indices of the dancers' geoms.
        radii: (G,) radii of the bounding spheres of all geoms [m].
        com: (B, 3) centres of mass of the subtrees of all bodies [m].
        base: the robot's body, whose centre of mass is the centre of the robot's sphere.
        robot_radius_m: radius of the robot's sphere.
    """
    for geom in dancer_geoms:
        square = 0.0
        for axis in range(3):
            square += (positions[geom, axis] - com[base, axis]) ** 2
        if square <= (radii[geom] + robot_radius_m) ** 2:
            return True
    return False


@compiled_entry
def _robot_dancer_contacts(pairs: NDArray[np.int32], codes: NDArray[np.int8]) -> BoolArray:
    """Return whether each contact is between the robot and a dancer.

    Args:
        pairs: (C, 2) geoms of each contact.
        codes: (G,) code of each geom.

    Returns:
        (C,) booleans.
    """
    out = np.empty(len(pairs), dtype=np.bool_)
    for k in range(len(pairs)):
        out[k] = codes[pairs[k, 0]] + codes[pairs[k, 1]] == ROBOT_CODE + DANCER_CODE
    return out


class Contacts:
    """Contacts between the robot and the dancers.

    Args:
        model: MuJoCo's model.
        data: MuJoCo's state in the initial pose.
        robot_geoms: indices of the robot's geoms; empty without a robot.
        dancer_geoms: indices of the dancers' geoms.
        base: the robot's body; any body without a robot.
    """

    def __init__(self, model: Any, data: Any, robot_geoms: IntArray, dancer_geoms: IntArray, base: int) -> None:
        self._data = data
        self._base = base
        self._dancer_geoms = dancer_geoms
        self._codes = np.zeros(model.ngeom, dtype=np.int8)
        self._codes[robot_geoms] = ROBOT_CODE
        self._codes[dancer_geoms] = DANCER_CODE

        self._positions = data.geom_xpos
        self._com = data.subtree_com
        self._radii = model.geom_rbound.copy()
        distance_m = np.sqrt(((data.geom_xpos[robot_geoms] - data.subtree_com[base]) ** 2).sum(axis=1))
        # Without a robot the radius is -inf. Its square is infinite, but the list of contacts has none of a robot.
        self._robot_radius_m = float((distance_m + self._radii[robot_geoms]).max(initial=-np.inf))

    def robot_touches_dancer(self) -> bool:
        """Whether the robot is in contact with a dancer at this tick."""
        # MuJoCo's list of contacts is expensive to read, so it is only read when robot and dancer are close.
        if not _spheres_overlap(
            self._positions, self._dancer_geoms, self._radii, self._com, self._base, self._robot_radius_m
        ):
            return False
        return bool(_robot_dancer_contacts(self._data.contact.geom, self._codes).any())

    def contact_force_n(self) -> float:
        """Sum of the normal forces between the robot and the dancers at this tick [N]."""
        contact = self._data.contact
        selected = _robot_dancer_contacts(contact.geom, self._codes) & (contact.efc_address >= 0)
        starts = contact.efc_address[selected]

        # A contact has four constraint forces, along the edges of its friction pyramid. Their sum is the normal force.
        return float(sum(self._data.efc_force[start : start + 4].sum() for start in starts))
