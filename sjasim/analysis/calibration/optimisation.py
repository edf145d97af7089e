"""Minimum of a cost (minus a log likelihood), and 95 % confidence intervals from its profile."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize

from ...core import Array, BoolArray

Z_95 = 1.96
"""Half width of a 95 % confidence interval, in standard errors."""

RISE = Z_95**2 / 2
"""Rise of minus the log likelihood at the ends of a 95 % confidence interval."""

QUADRATIC_TOLERANCE = 0.25
"""Error of the signed root at the end of an interval up to which one secant corrects it, in standard errors."""

TRIED = 20.0
"""Cost above that of a profile's point up to which another start is tried."""

BARRIER = 0.05
"""Rise of the cost halfway between two minima that are not the same one."""

ROOT_TOLERANCE = 0.05
"""Error of the signed root of the likelihood ratio at the end of an interval, in standard errors."""

MOST_STEPS = 10
"""Most profile points for one end of an interval."""

IMPROVEMENT = 1e-3
"""Decrease of the cost below its supposed minimum that starts the search again."""

Cost = Callable[[Array], float]
Bounds = list[tuple[float, float]]
"""Lower and upper bound of each parameter."""


class Profile(NamedTuple):
    """One end of an interval, and the lowest point of the cost that was seen on the way.

    Attributes:
        end: value of the parameter.
        lowest: (P,) parameters with the lowest cost that was seen.
    """

    end: float
    lowest: Array


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
    options = {"maxiter": 300, "finite_diff_rel_step": 1e-4, "ftol": 1e-8}
    result = minimize(
        cost_per_event, start[free], method="L-BFGS-B", jac="3-point", bounds=free_bounds, options=options
    )
    parameters[free] = result.x
    return parameters


def minimum_with_intervals(cost: Cost, minima: Sequence[Array], bounds: Bounds, events: int) -> tuple[Array, Array]:
    """(P,) parameters with the lowest cost, and (P, 2) ends of their 95 % confidence intervals.

    The ends are where the profile of the cost, that is, the cost minimised over the other parameters, has risen by
    `Z_95` squared over 2. Where the cost is a quadratic function up to there, they follow from its curvature; where it
    is flat or lopsided, or near a bound, from a search. An interval includes other minima that are not significantly
    higher, and what lies between. If a search finds a lower cost than the supposed minimum, everything starts again
    from there.

    Args:
        cost: function of the parameters.
        minima: parameters, (P,) each, at which the cost has a local minimum.
        bounds: bounds of the parameters; an interval ends at the bound if the profile does not rise before it.
        events: number of events, as in `minimise`.
    """
    at = min(minima, key=cost)
    ends, half_width = _quadratic_ends(cost, at, bounds)
    others = [point for point in minima if cost(0.5 * (point + at)) > cost(point) + BARRIER]
    # Another minimum inside the interval makes the curvature at this one meaningless.
    inside = [at, *(point for point in others if cost(point) - cost(at) < RISE)]
    if len(inside) > 1:
        ends[:] = np.nan

    for entry, column in np.argwhere(np.isnan(ends)):
        side = -1 if column == 0 else 1
        start = max(inside, key=lambda point, entry=entry, side=side: side * point[entry])  # type: ignore[misc]
        step = half_width[entry] if len(inside) == 1 else np.nan
        profile = _profile(cost, at, (start, *others), bounds, events, int(entry), side, step)
        if cost(profile.lowest) < cost(at) - IMPROVEMENT:
            better = minimise(cost, profile.lowest, bounds, np.ones(len(at), dtype=bool), events)
            return minimum_with_intervals(cost, [better, *minima], bounds, events)
        ends[entry, column] = profile.end

    return at, ends


def _quadratic_ends(cost: Cost, at: Array, bounds: Bounds) -> tuple[Array, Array]:
    """(P, 2) ends of the intervals by the curvature of the cost, NaN where it misleads; (P,) their half widths.

    It misleads where the cost at such an end is another than that of a quadratic function, and outside the bounds.
    """
    ends = np.full((len(at), 2), np.nan)
    lower, upper = np.array(bounds).T
    values, vectors = np.linalg.eigh(_curvature(cost, at))
    # On a bound or in a flat valley, the curvature is not positive in every direction.
    if not values.min() > 1e-6 * values.max():
        return ends, ends[:, 0]

    covariance = (vectors / values) @ vectors.T
    half_width = Z_95 * np.sqrt(np.diag(covariance))
    lowest = cost(at)
    for entry in range(len(at)):
        # The other parameters move along with this one, as in the profile of a quadratic function.
        move = half_width[entry] * covariance[entry] / covariance[entry, entry]
        for column, side in ((0, -1), (1, 1)):
            end = at + side * move
            if np.any(end < lower) or np.any(end > upper):
                continue
            root = float(np.sqrt(2.0 * max(cost(end) - lowest, 0.0)))
            if abs(root - Z_95) < QUADRATIC_TOLERANCE:
                # The root is nearly linear in the parameter.
                ends[entry, column] = at[entry] + (end[entry] - at[entry]) * Z_95 / root
    return ends, half_width


