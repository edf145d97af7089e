"""Report of a reproduced study: one row for each value that people produced, beside the simulated one."""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Literal

from ..commands.tables import print_table
from ..record.atomic_folder import atomic_folder, check_target

FILE = "reproduce.json"
"""Name of the report in its folder."""

SCHEMA = 1
"""Version of the report's format."""

COLUMNS = ("value", "condition", "people", "model", "low", "high", "in")
"""Of the table that is printed: low and high are the ends of the interval; the last says whether it holds people's."""

ROLES: Sequence[Literal["fitted", "held out"]] = ("fitted", "held out")
"""What a value was for the model's parameters, in the order in which they are printed."""


@dataclass(frozen=True, slots=True)
class ReproducedValue:
    """A value that people produced, and where simulated studies of the same size put it.

    Attributes:
        value: what was measured, with its unit.
        condition: in which condition.
        people: what people produced.
        mean: mean over simulated studies.
        low: lower end of the interval that holds 95 % of simulated studies.
        high: upper end.
        role: ``fitted`` if the model's parameters were fitted to the value, else ``held out``.
        source: where the value of people comes from.
    """

    value: str
    condition: str
    people: float
    mean: float
    low: float
    high: float
    role: Literal["fitted", "held out"]
    source: str

    @property
    def inside(self) -> bool:
        """Whether people's value lies inside the interval."""
        return self.low <= self.people <= self.high


@dataclass(frozen=True, slots=True)
class Reproduction:
    """Result of the reproduction of a study.

    Attributes:
        study: which study.
        settings: options of the reproduction.
        rows: the values.
        details: further results, by name.
    """

    study: str
    settings: Mapping[str, Any]
    rows: Sequence[ReproducedValue]
    details: Mapping[str, Any] = field(default_factory=dict)

    def content(self) -> dict[str, Any]:
        """Content of reproduce.json."""
        from ..session.session import package_versions

        return {
            "schema": SCHEMA,
            "study": self.study,
            "versions": dict(package_versions()),
            "settings": dict(self.settings),
            "rows": [{**asdict(row), "inside": row.inside} for row in self.rows],
            **self.details,
        }

    def print(self, json_only: bool) -> None:
        """Print a table for each role and a summary on stdout, or reproduce.json and nothing else."""
        if json_only:
            sys.stdout.write(as_json(self.content()))
            return

        for role in ROLES:
            own = [row for row in self.rows if row.role == role]
            if own:
                print_table(COLUMNS, table_rows(own), title=f"{role} values of {self.study}", left=(0, 1))
        sys.stdout.write(f"{summary(self.rows)}\n")

    def save(self, folder: Path, overwrite: bool) -> None:
        """Write reproduce.json to a folder.

        Raises:
            RecordError: the folder cannot be written.
        """
        save_content(self.content(), folder, overwrite)


def table_rows(rows: Sequence[ReproducedValue]) -> list[tuple[str, ...]]:
    """Cells of the rows' table, in the order of `COLUMNS`."""
    return [
        (
            row.value,
            row.condition,
            *map(_figure, (row.people, row.mean, row.low, row.high)),
            "yes" if row.inside else "no",
        )
        for row in rows
    ]


def summary(rows: Sequence[ReproducedValue]) -> str:
    """One line: how many values are inside, of those that were fitted and of those that were held out."""
    counts = []
    for role in ROLES:
        own = [row.inside for row in rows if row.role == role]
        if own:
            counts.append(f"{sum(own)} of {len(own)} {role}")
    return f"inside: {', '.join(counts)} values"


def save_content(content: Mapping[str, Any], folder: Path, overwrite: bool) -> None:
    """Write reproduce.json to a folder.

    Raises:
        RecordError: the folder cannot be written.
    """
    with atomic_folder(check_target(folder, overwrite, holds=FILE), overwrite) as draft:
        (draft / FILE).write_text(as_json(content), encoding="utf-8")


def as_json(content: Mapping[str, Any]) -> str:
    """Text of reproduce.json."""
    return json.dumps(content, indent=1, allow_nan=False) + "\n"


def _figure(value: float) -> str:
    """Three digits, without an exponent."""
    if abs(value) >= 10.0:
        return f"{value:.1f}"
    return f"{value:.2f}" if abs(value) >= 1.0 else f"{value:.3f}"
