"""``python -m sjasim.characterise``: the report card of detectors and robot, from several sessions."""

from __future__ import annotations

import itertools
import json
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any

import tyro
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

from .commands.options import config_from, main, parse
from .config import SessionConfig
from .config.toml_file import to_plain
from .core.errors import ConfigError
from .record.atomic_folder import atomic_folder, check_target

ABOUT = "How well joints are found, starts, stops and claps detected, and the robot obeys, over several sessions."

FILE, PAGE = "characterise.json", "characterise.md"


@dataclass(frozen=True)
class Options:
    """Report card of detectors and robot.

    Attributes:
        session: what every session has in common; its seed is the first one's, its layout and sensing are not used.
        sessions: how many seeds: each is danced once with every layout on every sensing route, so that 3 seeds of 2
            layouts on 2 routes are 12 sessions.
        layouts: where people stand.
        sensings: where skeletons come from.
        out: folder for characterise.json and a page to read; new or empty.
        overwrite: replace earlier ones.
        json: print characterise.json, and nothing else, on stdout.
        config: TOML file of the sessions' fields; flags override it.
    """

    session: Annotated[SessionConfig, tyro.conf.arg(name="")]
    sessions: int = 3
    layouts: tuple[str, ...] = ("square", "rows")
    sensings: tuple[str, ...] = ("joints", "depth")
    out: Path | None = None
    overwrite: bool = False
    json: bool = False
    config: Path | None = None

    def designs(self) -> list[SessionConfig]:
        """Every session that is danced.

        Raises:
            ConfigError: there would be none, or a value is not allowed.
        """
        if self.sessions < 1:
            raise ConfigError("sessions", self.sessions, "at least 1")
        for name, values in (("layouts", self.layouts), ("sensings", self.sensings)):
            if not values or len(set(values)) < len(values):
                raise ConfigError(name, values, "one or more different names")
        seeds = range(self.session.seed, self.session.seed + self.sessions)
        room = self.session.scene
        own = "custom" in self.layouts  # which alone has the room's slots; without it they are refused
        rooms = {name: replace(room, slots_m=()) if own and name != "custom" else room for name in self.layouts}
        return [
            replace(self.session, sensing=sensing, layout=layout, seed=seed, scene=rooms[layout])
            for sensing, layout, seed in itertools.product(self.sensings, self.layouts, seeds)
        ]


def command(arguments: Sequence[str]) -> None:
    """Parse, check, dance, judge, keep, show."""
    options = parse(Options, arguments, Options(config_from(arguments)), "python -m sjasim.characterise", ABOUT)
    check_common(options.session, arguments)
    designs = options.designs()
    for design in designs:
        check(design)
    if options.out is not None:
        check_target(options.out, options.overwrite, holds=FILE)
    card = characterise(designs)
    text = json.dumps(card, indent=1, allow_nan=False) + "\n"
    if options.out is not None:
        with atomic_folder(check_target(options.out, options.overwrite, holds=FILE), options.overwrite) as draft:
            (draft / FILE).write_text(text, encoding="utf-8")
            (draft / PAGE).write_text(page(card), encoding="utf-8")
        sys.stderr.write(f"kept in {options.out}\n")
    sys.stdout.write(text if options.json else page(card))


def check_common(session: SessionConfig, arguments: Sequence[str]) -> None:
    """Refuse a layout or sensing of one session where those of all are named by other options.

    Raises:
        ConfigError: one is given on the command line or in the configuration file.
    """
    for name in ("layout", "sensing"):
        value = getattr(session, name)
        given = any(word.partition("=")[0] == f"--{name}" for word in arguments)
        if given or value != getattr(SessionConfig(), name):
            raise ConfigError(name, value, f"here --{name}s names those of all sessions")


def check(design: SessionConfig) -> None:
    """Find out before the first dance what would stop a later one.

    Raises:
        SjasimError: a name is unknown or the layout does not fit.
    """
    from .choreography.layout import layout
    from .core.registry import resolve

    resolve("sensing", design.sensing)
    layout(design)


