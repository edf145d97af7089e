"""The report of a characterisation as a Markdown page."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

Row = Mapping[str, Any]

DETECTOR_COLUMNS = ("kind", "row", "occlusion", "n", "recall", "precision", "bias_s", "sd_s", "p95_s")
JOINT_COLUMNS = (
    "joints",
    "row",
    "occlusion",
    "n",
    "tracked",
    "inferred",
    "median_m",
    "p95_m",
    "astray",
    "bias_m",
    "drift_m",
    "correlation",
    "inferred_m",
)
ROBOT_COLUMNS = ("kind", "n", "delay_s", "jitter_s", "not_executed")

EXPLANATION = (
    "Errors are logged minus true times. Recall counts every event that happened, occluded ones too. "
    "Of the joints: shares of tracked and inferred ones; of the tracked ones the median and the 95th percentile of the "
    "distance to the truth, the share astray (more than .15 m off), the constant and the slow error per axis, and the "
    "latter's correlation from frame to frame; of the inferred ones the r.m.s. error per axis."
)


def page(report: Mapping[str, Any]) -> str:
    """The page.

    Args:
        report: content of characterise.json.
    """
    sensings = _different(report, "sensing")
    seeds = ", ".join(map(str, _different(report, "seed")))
    parts = [
        "# Accuracy of the joints, the detectors and the robot",
        f"{len(report['sessions'])} sessions: sensing {', '.join(sensings)}; layouts "
        f"{', '.join(_different(report, 'layout'))}; seeds {seeds}. {EXPLANATION}",
    ]
    for sensing in sensings:
        parts += _sensing_parts(report, sensing)
    if report["robot"]:
        parts += ["## Robot: from command to event", _table(ROBOT_COLUMNS, report["robot"])]
    return "\n\n".join(parts) + "\n"


def _different(report: Mapping[str, Any], name: str) -> list[Any]:
    """The different values of the sessions, sorted."""
    return sorted({session[name] for session in report["sessions"]})


def _sensing_parts(report: Mapping[str, Any], sensing: str) -> list[str]:
    """Titles and tables of one source of the skeletons."""
    rows = [row for row in report["detector"] if row["sensing"] == sensing]
    regular = [row for row in rows if not row["early"]]
    # Early events are too few to be divided by row and occlusion.
    early = [row for row in rows if row["early"] and (row["row"], row["occlusion"]) == ("all", "all")]
    joints = [row for row in report["joints"] if row["sensing"] == sensing and "all" in (row["row"], row["occlusion"])]
    return [
        f"## {sensing} sensing, regular events",
        _table(DETECTOR_COLUMNS, regular),
        f"## {sensing} sensing, early events",
        _table(DETECTOR_COLUMNS, early),
        f"## {sensing} sensing, joints",
        _table(JOINT_COLUMNS, joints),
    ]


def _table(columns: Sequence[str], rows: Sequence[Row]) -> str:
    """A Markdown table whose columns are aligned in the source as well."""
    lines = [list(columns), ["---"] * len(columns), *([_cell(row[name]) for name in columns] for row in rows)]
    widths = [max(len(line[column]) for line in lines) for column in range(len(columns))]
    return "\n".join(
        "| " + " | ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)) + " |" for line in lines
    )


def _cell(value: object) -> str:
    """A value as text: numbers with three decimals, small ones with four; ``-`` for what was not measured."""
    if value is None:
        return "-"
    if isinstance(value, float):
        return f"{value:.4f}" if 0.0 < abs(value) < 0.1 else f"{value:.3f}"
    return str(value)
