"""Clap detection: the rule that claps seen from the front and from the side share.

The rule reads one number per frame, the *hand ratio*, which is small where the hands are close together. The detectors
compute it in different ways. A clap is a local minimum of the ratio below ``clap_ratio``. The event is detected in the
frame after the minimum.

Hands that touch stay together for several frames, and the smallest of the ratios in that time is a matter of noise.
Below `TOUCHING_RATIO` the minimum is therefore the first frame after which the ratio falls by less than
`RATIO_NOISE`.

Two conditions keep false claps away:

* The hands have been apart since the last clap, and that clap is at least ``clap_refractory_s`` ago. Hands that are
  held together clap once. Hands are apart above `APART_RATIO`. If they were inferred to be apart while one was
  occluded, seeing them above `CLOSING_RATIO` is enough.
* The hands were seen to come together: the ratio was below `NEAR_RATIO` in the last frame in which the hands were
  tracked. Touching hands occlude each other, so they may be inferred for a short time as they meet. After a longer
  time without tracked hands the state is reset, so that hands that come into sight cannot clap.

Source: iqbal2016, section II-B, for the local minimum below a threshold; the other conditions are assumed.
"""

from __future__ import annotations

from math import inf, isnan, nan

import numpy as np

from ...core.compiled import compiled_inner
from .thresholds import Record, Records

APART_RATIO = 0.8
"""Hands are apart above this ratio; hanging arms and arms that open for a clap have ratios of 1.1 to 1.4."""

CLOSING_RATIO = 0.4
"""Hands that come into sight above this ratio do not touch yet and may still come together (assumed)."""

NEAR_RATIO = 1.0
"""Hands below this ratio may be about to clap (assumed).

Tracked hands below it have been seen to come together. Early starts are disarmed for ``clap_refractory_s`` after it,
because the trunk nods with a clap, even if the clap itself is not detected.
"""

TOUCHING_RATIO = 0.3
"""Hands below this ratio may touch (assumed)."""

RATIO_NOISE = 0.03
"""Noise of the ratio of touching hands from frame to frame, about half a centimetre per hand (assumed)."""

CLAP_STATE = np.dtype([
    ("ratio", np.float64),  # ratio in the last frame; NaN if unknown
    ("previous_ratio", np.float64),  # ratio in the frame before it
    ("t_ratio_s", np.float64),  # time of the last frame
    ("t_clap_s", np.float64),  # time of the frame in which the last clap was detected
    ("t_near_s", np.float64),  # last time at which tracked hands were near each other
    ("t_tracked_s", np.float64),  # last time at which the hands were tracked
    ("apart", np.bool_),  # whether the hands have been apart since the last clap
    ("inferred_apart", np.bool_),  # whether they were inferred to be apart before they came into sight
    ("near", np.bool_),  # whether they were near each other when they were last tracked
])  # fmt: skip
"""State of one person's clap detection; times are those of the sensor."""


def initial_clap_states(persons: int) -> Records:
    """Return (persons,) `CLAP_STATE` of persons whose hands have not been seen yet."""
    initial = (nan, nan, nan, -inf, -inf, -inf, False, False, False)
    return np.array([initial] * persons, dtype=CLAP_STATE)


@compiled_inner
def clap_time_s(
    hands: Record, t_s: float, ratio: float, tracked: bool, longest_inferred_s: float, thresholds: Record
) -> float:
    """Update the state with one frame and return the time of a clap.

    Args:
        hands: one of `CLAP_STATE`; changed.
        t_s: time of the frame.
        ratio: hand ratio; NaN if unknown.
        tracked: whether the hands on which the ratio depends are tracked.
        longest_inferred_s: how long these hands may be inferred before the state is reset.
        thresholds: one of `THRESHOLDS`.

    Returns:
        the time of the minimum if this frame completes a clap, otherwise NaN.
    """
    if tracked:
        hands.inferred_apart = ratio >= CLOSING_RATIO and hands.inferred_apart
    else:
        hands.inferred_apart = hands.inferred_apart or ratio > APART_RATIO

    if tracked and not isnan(ratio):
        hands.t_tracked_s = t_s
        hands.near = ratio < NEAR_RATIO
        if hands.near:
            hands.t_near_s = t_s
    elif t_s - hands.t_tracked_s > longest_inferred_s:
        hands.ratio = nan
        hands.previous_ratio = nan
        hands.t_ratio_s = nan
        hands.apart = False
        hands.near = False
        return nan

    # The candidate for the minimum is the frame before this one.
    before = hands.previous_ratio
    candidate = hands.ratio
    t_candidate_s = hands.t_ratio_s
    hands.previous_ratio = candidate
    hands.ratio = ratio
    hands.t_ratio_s = t_s

    tolerance = RATIO_NOISE if candidate < TOUCHING_RATIO else 0.0
    is_minimum = before >= candidate and candidate < ratio + tolerance
    rested = t_s - hands.t_clap_s >= thresholds.clap_refractory_s
    if hands.apart and hands.near and is_minimum and candidate < thresholds.clap_ratio and rested:
        hands.t_clap_s = t_s
        hands.apart = False
        return float(t_candidate_s)

    apart_ratio = CLOSING_RATIO if hands.inferred_apart else max(APART_RATIO, thresholds.clap_ratio)
    hands.apart = hands.apart or (tracked and ratio > apart_ratio)
    return nan


@compiled_inner
def may_be_clapping(hands: Record, t_s: float, thresholds: Record) -> bool:
    """Return whether the hands were near each other within the last ``clap_refractory_s``."""
    return bool(t_s - hands.t_near_s < thresholds.clap_refractory_s)