def characterise(designs: Sequence[SessionConfig]) -> dict[str, Any]:
    """Dance sessions and make characterise.json's content."""
    from .analysis.accuracy import detection_accuracy, skeleton_accuracy
    from .session.session import package_versions, run_session

    seen: list[skeleton_accuracy.JointObservation] = []
    found: list[detection_accuracy.Outcome] = []
    done: list[detection_accuracy.Execution] = []
    minutes = dict.fromkeys((design.sensing for design in designs), 0.0)
    columns = (TextColumn("{task.description}"), BarColumn(), TextColumn("{task.percentage:.0f} %"))
    with Progress(*columns, TimeRemainingColumn(), console=Console(stderr=True), transient=True) as progress:
        task = progress.add_task("dancing", total=float(len(designs)))
        for index, design in enumerate(designs):
            which = f"session {index + 1} of {len(designs)}: {design.sensing}, {design.layout}, seed {design.seed}"
            progress.update(task, description=which)

            def report(share: float, begun: int = index) -> None:
                progress.update(task, completed=begun + share)

            log = run_session(design, report)
            seen += skeleton_accuracy.joint_observations(log)
            found += detection_accuracy.event_outcomes(log)
            done += detection_accuracy.command_executions(log)
            minutes[design.sensing] += design.dancers * log.cost["sim_s"] / 60.0
    return {
        "schema": 1,
        "seed": designs[0].seed,
        "sessions": [{"sensing": one.sensing, "layout": one.layout, "seed": one.seed} for one in designs],
        "versions": package_versions(),
        "config": to_plain(designs[0]),
        "joints": skeleton_accuracy.joint_rows(seen),
        "detector": detection_accuracy.detector_rows(found),
        "robot": detection_accuracy.robot_rows(done),
        "quantiles": list(detection_accuracy.QUANTILES),
        "distributions": detection_accuracy.distributions(found, minutes),
    }


def page(card: Mapping[str, Any]) -> str:
    """The report card for people, in Markdown."""
    sensings = sorted({one["sensing"] for one in card["sessions"]})
    layouts = ", ".join(sorted({one["layout"] for one in card["sessions"]}))
    seeds = sorted({one["seed"] for one in card["sessions"]})
    parts = [
        "# Report card of the detectors and the robot",
        f"{len(card['sessions'])} sessions: sensing {', '.join(sensings)}; layouts {layouts}; seeds "
        f"{', '.join(map(str, seeds))}. Errors are logged minus true times; recall counts every event that happened, "
        "hidden ones too. Of joints: shares tracked and inferred; of the tracked ones median and p95 of the distance "
        "to the truth, the share astray (more than .15 m off), constant and slow error per axis and the latter's "
        "correlation from frame to frame; r.m.s. error per axis of the inferred ones.",
    ]
    for sensing in sensings:
        rows = [row for row in card["detector"] if row["sensing"] == sensing]
        parts += [f"## {sensing} sensing, regular events", _detectors([row for row in rows if not row["early"]])]
        early = [row for row in rows if row["early"] and (row["row"], row["occlusion"]) == ("all", "all")]
        parts += [f"## {sensing} sensing, early events", _detectors(early)]
        rows = [row for row in card["joints"] if row["sensing"] == sensing and "all" in (row["row"], row["occlusion"])]
        parts += [f"## {sensing} sensing, joints", _joints(rows)]
    if card["robot"]:
        head = ("kind", "n", "delay_s", "jitter_s", "not_executed")
        parts += ["## Robot: from command to event", _table(head, card["robot"])]
    return "\n\n".join(parts) + "\n"


def _detectors(rows: Sequence[Mapping[str, Any]]) -> str:
    head = ("kind", "row", "occlusion", "n", "recall", "precision", "bias_s", "sd_s", "p95_s")
    return _table(head, rows)


def _joints(rows: Sequence[Mapping[str, Any]]) -> str:
    shares, distances = ("n", "tracked", "inferred"), ("median_m", "p95_m", "astray")
    errors = ("bias_m", "drift_m", "correlation", "inferred_m")
    return _table(("joints", "row", "occlusion", *shares, *distances, *errors), rows)


def _table(head: Sequence[str], rows: Sequence[Mapping[str, Any]]) -> str:
    lines = [list(head), ["---"] * len(head), *([_cell(row[name]) for name in head] for row in rows)]
    widths = [max(len(line[column]) for line in lines) for column in range(len(head))]
    return "\n".join(
        "| " + " | ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)) + " |" for line in lines
    )


def _cell(value: object) -> str:
    if value is None:
        return "-"
    return (f"{value:.4f}" if 0.0 < abs(value) < 0.1 else f"{value:.3f}") if isinstance(value, float) else str(value)


if __name__ == "__main__":
    sys.exit(main(command))
