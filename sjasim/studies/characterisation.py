"""Accuracy of the joints, the detectors and the robot over several sessions, with its report."""

from __future__ import annotations

import itertools
import json
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from rich.console import Console

from ..commands.progress import progress_bar
from ..config import SessionConfig
from ..config.toml_file import to_plain
from ..core.errors import ConfigError

FILE = "characterise.json"
"""Name of the file with the figures."""


@dataclass(frozen=True)
class Design:
    """Which sessions are simulated.

    Attributes:
        sessions: number of seeds. Each seed is simulated once with every layout and every source of the skeletons, so
            that 3 seeds of 2 layouts and 2 sources are 12 sessions.
        layouts: where the dancers stand: square, rows, custom.
        sensings: sources of the skeletons: joints, depth.
    """

    sessions: int = 3
    layouts: tuple[str, ...] = ("square", "rows")
    sensings: tuple[str, ...] = ("joints", "depth")

    def configs(self, common: SessionConfig) -> list[SessionConfig]:
        """Configurations of all sessions.

        Args:
            common: what they have in common. Its seed is the first one's; its layout and sensing are not used.

        Raises:
            ConfigError: there would be no session, or a value is not allowed.
        """
        if self.sessions < 1:
            raise ConfigError("sessions", self.sessions, "at least 1")
        for name, values in (("layouts", self.layouts), ("sensings", self.sensings)):
            if not values or len(set(values)) < len(values):
                raise ConfigError(name, values, "one or more different names")

        # Own slots are refused with any other layout than the custom one.
        scenes = dict.fromkeys(self.layouts, common.scene)
        if "custom" in self.layouts:
            scenes = {name: scene if name == "custom" else replace(scene, slots_m=()) for name, scene in scenes.items()}

        seeds = range(common.seed, common.seed + self.sessions)
        return [
            replace(common, sensing=sensing, layout=layout, seed=seed, scene=scenes[layout])
            for sensing, layout, seed in itertools.product(self.sensings, self.layouts, seeds)
        ]


def checked_configs(design: Design, common: SessionConfig) -> list[SessionConfig]:
    """Configurations of all sessions, checked for what would stop one of them.

    Args:
        design: which sessions are simulated.
        common: what they have in common.

    Raises:
        SjasimError: a value is not allowed, a name is unknown, a layout does not fit, or a configuration file gives the
            layout or the sensing of one session.
    """
    from ..choreography.layout import layout
    from ..core.registry import resolve

    for name in ("layout", "sensing"):
        value = getattr(common, name)
        if value != getattr(SessionConfig(), name):
            raise ConfigError(name, value, f"here --{name}s names those of all sessions")

    configs = design.configs(common)
    for config in configs:
        resolve("sensing", config.sensing)
        layout(config)
    return configs


def characterise(configs: Sequence[SessionConfig]) -> dict[str, Any]:
    """Simulate the sessions, with a progress bar on stderr, and return the content of characterise.json."""
    from ..analysis.accuracy import detection_accuracy, skeleton_accuracy, timing_delays
    from ..session.session import package_versions, run_session

    joints: list[skeleton_accuracy.JointObservation] = []
    outcomes: list[detection_accuracy.Outcome] = []
    executions: list[detection_accuracy.Execution] = []
    delays: list[tuple[SessionConfig, list[timing_delays.DelayObservation], float]] = []
    minutes = dict.fromkeys((config.sensing for config in configs), 0.0)

    with progress_bar(Console(stderr=True)) as progress:
        task = progress.add_task("simulating", total=float(len(configs)))
        for index, config in enumerate(configs):
            which = f"session {index + 1} of {len(configs)}: {config.sensing}, {config.layout}, seed {config.seed}"
            progress.update(task, description=which)

            def report(share: float, done: int = index) -> None:
                progress.update(task, completed=done + share)

            log = run_session(config, report)
            joints += skeleton_accuracy.joint_observations(log)
            outcomes += detection_accuracy.event_outcomes(log)
            executions += detection_accuracy.command_executions(log)
            delays.append((config, timing_delays.delay_observations(log), log.cost["sim_s"]))
            minutes[config.sensing] += config.dancers * log.cost["sim_s"] / 60.0

    return {
        "schema": 1,
        "seed": configs[0].seed,
        "sessions": [{"sensing": one.sensing, "layout": one.layout, "seed": one.seed} for one in configs],
        "versions": package_versions(),
        "config": to_plain(configs[0]),
        "joints": skeleton_accuracy.joint_rows(joints),
        "detector": detection_accuracy.detector_rows(outcomes),
        "robot": detection_accuracy.robot_rows(executions),
        "quantiles": list(detection_accuracy.QUANTILES),
        "distributions": detection_accuracy.distributions(outcomes, minutes),
        "timing": timing_delays.statistics_tables(delays),
    }


def as_json(report: Mapping[str, Any]) -> str:
    """The report as JSON text."""
    return json.dumps(report, indent=1, allow_nan=False) + "\n"


def save_report(report: Mapping[str, Any], folder: Path, overwrite: bool) -> None:
    """Write characterise.json and its page, report.html, to a folder, both or none.

    Raises:
        RecordError: the folder cannot be written.
    """
    from ..record.atomic_folder import atomic_folder, check_target
    from .report.folders import write_report

    with atomic_folder(check_target(folder, overwrite, holds=FILE), overwrite) as draft:
        (draft / FILE).write_text(as_json(report), encoding="utf-8")
        write_report(draft)


def print_report(report: Mapping[str, Any], json_only: bool) -> None:
    """Print the report as JSON, or its verdict and a table of the regular events for each source of skeletons."""
    from ..commands.tables import print_table
    from .report.characterisation_page import event_tables, verdict

    if json_only:
        sys.stdout.write(as_json(report))
        return
    for sentence in verdict(report):
        sys.stdout.write(f"{sentence}\n")
    for table in event_tables(report):
        print_table(table.head, [[str(cell.text) for cell in row] for row in table.rows], title=table.caption)
