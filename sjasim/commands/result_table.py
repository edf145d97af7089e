"""The figures of one session as a table with remarks below it; it fits a terminal of 80 columns."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from ..config import HUMANS_ONLY, SessionConfig
from ..config.toml_file import to_plain

INDICES = ("gsi", "gsi_full_edges", "gsi_truth")
"""Keys of the group synchrony indices, in the order of the table's columns."""

COLUMNS = (
    "iteration", "GSI", "GSI,\nfull\nedges", "GSI,\ntrue\nonsets", "MSP", "robot\nfollowed", "late\n[s]", "TA\n[s]",
    "steps\nmissed",
)  # fmt: skip
"""Headings of the table."""

LEGEND = "late: behind (+) or ahead of (-) the dancers' mean; TA: distance from that mean"
"""What a reader of the table would have to look up otherwise; at most 80 characters."""


def print_session(summary: Mapping[str, Any], console: Console) -> None:
    """Print a session's figures: a table by iteration, then a remark for each part of the system.

    Args:
        summary: content of session.json.
        console: where to print.
    """
    table = Table(title=escape(session_title(summary)), box=SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False)
    for name in COLUMNS:
        table.add_column(escape(name), justify="right")  # [s] is a unit, not a style

    for row in summary["iterations"]:
        table.add_row(str(row["index"]), *_index_cells(row), row["msp"], *_robot_cells(summary, row))
    table.add_section()
    table.add_row("mean", *_index_cells(summary), "", "", *_timing_cells(summary), "")
    console.print(table)

    if summary["method"] != HUMANS_ONLY:
        console.print(LEGEND, markup=False, highlight=False)
    # A column of its own for the labels indents the lines of a text that is too long for one.
    lines = Table.grid(padding=(0, 1, 0, 0))
    for label, text in remarks(summary):
        lines.add_row(escape(f"{label}:"), escape(text))
    console.print(lines, highlight=False)


def session_title(summary: Mapping[str, Any]) -> str:
    """Method, seed and people of a session, and those of its main settings that are not the default ones."""
    config = summary["config"]
    default = to_plain(SessionConfig())
    parts = [summary["method"], f"seed {summary['seed']}", f"{summary['humans']} dancers"]

    if config["dance"]["name"] != SessionConfig().dance.name:
        parts.append(config["dance"]["name"])
    changed = [name for name in ("sensing", "layout", "dancers") if config[name] != default[name]]
    return ", ".join([*parts, *(f"{name} {config[name]}" for name in changed)])


def remarks(summary: Mapping[str, Any]) -> list[tuple[str, str]]:
    """What the table does not hold: detectors, robot, net latency, bodies and notices, each a label and a text."""
    detector = summary["detector"]
    lines = [
        (
            "detectors",
            f"recall {_share(detector, 'recall', 'detected_visible', 'visible')} in sight, "
            f"{_share(detector, 'recall_all', 'detected', 'true')} in all,\n"
            f"precision {_share(detector, 'precision', 'detected', 'logged')}, "
            f"95 % of times within {_number(detector['timing_p95_s'])} s",
        )
    ]

    robot = summary["robot"]
    if robot["commands"]:  # none in a session without a robot
        executed = round(robot["executed"] * robot["commands"])
        text = f"{executed} of {robot['commands']} commands executed, {robot['missed']} steps missed"
        if robot["end_distance_m"] is not None:
            text += f", {robot['end_distance_m']:.2f} m off at the end"
        lines.append(("robot", text))
    if summary["net_latency_s"]:
        lines.append(("net latency", _net_latency(summary["net_latency_s"])))

    if summary["feet_load_share"] is not None:  # the event-level world has no bodies
        lines.append(
            (
                "bodies",
                f"{summary['falls']} falls, feet carry {_number(summary['feet_load_share'])} of the weight, "
                f"balance support {_number(summary['tether_rms_n'], 1)} N",
            )
        )
    notices = [("notice", f"at {item['t_s']:.1f} s: {item['source']}: {item['what']}") for item in summary["notices"]]
    return lines + notices


def _net_latency(latencies: Mapping[str, Mapping[str, Any]]) -> str:
    """Mean delay behind the dancers whose events triggered the steps, over all of them and by kind."""
    count = sum(item["n"] for item in latencies.values())
    # The mean over all events: each kind counts as often as it happened.
    mean_s = sum(item["mean"] * item["n"] for item in latencies.values()) / count
    by_kind = ", ".join(f"{kind} {item['mean']:+.2f}" for kind, item in latencies.items())
    return f"{mean_s:+.2f} s behind the dancer that triggered the step (n = {count}):\n{by_kind}"


def _index_cells(row: Mapping[str, Any]) -> list[str]:
    """Cells of the synchrony indices of an iteration, or of the session."""
    return [_number(row[key]) for key in INDICES]


def _robot_cells(summary: Mapping[str, Any], row: Mapping[str, Any]) -> list[str]:
    """Cells of an iteration that are about the robot; dashes in a humans-only session."""
    if summary["method"] == HUMANS_ONLY:
        return ["-"] * 4
    return [_followed(row["followed"], summary["config"]["dancers"]), *_timing_cells(row), str(row["robot_missed"])]


def _timing_cells(row: Mapping[str, Any]) -> list[str]:
    """Cells of the robot's lateness and timing appropriateness in an iteration, or in the session."""
    late_s = row["late_mean_s"]
    # Adding 0 turns a negative zero into a positive one.
    return ["-" if late_s is None else f"{round(late_s, 2) + 0.0:+.2f}", _number(row["ta_mean_s"], 2)]


def _followed(names: Sequence[str], dancers: int) -> str:
    """Whom the robot followed, in at most 9 characters."""
    if len(names) == 1:
        return names[0]
    if not names:
        return "nobody"
    return "everyone" if len(names) == dancers else f"{len(names)} dancers"


def _share(figures: Mapping[str, Any], share: str, part: str, whole: str) -> str:
    """A share with the two counts that it is made of."""
    return f"{_number(figures[share])} ({figures[part]} of {figures[whole]})"


def _number(value: float | None, digits: int = 3) -> str:
    """A number with so many decimals; ``-`` for what was not measured."""
    return "-" if value is None else f"{value:.{digits}f}"
