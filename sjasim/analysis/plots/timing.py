"""Timing appropriateness of one session, or of several on common axes: histogram and cumulative share."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from .figure import SESSION_COLOURS, empty_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

BIN_S = 0.1
"""Width of a bin [s]. Source: iqbal2016, section VI-B."""

TOP_S = 2.5
"""End of the last bin; larger values have a bin of their own behind it [s]. Source: iqbal2016, section VI-B."""

GUIDE_LINES_S = (0.8, 1.2, 1.6)
"""Distances for which iqbal2016 gives cumulative shares; the figure gives them too [s]."""


def timing_figure(values_s: Mapping[str, Sequence[float]]) -> Figure:
    """Histogram and cumulative share of timing appropriateness, with the sessions laid over one another.

    Args:
        values_s: label of a session -> distances of the robot's events from the dancers' mean [s].
    """
    figure = empty_figure(9.0, 4.0)
    left, right = figure.subplots(1, 2)

    for index, (label, session_s) in enumerate(values_s.items()):
        colour = SESSION_COLOURS[index % len(SESSION_COLOURS)]
        distances_s = np.sort(np.asarray(session_s, dtype=np.float64))
        legend = f"{label}: n = {len(distances_s)}, mean {distances_s.mean():.2f} s"
        _draw_histogram(left, distances_s, colour, legend)
        _draw_cumulative(right, distances_s, colour, index)

    ticks = np.arange(0.0, TOP_S + BIN_S, 0.5)
    left.set_xticks([*ticks, TOP_S + 2 * BIN_S], [*(f"{tick:g}" for tick in ticks[:-1]), f"{TOP_S:g}  ", "  more"])
    left.set(xlabel="distance from the dancers' mean [s]", ylabel="robot's events [%]", title="Timing appropriateness")
    left.legend(frameon=False, fontsize=9)
    right.set(xlabel="distance from the dancers' mean [s]", ylabel="events up to here [%]", title="Cumulative share")
    right.set(xlim=(0.0, TOP_S), ylim=(0.0, 103.0))
    return figure


def histogram_shares(distances_s: Sequence[float] | np.ndarray) -> np.ndarray:
    """(26,) share of values in each bin of .1 s up to 2.5 s, then of those beyond [%]."""
    edges_s = [*np.round(np.arange(0.0, TOP_S + BIN_S / 2, BIN_S), 6), np.inf]
    return 100.0 * np.histogram(distances_s, edges_s)[0] / len(distances_s)


def _draw_histogram(axes: Axes, distances_s: np.ndarray, colour: str, legend: str) -> None:
    """Draw one session's histogram; the bin of the values beyond the axis stands apart from the others."""
    shares = histogram_shares(distances_s)
    edges_s = np.arange(len(shares)) * BIN_S
    beyond_s = TOP_S + np.array([1.5, 2.5]) * BIN_S

    for values, ends_s, label in ((shares[:-1], edges_s, legend), (shares[-1:], beyond_s, None)):
        axes.stairs(values, ends_s, fill=True, color=colour, alpha=0.25)
        axes.stairs(values, ends_s, color=colour, linewidth=1.6, label=label)


def _draw_cumulative(axes: Axes, distances_s: np.ndarray, colour: str, index: int) -> None:
    """Draw one session's cumulative share, and write its value at each guide line."""
    share = 100.0 * np.arange(1, len(distances_s) + 1) / len(distances_s)
    # Behind the axis' end the curve goes on, so that values beyond it are seen to be missing.
    axes.step([0.0, *distances_s, max(TOP_S, distances_s[-1])], [0.0, *share, 100.0], where="post", color=colour)

    for bound_s in GUIDE_LINES_S:
        within = 100.0 * np.mean(distances_s <= bound_s)
        axes.axvline(bound_s, color="0.8", linewidth=0.8, zorder=0)
        axes.text(bound_s + 0.03, 4.0 + 7.0 * index, f"{within:.0f} %", color=colour, fontsize=9)
