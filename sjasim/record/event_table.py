"""The event table, ours or a laboratory's: who did what when, from CSV or Parquet, every row accounted for.

Columns ``session, iteration, agent, kind, t_s``, and ``early`` if there is one; others are not looked at. Semicolons or
tabs may part them, and times then have decimal commas. A session's ``cues`` table (``dancer, move, iteration, t_s,
duration_s``) says the same in other words and is read too.
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
CUE_COLUMNS = ("dancer", "move", "iteration", "t_s", "duration_s")
_CUE_KINDS = {
    Move.FORWARD: (Kind.START_FORWARD, Kind.STOP_FORWARD),
    Move.BACKWARD: (Kind.START_BACKWARD, Kind.STOP_BACKWARD),
    Move.CLAP: (Kind.CLAP,),
    Move.TURN: (Kind.TURN,),
}
_TIMES = ("t_s", "duration_s")
_TRUTHS = {"true": True, "1": True, "false": False, "0": False, "": False, "none": False}


def read_event_table(path: Path) -> tuple[TableEvent, ...]:
    """Read an event table.

    Args:
        path: a ``.csv`` or ``.parquet`` file, or a session's folder, whose ``cues`` are then read.

    Returns:
        every row, in the file's order.

    Raises:
        RecordError: the file cannot be read, lacks a column, is empty, or a row is wrong: its line and column are
            named. An agent's regular events must stand in the order in which they happened.
    """
    if path.is_dir():
        path = path / "cues.parquet"
    rows = list(_rows(path))
    if not rows:
        raise RecordError(f"{path} holds no events")
    columns = rows[0][1].keys()
    cues = "move" in columns and "kind" not in columns
    missing = [name for name in (CUE_COLUMNS if cues else COLUMNS) if name not in columns]
    if missing:
        raise RecordError(f"{path} is no event table: it lacks the column {missing[0]!r}")
    read = _cue if cues else _event
    events = tuple(event for line, row in rows for event in read(path, line, row))
    _check_order(path, events)
    return events


def _rows(path: Path) -> Iterator[tuple[int, Mapping[str, Any]]]:
    """Lines with their numbers; values are strings (CSV) or typed (Parquet)."""
    if path.suffix.lower() not in (".csv", ".parquet"):
        raise RecordError(f"{path} is no event table: name a .csv or .parquet file, or a session's folder")
    try:
        if path.suffix.lower() == ".parquet":
            import pyarrow.parquet as pq

            yield from enumerate(pq.read_table(path).to_pylist(), start=1)
            return
        with path.open(newline="", encoding="utf-8-sig") as file:
            between = separator(file.readline())
            file.seek(0)
            reader = csv.DictReader(file, skipinitialspace=True, delimiter=between)
            for row in reader:
                if None in row or None in row.values():
                    allowed = f"{len(reader.fieldnames or ())} values, as the first line has"
                    raise RecordError(f"{path}, line {reader.line_num}: {allowed}")
                yield reader.line_num, row if between == "," else _with_points(row)
    except FileNotFoundError:
        raise RecordError(f"{path} does not exist") from None
    except (OSError, ValueError, csv.Error) as error:
        raise RecordError(f"{path} cannot be read: {str(error).splitlines()[0]}") from None


def separator(header: str) -> str:
    """What stands between the columns of a CSV file, by its first line: comma, semicolon or tab."""
    return max(",;\t", key=header.count)


def _with_points(row: Mapping[str, str]) -> dict[str, str]:
    """Times of a row with points for decimal commas."""
    return {name: value.replace(",", ".") if name in _TIMES else value for name, value in row.items()}


def _event(path: Path, line: int, row: Mapping[str, Any]) -> list[TableEvent]:
    at = _Place(path, line)
    event = TableEvent(
        session=at.text("session", row),
        iteration=at.count("iteration", row),
        agent=at.text("agent", row),
        kind=Kind(at.word("kind", row, [kind.value for kind in Kind])),
        t_s=at.seconds("t_s", row),
        early=at.truth("early", row),
        line=line,
    )
    return [event]


def _cue(path: Path, line: int, row: Mapping[str, Any]) -> list[TableEvent]:
    at = _Place(path, line)
    kinds = _CUE_KINDS[Move(at.word("move", row, [move.value for move in _CUE_KINDS]))]
    t_s, duration_s = at.seconds("t_s", row), at.seconds("duration_s", row)
    who = at.count("iteration", row), at.text("dancer", row)
    return [TableEvent("", *who, kind, t_s + k * duration_s, False, line) for k, kind in enumerate(kinds)]


@dataclass(frozen=True, slots=True)
class _Place:
    """A line of a file; its methods read one column each or say what is wrong there."""

    path: Path
    line: int

    def wrong(self, column: str, value: object, allowed: str) -> RecordError:
        return RecordError(f"{self.path}, line {self.line}, column {column!r}: {value!r} is not {allowed}")

    def text(self, column: str, row: Mapping[str, Any]) -> str:
        value = row[column]
        if value is None or not str(value).strip():
            raise self.wrong(column, value, "a name")
        return str(value).strip()

    def word(self, column: str, row: Mapping[str, Any], allowed: Sequence[str]) -> str:
        value = str(row[column]).strip()
        if value not in allowed:
            raise self.wrong(column, value, f"one of {', '.join(allowed)}")
        return value

    def count(self, column: str, row: Mapping[str, Any]) -> int:
        value = self._number(column, row, "a whole number, 0 or more")
        if value < 0 or value != int(value):
            raise self.wrong(column, row[column], "a whole number, 0 or more")
        return int(value)

    def seconds(self, column: str, row: Mapping[str, Any]) -> float:
        return self._number(column, row, "a number of seconds")

    def truth(self, column: str, row: Mapping[str, Any]) -> bool:
        value = str(row.get(column, "")).strip().lower()
        if value not in _TRUTHS:
            raise self.wrong(column, row[column], "true or false")
        return _TRUTHS[value]

    def _number(self, column: str, row: Mapping[str, Any], allowed: str) -> float:
        try:
            value = float(row[column])
        except (TypeError, ValueError):
            raise self.wrong(column, row[column], allowed) from None
        if not math.isfinite(value):
            raise self.wrong(column, row[column], allowed)
        return value


def _check_order(path: Path, events: Sequence[TableEvent]) -> None:
    """Refuse events of an agent that go back in time or in iteration."""
    last: dict[tuple[str, str], TableEvent] = {}
    for event in events:
        if event.early:
            continue
        before = last.get((event.session, event.agent), event)
        if event.t_s < before.t_s or event.iteration < before.iteration:
            column, allowed = "t_s", f"{before.t_s:g} s or later"
            value: float = event.t_s
            if event.iteration < before.iteration:
                column, allowed, value = "iteration", f"{before.iteration} or higher", event.iteration
            what = f"at least that of {event.agent}'s event in line {before.line}: {allowed}"
            raise _Place(path, event.line).wrong(column, value, what)
        last[event.session, event.agent] = event
