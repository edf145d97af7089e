"""Reads event tables (CSV or Parquet) of this package or of a laboratory; every row is checked.

Columns are ``session, iteration, agent, kind, t_s`` and optionally ``early``; other columns are ignored. CSV columns
are separated by commas, semicolons or tabs; with semicolons or tabs, times may have decimal commas. A session's
``cues`` table (``dancer, move, iteration, t_s, duration_s``) is converted to the events that the cues plan.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..core import Kind, Move
from ..core.errors import RecordError
from ..core.session_log import TableEvent

COLUMNS = ("session", "iteration", "agent", "kind", "t_s")
"""Columns that an event table must have."""

CUE_COLUMNS = ("dancer", "move", "iteration", "t_s", "duration_s")
"""Columns that a table of cues must have."""

_CUE_KINDS = {
    Move.FORWARD: (Kind.START_FORWARD, Kind.STOP_FORWARD),
    Move.BACKWARD: (Kind.START_BACKWARD, Kind.STOP_BACKWARD),
    Move.CLAP: (Kind.CLAP,),
    Move.TURN: (Kind.TURN,),
}
"""Planned move -> events at its start and, if there are two, at its end."""

_TIME_COLUMNS = ("t_s", "duration_s")
"""Columns that may have decimal commas."""

_BOOLEANS = {"true": True, "1": True, "false": False, "0": False, "": False, "none": False}
"""Accepted words of the ``early`` column, in lower case; an empty cell is False."""


def read_event_table(path: Path) -> tuple[TableEvent, ...]:
    """Read an event table.

    Args:
        path: a ``.csv`` or ``.parquet`` file, or a session's folder, of which the ``cues`` table is read.

    Returns:
        The event of every row, in the order of the file; a cue with a start and a stop gives two.

    Raises:
        RecordError: the file cannot be read, lacks a column, is empty, or a row is invalid; the message names the line
            and the column. An agent's regular events must be in order of time.
    """
    if path.is_dir():
        path = path / "cues.parquet"
    rows = list(_rows(path))
    if not rows:
        raise RecordError(f"{path} holds no events")

    columns = rows[0][1].keys()
    is_cue_table = "move" in columns and "kind" not in columns
    missing = [name for name in (CUE_COLUMNS if is_cue_table else COLUMNS) if name not in columns]
    if missing:
        raise RecordError(f"{path} is no event table: it lacks the column {missing[0]!r}")

    parse = _parse_cue if is_cue_table else _parse_event
    events = tuple(event for line, row in rows for event in parse(_Row(path, line, row)))
    _check_order(path, events)
    return events


def separator(header: str) -> str:
    """Column separator of a CSV file, judged by its first line: comma, semicolon or tab."""
    return max(",;\t", key=header.count)


def _rows(path: Path) -> Iterator[tuple[int, Mapping[str, Any]]]:
    """Yield (line number, column -> value); values are strings in CSV and typed in Parquet."""
    suffix = path.suffix.lower()
    if suffix not in (".csv", ".parquet"):
        raise RecordError(f"{path} is no event table: name a .csv or .parquet file, or a session's folder")

    try:
        if suffix == ".parquet":
            import pyarrow.parquet as pq

            yield from enumerate(pq.read_table(path).to_pylist(), start=1)
        else:
            yield from _csv_rows(path)
    except FileNotFoundError:
        raise RecordError(f"{path} does not exist") from None
    except (OSError, ValueError, csv.Error) as error:
        raise RecordError(f"{path} cannot be read: {str(error).splitlines()[0]}") from None


def _csv_rows(path: Path) -> Iterator[tuple[int, Mapping[str, Any]]]:
    """Yield the rows of a CSV file; the header is line 1."""
    # Excel writes a byte-order mark, which utf-8-sig removes.
    with path.open(newline="", encoding="utf-8-sig") as file:
        delimiter = separator(file.readline())
        file.seek(0)
        reader = csv.DictReader(file, skipinitialspace=True, delimiter=delimiter)

        for row in reader:
            # DictReader files surplus values under None and fills missing ones with None.
            if None in row or None in row.values():
                allowed = f"{len(reader.fieldnames or ())} values, as the first line has"
                raise RecordError(f"{path}, line {reader.line_num}: {allowed}")
            yield reader.line_num, row if delimiter == "," else _with_decimal_points(row)


def _with_decimal_points(row: Mapping[str, str]) -> dict[str, str]:
    """A row with decimal points instead of decimal commas in its times."""
    return {name: value.replace(",", ".") if name in _TIME_COLUMNS else value for name, value in row.items()}


def _parse_event(row: _Row) -> list[TableEvent]:
    """The event of one row of an event table."""
    event = TableEvent(
        session=row.name("session"),
        iteration=row.count("iteration"),
        agent=row.name("agent"),
        kind=Kind(row.choice("kind", [kind.value for kind in Kind])),
        t_s=row.seconds("t_s"),
        early=row.boolean("early"),
        line=row.line,
    )
    return [event]


def _parse_cue(row: _Row) -> list[TableEvent]:
    """The events that one row of a table of cues plans."""
    kinds = _CUE_KINDS[Move(row.choice("move", [move.value for move in _CUE_KINDS]))]
    t_s = row.seconds("t_s")
    duration_s = row.seconds("duration_s")
    iteration = row.count("iteration")
    dancer = row.name("dancer")

    return [
        TableEvent("", iteration, dancer, kind, t_s + k * duration_s, False, row.line) for k, kind in enumerate(kinds)
    ]


@dataclass(frozen=True, slots=True)
class _Row:
    """One row of a file. Each method parses one column, or raises `RecordError` that names file, line and column.

    Attributes:
        path: the file.
        line: line number, for messages.
        values: column -> value, a string or typed.
    """

    path: Path
    line: int
    values: Mapping[str, Any]

    def invalid(self, column: str, allowed: str) -> RecordError:
        """The error for a value that is not allowed."""
        return _invalid(self.path, self.line, column, self.values[column], allowed)

    def name(self, column: str) -> str:
        """A string that is not empty."""
        value = self.values[column]
        if value is None or not str(value).strip():
            raise self.invalid(column, "a name")
        return str(value).strip()

    def choice(self, column: str, allowed: Sequence[str]) -> str:
        """One of some words."""
        value = str(self.values[column]).strip()
        if value not in allowed:
            raise _invalid(self.path, self.line, column, value, f"one of {', '.join(allowed)}")
        return value

    def count(self, column: str) -> int:
        """A whole number, 0 or more."""
        value = self._number(column, "a whole number, 0 or more")
        if value < 0 or value != int(value):
            raise self.invalid(column, "a whole number, 0 or more")
        return int(value)

    def seconds(self, column: str) -> float:
        """A finite number."""
        return self._number(column, "a number of seconds")

    def boolean(self, column: str) -> bool:
        """True or false; False without the column."""
        value = str(self.values.get(column, "")).strip().lower()
        if value not in _BOOLEANS:
            raise self.invalid(column, "true or false")
        return _BOOLEANS[value]

    def _number(self, column: str, allowed: str) -> float:
        try:
            value = float(self.values[column])
        except (TypeError, ValueError):
            raise self.invalid(column, allowed) from None
        if not math.isfinite(value):
            raise self.invalid(column, allowed)
        return value


def _invalid(path: Path, line: int, column: str, value: object, allowed: str) -> RecordError:
    """The error for one cell of a file."""
    return RecordError(f"{path}, line {line}, column {column!r}: {value!r} is not {allowed}")


def _check_order(path: Path, events: Sequence[TableEvent]) -> None:
    """Check that every agent's regular events go forward in time and in iteration.

    Early events are exempt: they announce a later event and may be logged after it.

    Raises:
        RecordError: an event goes back.
    """
    last: dict[tuple[str, str], TableEvent] = {}

    for event in events:
        if event.early:
            continue

        before = last.get((event.session, event.agent), event)
        requirement = f"at least that of {event.agent}'s event in line {before.line}:"
        if event.iteration < before.iteration:
            allowed = f"{requirement} {before.iteration} or higher"
            raise _invalid(path, event.line, "iteration", event.iteration, allowed)
        if event.t_s < before.t_s:
            raise _invalid(path, event.line, "t_s", event.t_s, f"{requirement} {before.t_s:g} s or later")

        last[event.session, event.agent] = event
