"""Where robot and dancers touch, read out of the physics."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ..core import Array, BoolArray, IntArray

_SHELL, _FLESH = 1, 2
"""On whose side a geom is: the robot's or a dancer's; 0 for the floor."""


@njit(cache=True)
def _near(positions: Array, flesh: IntArray, bounds: Array, com: Array, body: int, reach_m: float) -> bool:
    """Whether a ball about one of the dancers' geoms reaches into the one about the robot.

    Args:
        positions: (G, 3) of all geoms [m].
        flesh: (N,) which of them are the dancers'.
        bounds: (G,) radii of the balls about them [m].
        com: (B, 3) where the centre of mass of each body with its children is [m].
        body: the robot's: the middle of its ball.
        reach_m: the radius of its ball.
    """
    for geom in flesh:
        square = 0.0
        for axis in range(3):
            square += (positions[geom, axis] - com[body, axis]) ** 2
        if square <= (bounds[geom] + reach_m) ** 2:
            return True
    return False


@njit(cache=True)
def _meet(pairs: NDArray[np.int32], side: NDArray[np.int8]) -> BoolArray:
    """(C,) which contacts (C, 2) are of the robot with a dancer."""
    out = np.empty(len(pairs), dtype=np.bool_)
    for k in range(len(pairs)):
        out[k] = side[pairs[k, 0]] + side[pairs[k, 1]] == _SHELL + _FLESH
    return out


class Contacts:
    """The robot's contacts with dancers.

    Args:
        model: MuJoCo's.
        data: its state, at the start.
        shell: the robot's geoms; none without a robot.
        flesh: the dancers' geoms.
        base: the robot's body.
    """

    def __init__(self, model: Any, data: Any, shell: IntArray, flesh: IntArray, base: int) -> None:
        self._data, self._base, self._flesh = data, base, flesh
        self._side = np.zeros(model.ngeom, dtype=np.int8)
        self._side[shell], self._side[flesh] = _SHELL, _FLESH
        self._positions, self._com, self._bounds = data.geom_xpos, data.subtree_com, model.geom_rbound.copy()
        away_m = np.sqrt(((data.geom_xpos[shell] - data.subtree_com[base]) ** 2).sum(axis=1))
        self._hull_m = float((away_m + self._bounds[shell]).max(initial=-np.inf))

    def robot_touches_dancer(self) -> bool:
        """Whether the robot touches a dancer at this moment."""
        if not _near(self._positions, self._flesh, self._bounds, self._com, self._base, self._hull_m):
            return False  # reading MuJoCo's list of contacts costs much more than this
        return bool(_meet(self._data.contact.geom, self._side).any())

    def impact_n(self) -> float:
        """How hard the robot and dancers press on each other at this moment: the sum of their contacts' forces [N]."""
        contact = self._data.contact
        starts = contact.efc_address[_meet(contact.geom, self._side) & (contact.efc_address >= 0)]
        return float(sum(self._data.efc_force[start : start + 4].sum() for start in starts))