def _curvature(cost: Cost, at: Array) -> Array:
    """(P, P) second derivatives of the cost by central differences."""
    size = len(at)
    lowest = cost(at)
    step = np.array([0.5 * _first_distance(cost, at, i, 1) for i in range(size)])
    shift = np.diag(step)

    curvature = np.empty((size, size))
    for i in range(size):
        curvature[i, i] = (cost(at + shift[i]) + cost(at - shift[i]) - 2 * lowest) / step[i] ** 2
        for j in range(i):
            with_j = cost(at + shift[i] + shift[j]) - cost(at - shift[i] + shift[j])
            against_j = cost(at + shift[i] - shift[j]) - cost(at - shift[i] - shift[j])
            curvature[i, j] = curvature[j, i] = (with_j - against_j) / (4 * step[i] * step[j])
    return curvature


def _profile(
    cost: Cost, at: Array, starts: Sequence[Array], bounds: Bounds, events: int, entry: int, side: int, step: float
) -> Profile:
    """End of one parameter's interval, by a search for the profile's signed root.

    The root of twice the profile's rise is nearly linear in the parameter, so that a few secants find its end.

    Args:
        cost: function of the parameters.
        at: (P,) parameters with the lowest cost.
        starts: parameters inside the interval from which the search sets out, and others to minimise from, because a
            profile may have several minima.
        bounds: bounds of the parameters.
        events: number of events, as in `minimise`.
        entry: index of the parameter.
        side: -1 for the lower end, 1 for the upper end.
        step: expected distance of the end from the start; NaN if nothing is known.
    """
    others = np.arange(len(at)) != entry
    limit = bounds[entry][0 if side < 0 else 1]
    lower, upper = np.array(bounds).T
    lowest = at
    lowest_cost = cost(at)
    start = starts[0]
    most = abs(limit - at[entry])
    inside = max(side * (start[entry] - at[entry]), 0.0)
    inside_root = float(np.sqrt(2.0 * (cost(start) - lowest_cost))) if inside > 0.0 else 0.0
    outside = np.inf
    point = start if inside > 0.0 else at
    distance = min(inside + (step if np.isfinite(step) else _first_distance(cost, point, entry, side)), most)

    for _ in range(MOST_STEPS):
        # The other parameters move on in proportion, which is where they are to be expected.
        reached = abs(point[entry] - at[entry])
        guess = at + (point - at) * (distance / reached) if reached > 0.0 else at.copy()
        guess = np.clip(guess, lower, upper)
        guess[entry] = at[entry] + side * distance
        point = _lowest_at(cost, guess, starts[1:], bounds, others, events, lowest_cost + RISE)
        rise = cost(point) - lowest_cost
        if rise < -IMPROVEMENT:
            return Profile(float(point[entry]), point)

        root = float(np.sqrt(2.0 * max(rise, 0.0)))
        if abs(root - Z_95) < ROOT_TOLERANCE:
            break
        if root > Z_95:
            outside = distance
        else:
            inside = distance
            inside_root = root
            if distance >= most:
                break
        distance = _next_distance(distance, root, inside, inside_root, outside, most)

    return Profile(float(at[entry] + side * distance), lowest)


def _lowest_at(
    cost: Cost, guess: Array, starts: Sequence[Array], bounds: Bounds, others: BoolArray, events: int, most: float
) -> Array:
    """(P,) parameters with the lowest cost for the guess's value of one parameter.

    Args:
        cost: function of the parameters.
        guess: (P,) parameters from which to minimise.
        starts: further values of the other parameters, tried if the cost is higher than ``most`` otherwise.
        bounds: bounds of the parameters.
        others: (P,) which parameters may change.
        events: number of events, as in `minimise`.
        most: the cost above which other starts are tried.
    """
    point = minimise(cost, guess, bounds, others, events)
    if cost(point) <= most:
        return point

    # Only starts that promise to end lower are tried.
    tried = [np.where(others, other, guess) for other in starts]
    tried = [other for other in tried if cost(other) < cost(point) + TRIED]
    return min([point, *(minimise(cost, other, bounds, others, events) for other in tried)], key=cost)


def _next_distance(
    distance: float, root: float, inside: float, inside_root: float, outside: float, most: float
) -> float:
    """Distance from the minimum at which the signed root is expected to reach `Z_95`.

    Args:
        distance: the last distance.
        root: signed root there.
        inside: largest distance with a smaller root than `Z_95`.
        inside_root: the root there.
        outside: smallest distance with a larger root; infinite if there is none.
        most: distance of the bound.
    """
    if not np.isfinite(outside):
        # At most four times as far, because a profile may be flat at first.
        return min(distance * float(np.clip(1.02 * Z_95 / max(root, 1e-3), 1.1, 4.0)), most)

    if root > Z_95 and root - inside_root > 1e-6:
        expected = inside + (Z_95 - inside_root) * (distance - inside) / (root - inside_root)
    else:
        expected = distance * Z_95 / max(root, 1e-3)
    margin = 0.1 * (outside - inside)
    return float(np.clip(expected, inside + margin, outside - margin))


def _first_distance(cost: Cost, at: Array, entry: int, side: int) -> float:
    """Distance along one parameter that raises the cost by about .5: one conditional standard error, at most 1."""
    lowest = cost(at)
    step = 0.02
    for _ in range(8):
        moved = at.copy()
        moved[entry] += side * step
        rise = cost(moved) - lowest
        if 0.25 < rise < 1.0:
            break
        step *= float(np.clip(np.sqrt(0.5 / max(rise, 1e-9)), 0.1, 4.0))
        if step > 1.0:
            return 1.0
    return step
