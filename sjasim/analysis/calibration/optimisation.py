"""Minimum of a cost (minus a log likelihood), and 95 % confidence intervals from its shape."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.optimize import minimize

from ...core import Array, BoolArray

Z_95 = 1.96
"""Half width of a 95 % confidence interval, in standard errors."""

PROFILE_RISE = Z_95**2 / 2
"""Rise of minus the log likelihood at the ends of a 95 % confidence interval."""

BISECTIONS = 5
"""Bisections that locate the end of a profile interval."""

Cost = Callable[[Array], float]
Bounds = list[tuple[float, float]]
"""Lower and upper bound of each parameter."""


def minimise(cost: Cost, start: Array, bounds: Bounds, free: BoolArray, events: int) -> Array:
    """(P,) parameters with the lowest cost.

    Args:
        cost: function of the parameters.
        start: (P,) parameters to start from.
        bounds: bounds of the parameters.
        free: (P,) whether each parameter may change.
        events: number of events; it divides the cost, so that the optimiser's tolerances fit its size.
    """
    parameters = start.copy()

    def cost_per_event(free_parameters: Array) -> float:
        parameters[free] = free_parameters
        return cost(parameters) / events

    free_bounds = [limits for limits, is_free in zip(bounds, free, strict=True) if is_free]
    options = {"maxiter": 300, "finite_diff_rel_step": 1e-4}
    result = minimize(
        cost_per_event, start[free], method="L-BFGS-B", jac="3-point", bounds=free_bounds, options=options
    )
    parameters[free] = result.x
    return parameters


def confidence_intervals(cost: Cost, at: Array, bounds: Bounds, events: int) -> Array:
    """(P, 2) ends of the 95 % confidence intervals of all parameters.

    They follow from the curvature of the cost or, where the cost is not curved upwards, from its profile.

    Args:
        cost: function of the parameters.
        at: (P,) parameters with the lowest cost.
        bounds: bounds of the parameters.
        events: number of events, as in `minimise`.
    """
    values, vectors = np.linalg.eigh(_curvature(cost, at))
    # On a bound or in a flat valley, the curvature is not positive in every direction.
    if values.min() > 1e-6 * values.max():
        half_width = Z_95 * np.sqrt((vectors**2) @ (1.0 / values))
        return np.stack([at - half_width, at + half_width], axis=1)

    return np.array([[_profile_end(cost, at, bounds, events, i, side) for side in (-1, 1)] for i in range(len(at))])


def _curvature(cost: Cost, at: Array) -> Array:
    """(P, P) second derivatives of the cost by central differences."""
    size = len(at)
    lowest = cost(at)
    step = np.array([_step_size(cost, at, lowest, i) for i in range(size)])
    shift = np.diag(step)

    curvature = np.empty((size, size))
    for i in range(size):
        curvature[i, i] = (cost(at + shift[i]) + cost(at - shift[i]) - 2 * lowest) / step[i] ** 2
        for j in range(i):
            with_j = cost(at + shift[i] + shift[j]) - cost(at - shift[i] + shift[j])
            against_j = cost(at + shift[i] - shift[j]) - cost(at - shift[i] - shift[j])
            curvature[i, j] = curvature[j, i] = (with_j - against_j) / (4 * step[i] * step[j])
    return curvature


def _profile_end(cost: Cost, at: Array, bounds: Bounds, events: int, entry: int, side: int) -> float:
    """Value of one parameter at which the cost, minimised over the others, has risen by `PROFILE_RISE`.

    Args:
        cost: function of the parameters.
        at: (P,) parameters with the lowest cost.
        bounds: bounds of the parameters; the result is at most the bound on this side.
        events: number of events, as in `minimise`.
        entry: index of the parameter.
        side: -1 for the lower end, 1 for the upper end.
    """
    others = np.arange(len(at)) != entry
    limit = bounds[entry][0 if side < 0 else 1]
    lowest = cost(at)

    def is_outside(value: float) -> bool:
        moved = at.copy()
        moved[entry] = value
        return cost(minimise(cost, moved, bounds, others, events)) - lowest > PROFILE_RISE

    # Triple the distance until it is outside, then bisect.
    inside = float(at[entry])
    outside = inside + side * _step_size(cost, at, lowest, entry)
    while not is_outside(outside):
        inside = outside
        outside = outside + 2.0 * (outside - at[entry])
        if side * (outside - limit) >= 0:
            return limit if not is_outside(limit) else _bisect(is_outside, inside, limit)
    return _bisect(is_outside, inside, outside)


def _bisect(is_outside: Callable[[float], bool], inside: float, outside: float) -> float:
    """Border between a value inside and one outside."""
    for _ in range(BISECTIONS):
        middle = 0.5 * (inside + outside)
        if is_outside(middle):
            outside = middle
        else:
            inside = middle
    return 0.5 * (inside + outside)


def _step_size(cost: Cost, at: Array, lowest: float, entry: int) -> float:
    """Step of one parameter that raises the cost by about 0.05: a third of a standard error, at most 1.

    Such a step is large enough for rounding and small enough for the quadratic approximation.
    """
    step = 0.02
    for _ in range(6):
        move = np.zeros(len(at))
        move[entry] = step
        rise = 0.5 * (cost(at + move) + cost(at - move)) - lowest
        step *= float(np.clip(np.sqrt(0.05 / max(rise, 1e-9)), 0.1, 4.0))
        if 0.03 < rise < 0.08 or step > 1.0:
            break
    return min(step, 1.0)
