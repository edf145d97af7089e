"""Recorded joints from a table of anybody's: one row per frame, person and joint.

Written as laboratories write them: columns in any order, with commas, semicolons or tabs between them, decimal commas
where the columns are not parted by commas, joints by the Kinect's names or numbers, in upper or lower case.
"""

from __future__ import annotations

import csv
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.csv
import pyarrow.parquet as pq
from numpy.typing import NDArray

from ..assets.names import JOINT_INDEX, JOINTS
from ..core import INFERRED, NOT_TRACKED, TRACKED, Array, BoolArray, IntArray, RecordedJoints
from ..core.errors import RecordError
from ..core.session_log import natural_order
from .event_table import separator

COLUMNS = ("t_s", "person", "joint", "x_m", "y_m", "z_m")
"""What a table must have; ``state`` may be added."""

_EMPTY = pa.array(["", "-", "na", "n/a", "#n/a", "nan", "-nan", "nan(ind)", "-nan(ind)", "null", "none"])
_JOINT_CODES = {name.lower(): place for name, place in JOINT_INDEX.items()} | {str(k): k for k in range(len(JOINTS))}
_STATE_CODES = {"tracked": TRACKED, "inferred": INFERRED, "nottracked": NOT_TRACKED,
                "2": TRACKED, "1": INFERRED, "0": NOT_TRACKED}  # fmt: skip
_WANTED = f"wanted {', '.join(COLUMNS)} and perhaps state, in a row for each frame, person and joint"
_NONE = -1
"""The code of an empty cell and of a word that means nothing."""


def read_joints(path: str | Path) -> RecordedJoints:
    """Read a CSV or Parquet file with the columns `COLUMNS`.

    Without a column ``state`` a joint is tracked wherever its place is known. An empty cell, ``NaN`` or ``NA`` among
    the coordinates leaves the joint unknown.

    Raises:
        RecordError: the file cannot be read, or a row is wrong, which is named by its line.
    """
    table = _Table(Path(path))
    joint = table.codes("joint", _JOINT_CODES)
    table.refuse("joint", joint == _NONE, "a Kinect joint's name or number, such as SpineBase or 0")
    t_s, *places = (table.numbers(name) for name in COLUMNS if name not in ("person", "joint"))
    table.refuse("t_s", ~np.isfinite(t_s), "a finite number")
    place_m = np.stack(places, axis=1)
    state = np.full(len(joint), TRACKED, dtype=np.int64)
    if table.has("state"):
        state = table.codes("state", _STATE_CODES)
        state[(state == _NONE) & table.empty("state") & ~np.isfinite(place_m).all(axis=1)] = NOT_TRACKED
        table.refuse("state", state == _NONE, "tracked, inferred or not_tracked, or 2, 1 or 0")
    persons, row = table.persons()
    times, frame = np.unique(t_s, return_inverse=True)
    shape, at = (len(times), len(persons), len(JOINTS)), (frame, row, joint)
    flat = np.ravel_multi_index(at, shape) if len(joint) else np.zeros(0, dtype=np.int64)
    again = np.ones(len(flat), dtype=bool)
    again[np.unique(flat, return_index=True)[1]] = False
    table.refuse("joint", again, "each joint once per time and person")
    joints, codes = np.full((*shape, 3), np.nan), np.zeros(shape, dtype=np.int8)
    joints[at], codes[at] = place_m, state
    return RecordedJoints(times, joints, codes, persons)


