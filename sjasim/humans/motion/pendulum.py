"""The linear inverted pendulum: centre of mass and divergent component of motion over a zero-moment point.

Source: englsberger2015, section III (divergent component of motion).
"""

from __future__ import annotations

import numpy as np

from ...core import Array
from ...core.compiled import compiled_entry


@compiled_entry
def bounded_com(zmp: Array, omega_dt: float, first: Array) -> Array:
    """(T, 2) motion of the centre of mass that stays bounded over a path of the zero-moment point [m].

    The divergent component is integrated backward from the last row, where the pendulum rests, and the centre of mass
    forward from the first; both integrations are stable.

    Args:
        zmp: (T, 2) zero-moment point [m].
        omega_dt: rate of the pendulum times the time between rows.
        first: (2,) centre of mass in the first row [m].
    """
    n = len(zmp)
    decay = np.exp(-omega_dt)
    dcm = np.empty_like(zmp)
    com = np.empty_like(zmp)

    for k in range(2):
        dcm[n - 1, k] = zmp[n - 1, k]
        for i in range(n - 2, -1, -1):
            dcm[i, k] = zmp[i + 1, k] + (dcm[i + 1, k] - zmp[i + 1, k]) * decay

        com[0, k] = first[k]
        for i in range(1, n):
            com[i, k] = dcm[i, k] + (com[i - 1, k] - dcm[i, k]) * decay

    return com


@compiled_entry
def write_divergent_component(com: Array, dt_s: float, omega: float, out: Array) -> None:
    """Write the divergent component of motion, com + velocity / omega.

    Args:
        com: (T, 2 or more) centre of mass [m].
        dt_s: time between rows.
        omega: rate of the pendulum [1/s].
        out: (T, 2) output [m].
    """
    last = len(com) - 1
    for t in range(last + 1):
        before = max(t - 1, 0)
        after = min(t + 1, last)
        per = 2.0 * dt_s if after - before == 2 else dt_s
        for k in range(2):
            out[t, k] = com[t, k] + (com[after, k] - com[before, k]) / per / omega
