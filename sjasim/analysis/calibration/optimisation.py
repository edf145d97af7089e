"""Where a cost (minus a log likelihood) is lowest, and how well it says so."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.optimize import minimize

from ...core import Array, BoolArray

LEVEL = 1.96
"""Standard errors to both sides of a 95 % interval."""
RISE = LEVEL**2 / 2
"""By how much minus the log likelihood rises to the ends of a 95 % interval."""

Cost = Callable[[Array], float]
Bounds = list[tuple[float, float]]


def lowest(cost: Cost, start: Array, bounds: Bounds, free: BoolArray, events: int) -> Array:
    """Where the cost is lowest while only some entries may move; events scale it, so that steps are of order one."""
    at = start.copy()

    def moved(entries: Array) -> float:
        at[free] = entries
        return cost(at) / events

    inside = [limits for limits, moves in zip(bounds, free, strict=True) if moves]
    options = {"maxiter": 300, "finite_diff_rel_step": 1e-4}
    found = minimize(moved, start[free], method="L-BFGS-B", jac="3-point", bounds=inside, options=options)
    at[free] = found.x
    return at


def intervals(cost: Cost, at: Array, bounds: Bounds, events: int) -> Array:
    """(P, 2) ends of 95 % intervals: from the curvature of the cost, or by profile where it is not curved upwards."""
    curvature = _curvature(cost, at)
    values, vectors = np.linalg.eigh(curvature)
    if values.min() > 1e-6 * values.max():
        wide = LEVEL * np.sqrt((vectors**2) @ (1.0 / values))
        return np.stack([at - wide, at + wide], axis=1)
    return np.array([[_profile(cost, at, bounds, events, i, side) for side in (-1, 1)] for i in range(len(at))])


def _curvature(cost: Cost, at: Array) -> Array:
    """(P, P) second derivatives of the cost."""
    size = len(at)
    here = cost(at)
    step = np.array([_reach(cost, at, here, i) for i in range(size)])
    moves = np.diag(step)
    curvature = np.empty((size, size))
    for i in range(size):
        curvature[i, i] = (cost(at + moves[i]) + cost(at - moves[i]) - 2 * here) / step[i] ** 2
        for j in range(i):
            with_j = cost(at + moves[i] + moves[j]) - cost(at - moves[i] + moves[j])
            against_j = cost(at + moves[i] - moves[j]) - cost(at - moves[i] - moves[j])
            curvature[i, j] = curvature[j, i] = (with_j - against_j) / (4 * step[i] * step[j])
    return curvature


def _profile(cost: Cost, at: Array, bounds: Bounds, events: int, entry: int, side: int) -> float:
    """How far one entry may go to one side until the cost, lowest over the others, has risen by `RISE`."""
    others = np.arange(len(at)) != entry
    limit = bounds[entry][0 if side < 0 else 1]
    here = cost(at)

    def risen(value: float) -> bool:
        moved = at.copy()
        moved[entry] = value
        return cost(lowest(cost, moved, bounds, others, events)) - here > RISE

    near, far = float(at[entry]), float(at[entry]) + side * _reach(cost, at, here, entry)
    while not risen(far):
        near, far = far, far + 2.0 * (far - at[entry])
        if side * (far - limit) >= 0:
            return limit if not risen(limit) else _halved(risen, near, limit)
    return _halved(risen, near, far)


def _halved(risen: Callable[[float], bool], near: float, far: float) -> float:
    """The border between two values of which only the farther one is too far."""
    for _ in range(5):
        middle = 0.5 * (near + far)
        near, far = (near, middle) if risen(middle) else (middle, far)
    return 0.5 * (near + far)


def _reach(cost: Cost, at: Array, here: float, entry: int) -> float:
    """A step of one entry that raises the cost by about a twentieth: a third of a standard error."""
    step = 0.02
    for _ in range(6):
        move = np.zeros(len(at))
        move[entry] = step
        rise = 0.5 * (cost(at + move) + cost(at - move)) - here
        step *= float(np.clip(np.sqrt(0.05 / max(rise, 1e-9)), 0.1, 4.0))
        if 0.03 < rise < 0.08 or step > 1.0:
            break
    return min(step, 1.0)
