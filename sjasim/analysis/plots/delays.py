"""Mean parts of the robot's delay behind the dancers, by event kind."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...record.rerun.explanation import STAGES, DelayReport, StepDelay
from .figure import empty_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

STAGE_COLOURS = ("#CC79A7", "#56B4E9", "#0072B2", "#009E73", "#E69F00", "#D55E00")
"""Colour of each of `record.rerun.explanation.STAGES`."""

STAGE_LABELS = {
    "dancer": "followed dancer behind the mean", "sensor": "sensor", "detector": "detector",
    "network": "network", "decision": "method", "wheels": "command to motion",
}  # fmt: skip
"""Stage -> label in the legend."""


def delays_figure(report: DelayReport) -> Figure:
    """Mean parts of the robot's delay behind the dancers' mean, by event kind.

    If the robot followed a dancer in any step, only such steps count.
    """
    following = [step for step in report.steps if step.follows]
    used = following or report.steps
    kinds = list(dict.fromkeys(step.kind for step in used))

    figure = empty_figure(9.0, 1.8 + 0.5 * len(kinds))
    axes = figure.add_subplot()
    for row, kind in enumerate(reversed(kinds)):
        steps = [step for step in used if step.kind is kind and np.isfinite(step.late_s)]
        if steps:
            _draw_delay(axes, row, steps)

    axes.axvline(0.0, color="0.4", linewidth=0.8)
    axes.set_yticks(range(len(kinds)), [kind.value.replace("_", " ") for kind in reversed(kinds)])
    axes.set_xlabel("mean delay behind the dancers' mean time [s]; negative is early")
    scope = " (steps in which it followed a dancer)" if following else ""
    axes.set_title(f"Where the robot's delay comes from{scope}")
    axes.legend(ncol=4, loc="upper center", bbox_to_anchor=(0.5, -0.2), frameon=False)
    return figure


def _draw_delay(axes: Axes, row: int, steps: Sequence[StepDelay]) -> None:
    """Draw the mean parts of some steps as a stacked bar: positive ones to the right, negative ones to the left."""
    parts_s = np.nan_to_num(np.array([step.parts_s for step in steps])).mean(axis=0)
    left_s = 0.0
    right_s = 0.0
    for stage, part_s, colour in zip(STAGES, parts_s, STAGE_COLOURS, strict=True):
        # Labels of the first row are enough for the legend.
        label = STAGE_LABELS[stage] if row == 0 else None
        axes.barh(row, part_s, left=right_s if part_s >= 0 else left_s, color=colour, height=0.6, label=label)
        right_s += max(part_s, 0.0)
        left_s += min(part_s, 0.0)

    total_s = float(np.mean([step.late_s for step in steps]))
    axes.plot([total_s], [row], "kD", markersize=5, label="in all" if row == 0 else None)
