"""The figures of one session as a table with remarks below it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from ..config import HUMANS_ONLY, SessionConfig
from ..config.toml_file import to_plain

INDICES = ("gsi", "gsi_full_edges", "gsi_truth")
"""Keys of the group synchrony indices, in the order of the table's columns."""


def print_session(summary: Mapping[str, Any], console: Console) -> None:
    """Print a session's figures: a table by iteration, then one line for each part of the system.

    Args:
        summary: content of session.json.
        console: where to print.
    """
    without_robot = summary["method"] == HUMANS_ONLY
    table = Table(title=escape(session_title(summary)))
    for name in ("iteration", "GSI", "GSI, full edges", "GSI, true onsets", "MSP", "TA [s]", "missed"):
        table.add_column(escape(name), justify="right")  # [s] is a unit, not a style

    for row in summary["iterations"]:
        missed = "-" if without_robot else str(row["robot_missed"])
        indices = (_number(row[key]) for key in INDICES)
        table.add_row(str(row["index"]), *indices, row["msp"], _number(row["ta_mean_s"], 2), missed)

    table.add_section()
    missed = "-" if without_robot else f"{summary['robot']['missed']} in all"
    indices = (_number(summary[key]) for key in INDICES)
    table.add_row("mean", *indices, "", _number(summary["ta_mean_s"], 2), missed)

    console.print(table)
    for line in remarks(summary):
        console.print(line, markup=False, highlight=False)


def session_title(summary: Mapping[str, Any]) -> str:
    """Method, seed and people of a session, and those of its main settings that are not the default ones."""
    config = summary["config"]
    default = to_plain(SessionConfig())
    parts = [summary["method"], f"seed {summary['seed']}", f"{summary['humans']} dancers"]

    if config["dance"]["name"] != SessionConfig().dance.name:
        parts.append(config["dance"]["name"])
    changed = [name for name in ("sensing", "layout", "dancers") if config[name] != default[name]]
    return ", ".join([*parts, *(f"{name} {config[name]}" for name in changed)])


def remarks(summary: Mapping[str, Any]) -> list[str]:
    """What the table does not hold: detectors, robot, net latency, bodies and notices, one line each."""
    detector = summary["detector"]
    lines = [
        f"detectors: recall {_number(detector['recall'])} in sight, precision {_number(detector['precision'])}, "
        f"95 % of times within {_number(detector['timing_p95_s'])} s"
    ]

    robot = summary["robot"]
    if robot["commands"]:  # none in a session without a robot
        lines.append(
            f"robot: {robot['commands']} commands, {_number(robot['executed'])} of them executed, "
            f"ended {_number(robot['end_distance_m'], 2)} m from its slot"
        )

    latencies = summary["net_latency_s"]
    if latencies:
        count = sum(item["n"] for item in latencies.values())
        # The mean over all events: each kind counts as often as it happened.
        mean_s = sum(item["mean"] * item["n"] for item in latencies.values()) / count
        by_kind = ", ".join(f"{kind} {item['mean']:+.2f}" for kind, item in latencies.items())
        lines.append(f"net latency: {mean_s:+.2f} s ({by_kind})")

    lines.append(
        f"bodies: {summary['falls']} falls, feet carry {_number(summary['feet_load_share'])} of the weight, "
        f"balance support {_number(summary['tether_rms_n'], 1)} N"
    )
    return lines + [f"notice at {item['t_s']:.1f} s: {item['source']}: {item['what']}" for item in summary["notices"]]


def _number(value: float | None, digits: int = 3) -> str:
    """A number with so many decimals; ``-`` for what was not measured."""
    return "-" if value is None else f"{value:.{digits}f}"