class _Table:
    """A file's columns, each read as what it should hold or refused by its first wrong row.

    Args:
        path: of the file.

    Raises:
        RecordError: it cannot be read as a table, or lacks a column.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        try:
            self._columns = _parquet(path) if path.suffix.lower() == ".parquet" else _text(path)
        except FileNotFoundError:
            raise RecordError(f"{path} does not exist") from None
        except UnicodeDecodeError:
            raise RecordError(f"{path} cannot be read as a table: its text is not UTF-8") from None
        except (OSError, ValueError, csv.Error, pa.ArrowException) as error:
            raise RecordError(f"{path} cannot be read as a table: {str(error).splitlines()[0]}") from None
        missing = [name for name in COLUMNS if name not in self._columns]
        if missing:
            has = ", ".join(list(self._columns)[:12]) or "nothing"
            raise RecordError(f"{path}: no column {', '.join(missing)}; {_WANTED}; it has {has}")

    def has(self, name: str) -> bool:
        """Whether there is such a column."""
        return name in self._columns

    def empty(self, name: str) -> BoolArray:
        """(N,) which cells hold nothing."""
        return np.asarray(pc.is_null(self._columns[name]).to_numpy(zero_copy_only=False))

    def numbers(self, name: str) -> Array:
        """(N,) a column as numbers, NaN where it is empty."""
        column = self._columns[name]
        try:
            return np.asarray(pc.cast(column, pa.float64()).to_numpy(zero_copy_only=False), dtype=np.float64)
        except pa.ArrowException:
            self.refuse(name, np.array([not _is_number(value) for value in column.to_pylist()]), "a number")
            raise

    def codes(self, name: str, codes: Mapping[str, int]) -> IntArray:
        """(N,) a column's words by their codes, `_NONE` for others."""
        words, place = self._words(name)
        known = [codes.get(word.lower().translate({32: None, 45: None, 95: None}), _NONE) for word in words]
        return np.array([*known, _NONE], dtype=np.int64)[place]

    def persons(self) -> tuple[NDArray[np.generic], IntArray]:
        """(P,) names, as whole numbers if all are, and (N,) whose row each is."""
        words, place = self._words("person")
        wrong = np.array([_is_number(word) and not _is_whole(word) for word in words] + [True])
        self.refuse("person", wrong[place], "a whole number or a name")
        if all(map(_is_whole, words)):
            persons, row = np.unique(np.array([int(word) for word in words], dtype=np.int64), return_inverse=True)
            return persons, row[place]
        names = sorted(set(words), key=natural_order)
        return np.array(names), np.array([names.index(word) for word in words], dtype=np.int64)[place]

    def _words(self, name: str) -> tuple[list[str], IntArray]:
        """The different words of a column, and (N,) which of them each row has; -1 for an empty one."""
        column = self._columns[name]
        if pa.types.is_floating(column.type) and pc.all(pc.equal(column, pc.floor(column))).as_py():
            column = column.cast(pa.int64())
        coded = column.cast(pa.string()).dictionary_encode()
        return coded.dictionary.to_pylist(), np.asarray(coded.indices.fill_null(-1).to_numpy(), dtype=np.int64)

    def refuse(self, name: str, wrong: BoolArray, wanted: str) -> None:
        """Name the first wrong row; a header is line 1.

        Raises:
            RecordError: there is one.
        """
        rows = np.flatnonzero(wrong)
        if len(rows):
            value = self._columns[name][int(rows[0])].as_py()
            told = "nothing" if value is None else repr(value)
            raise RecordError(f"{self._path}, line {rows[0] + 2}, {name}: {told}, wanted {wanted}")


def _parquet(path: Path) -> dict[str, Any]:
    """Columns by name, with their own types."""
    stored = pq.read_table(path)
    columns = {}
    for name in stored.column_names:
        column = stored[name].combine_chunks()
        column = column.dictionary_decode() if pa.types.is_dictionary(column.type) else column
        is_text = pa.types.is_string(column.type) or pa.types.is_large_string(column.type)
        columns[name.strip().lower()] = _cells(column.cast(pa.string())) if is_text else column
    return columns


def _text(path: Path) -> dict[str, Any]:
    """Columns by name, as words; decimal commas become points."""
    with path.open(newline="", encoding="utf-8-sig") as file:
        first = file.readline()
        between = separator(first)
        raw = next(csv.reader([first], delimiter=between), [])
    names = {name.strip().lower(): name for name in raw}
    wanted = [names[name] for name in (*COLUMNS, "state") if name in names]
    if any(name not in names for name in COLUMNS):
        return dict.fromkeys(names)
    stored = pyarrow.csv.read_csv(
        path,
        parse_options=pyarrow.csv.ParseOptions(delimiter=between),
        convert_options=pyarrow.csv.ConvertOptions(
            column_types=dict.fromkeys(wanted, pa.string()), include_columns=wanted
        ),
    )
    columns = {name.strip().lower(): _cells(stored[name].combine_chunks()) for name in wanted}
    if between != ",":
        for name in set(columns) - {"person", "joint", "state"}:
            columns[name] = pc.replace_substring(columns[name], ",", ".")
    return columns


def _cells(column: Any) -> Any:
    """A column's words without the blanks around them; null where they say that there is nothing."""
    plain = pc.utf8_trim_whitespace(column)
    return pc.if_else(pc.is_in(pc.utf8_lower(plain), value_set=_EMPTY), pa.scalar(None, pa.string()), plain)


def _is_number(value: object) -> bool:
    try:
        float(str(value))
    except ValueError:
        return value is None
    return True


def _is_whole(word: str) -> bool:
    return word.removeprefix("-").isdecimal()
