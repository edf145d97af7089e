"""Reproduction of the published study: every value of the paper beside its distribution over simulated studies."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..analysis.published_values import METHODS, PUBLISHED, PublishedValue, StudyArrays, study_arrays
from ..commands.tables import print_table
from ..config import SessionConfig
from ..core import Array
from .paper_findings import findings
from .reproduction_options import PAPER, ReproductionOptions
from .reproduction_report import as_json, save_content
from .study_design import StudyDesign
from .study_execution import run_study

SCHEMA = 1
"""Version of the format of reproduce.json."""

INTERVAL = (2.5, 97.5)
"""Percentiles of the simulated studies between which a published value passes."""

HYPOTHESES: Mapping[str, Mapping[str, int]] = {"paper-warmup": {"first_followed_iteration": 3}}
"""Preset -> options of SIA that belong to the same hypothesis.

Under the hypothesis of a warm-up, the first two danced iterations are practice: SIA follows a dancer from the third one
on, and the dancers become steadier from one iteration to the next, whatever the robot does.
"""

COLUMNS = ("value", "method", "paper", "simulated", "low", "high", "inside")
"""Of the table that is printed; low and high are the ends of the interval."""


def study_design(options: ReproductionOptions, seeds: str = "evaluation") -> StudyDesign:
    """The design of the published study, simulated many times.

    The humans-only session is left out: the paper reports no value of it, and it does not change the other sessions.

    Args:
        options: people, size and seed.
        seeds: set of the groups' seeds, ``evaluation`` or ``tuning``.
    """
    session = SessionConfig(
        fidelity=options.fidelity, sensing="joints", method_options=dict(HYPOTHESES.get(options.humans, {}))
    )
    return StudyDesign(
        groups=options.groups,
        methods=METHODS,
        humans=(options.humans,),
        replications=options.studies,
        humans_only=False,
        events=False,
        seed=options.seed,
        seeds=seeds,
        session=session,
    )


@dataclass(frozen=True, slots=True)
class PaperReproduction:
    """Result of the reproduction of the published study; implements the protocol `Report`.

    Attributes:
        options: what was simulated.
        rows: one row for each published value, as in reproduce.json.
        findings: the findings, as in reproduce.json.
    """

    options: ReproductionOptions
    rows: Sequence[Mapping[str, Any]]
    findings: Sequence[Mapping[str, Any]]

    def content(self) -> dict[str, Any]:
        """Content of reproduce.json."""
        from ..session.session import package_versions

        options = self.options
        return {
            "schema": SCHEMA,
            "study": PAPER,
            "preset": options.humans,
            "hypothesis": dict(HYPOTHESES.get(options.humans, {})),
            "studies": options.studies,
            "groups": options.groups,
            "fidelity": options.fidelity,
            "seed": options.seed,
            "versions": dict(package_versions()),
            "rows": list(self.rows),
            "findings": list(self.findings),
        }

    def print(self, json_only: bool) -> None:
        """See `Report.print`."""
        if json_only:
            sys.stdout.write(as_json(self.content()))
            return

        for role in ("fitted", "held_out"):
            own = [row for row in self.rows if row["role"] == role]
            title = f"{role.replace('_', '-')} values, people {self.options.humans}, {self.options.studies} studies"
            print_table(COLUMNS, [_cells(row) for row in own], title=title, left=(0, 1))
        for finding in self.findings:
            interval = f"{finding['mean']:.3f} [{finding['low']:.3f}, {finding['high']:.3f}]"
            sys.stdout.write(f"{finding['title']}. {finding['text']} {interval}\n")
        sys.stdout.write(f"{summary(self.rows)}\n")

    def save(self, folder: Path, overwrite: bool) -> None:
        """See `Report.save`."""
        save_content(self.content(), folder, overwrite)


def reproduce_paper(options: ReproductionOptions) -> PaperReproduction:
    """Simulate the published study many times.

    Raises:
        SjasimError: the people do not exist, or a session failed.
    """
    studies = study_arrays(run_study(study_design(options), jobs=options.jobs))
    found = findings(options.humans, options.seed, options.jobs) if options.findings else []
    return PaperReproduction(options, value_rows(studies), found)


def value_rows(studies: StudyArrays) -> list[dict[str, Any]]:
    """One row for each published value: the paper's, and mean and interval over the simulated studies."""
    return [_row(value, value.compute(studies)) for value in PUBLISHED]


def _row(published: PublishedValue, simulated: Array) -> dict[str, Any]:
    low, high = (float(end) for end in np.nanpercentile(simulated, INTERVAL))
    return {
        "value": published.name,
        "method": published.method,
        "meaning": published.meaning,
        "paper": published.value,
        "mean": float(np.nanmean(simulated)),
        "low": low,
        "high": high,
        "inside": bool(low <= published.value <= high),
        "role": published.role.replace(" ", "_"),
    }


def summary(rows: Sequence[Mapping[str, Any]]) -> str:
    """One line: how many values are inside, and which are not."""
    outside = [f"{row['value']} {row['method']}".strip() for row in rows if not row["inside"]]
    held_out = [row["inside"] for row in rows if row["role"] == "held_out"]
    line = f"inside: {len(rows) - len(outside)} of {len(rows)} values, {sum(held_out)} of {len(held_out)} held out"
    return f"{line}; outside: {', '.join(outside)}" if outside else line


def _cells(row: Mapping[str, Any]) -> tuple[str, ...]:
    figures = (f"{row[key]:.3f}" for key in ("paper", "mean", "low", "high"))
    return (row["value"], row["method"], *figures, "yes" if row["inside"] else "no")
