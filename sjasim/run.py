"""``python -m sjasim.run``: dance one session, show its figures, keep it if a folder is named."""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import tyro
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from . import cli
from .anticipation import method
from .config import SessionConfig
from .logs import SessionLog

ABOUT = "One dance session: dancers, sensors, server, robot; its figures as a table."


@dataclass(frozen=True)
class Options:
    """One dance session.

    Attributes:
        session: the whole configuration; every field is a flag.
        out: folder to keep the session in; new or empty.
        json: print session.json, and nothing else, on stdout.
        config: TOML file of the session's fields; flags override it.
    """

    session: Annotated[SessionConfig, tyro.conf.arg(name="")]
    out: Path | None = None
    json: bool = False
    config: Path | None = None


def command(arguments: Sequence[str]) -> None:
    """Parse, check what can be checked beforehand, dance, measure, keep, show."""
    base = Options(cli.config_from(arguments))
    options = cli.parse(Options, arguments, base, "python -m sjasim.run", ABOUT)
    config = options.session
    if config.method != "none":
        method.build(config.method, config.method_options)
    if options.out is not None:
        from .record.folder import check_target

        check_target(options.out)
    log = dance(config)
    from .analysis.measures import measures

    summary = measures(log).as_dict()
    if options.out is not None:
        from .record.folder import write

        place = write(log, options.out, summary)
        sys.stderr.write(f"kept in {place}\n")
    if options.json:
        sys.stdout.write(json.dumps(summary, indent=1, allow_nan=False) + "\n")
    else:
        show(summary, Console())


def dance(config: SessionConfig) -> SessionLog:
    """Run the session with a progress bar on stderr; it appears once the session has been found fit to dance."""
    from .session import run_session

    columns = (TextColumn("{task.description}"), BarColumn(), TextColumn("{task.percentage:.0f} %"))
    progress = Progress(*columns, TimeRemainingColumn(), console=Console(stderr=True), transient=True)
    task = progress.add_task(f"dancing ({config.method}, seed {config.seed})", total=1.0)

    def report(share: float) -> None:
        progress.start()
        progress.update(task, completed=share)

    try:
        return run_session(config, report)
    finally:
        if progress.live.is_started:
            progress.stop()


def show(summary: Mapping[str, Any], console: Console) -> None:
    """Print a session's figures for people: a table by iteration, then a line for each part's work."""
    table = Table(title=f"{summary['method']}, seed {summary['seed']}, {summary['humans']} dancers")
    for name in ("iteration", "GSI", "GSI, full edges", "GSI, true onsets", "MSP", "TA [s]", "missed"):
        table.add_column(name, justify="right")
    for row in summary["iterations"]:
        indices = (_number(row[key]) for key in ("gsi", "gsi_full_edges", "gsi_truth"))
        table.add_row(str(row["index"]), *indices, row["msp"], _number(row["ta_mean_s"], 2), str(row["robot_missed"]))
    table.add_section()
    indices = (_number(summary[key]) for key in ("gsi", "gsi_full_edges", "gsi_truth"))
    table.add_row("mean", *indices, "", _number(summary["ta_mean_s"], 2), str(summary["robot"]["missed"]))
    console.print(table)
    for line in remarks(summary):
        console.print(line, markup=False, highlight=False)


def remarks(summary: Mapping[str, Any]) -> list[str]:
    """What the table does not hold, one line each."""
    detector, robot = summary["detector"], summary["robot"]
    lines = [
        f"detectors: recall {_number(detector['recall'])}, precision {_number(detector['precision'])}, "
        f"95 % of timings within {_number(detector['timing_p95_s'])} s"
    ]
    if robot["commands"]:
        lines.append(
            f"robot: {robot['commands']} commands, {_number(robot['executed'])} of them executed, "
            f"ended {_number(robot['end_distance_m'], 2)} m from its slot"
        )
    latencies = summary["net_latency_s"]
    if latencies:
        total = sum(item["n"] for item in latencies.values())
        pooled = sum(item["mean"] * item["n"] for item in latencies.values()) / total
        parts = ", ".join(f"{kind} {item['mean']:+.2f}" for kind, item in latencies.items())
        lines.append(f"net latency: {pooled:+.2f} s ({parts})")
    lines.append(
        f"bodies: {summary['falls']} falls, feet carry {_number(summary['feet_load_share'])} of the weight, "
        f"tether {_number(summary['tether_rms_n'], 1)} N"
    )
    return lines + [f"notice at {item['t_s']:.1f} s: {item['source']}: {item['what']}" for item in summary["notices"]]


def _number(value: float | None, digits: int = 3) -> str:
    return "-" if value is None else f"{value:.{digits}f}"


if __name__ == "__main__":
    sys.exit(cli.main(command))
