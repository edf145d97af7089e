"""Reads recorded joints from a CSV or Parquet table of any laboratory: one row per frame, person and joint.

The reader accepts columns in any order; commas, semicolons or tabs as separators; decimal commas if the separator is
not a comma; and joints by the Kinect's names or numbers, in upper or lower case.
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
"""Columns that a table must have; ``state`` is optional."""

_MISSING_WORDS = pa.array(["", "-", "na", "n/a", "#n/a", "nan", "-nan", "nan(ind)", "-nan(ind)", "null", "none"])
"""Cells that count as empty, in lower case."""

_JOINT_CODES = {name.lower(): index for name, index in JOINT_INDEX.items()} | {str(k): k for k in range(len(JOINTS))}
"""Joint's name or number -> its index."""

_STATE_CODES = {"tracked": TRACKED, "inferred": INFERRED, "nottracked": NOT_TRACKED,
                "2": TRACKED, "1": INFERRED, "0": NOT_TRACKED}  # fmt: skip
"""Tracking state's name, without separators, or number -> its code."""

_EXPECTED = f"expected {', '.join(COLUMNS)} and optionally state, in a row for each frame, person and joint"

_UNKNOWN = -1
"""Code of an empty cell and of a word that is not in a table of codes."""

_SPACE_HYPHEN_UNDERSCORE = {32: None, 45: None, 95: None}
"""Translation table that removes separators within a word: ``not_tracked`` and ``Not Tracked`` are the same."""


def read_joints(path: str | Path) -> RecordedJoints:
    """Read a CSV or Parquet file with the columns `COLUMNS`.

    A coordinate that is empty, ``NaN`` or ``NA`` leaves the joint's position unknown. Without a column ``state``, every
    row is tracked.

    Args:
        path: the file.

    Returns:
        T frames of P persons, in order of time; joints without a row are NaN and not tracked.

    Raises:
        RecordError: the file cannot be read, or a row is invalid; the message names its line.
    """
    table = _Table(Path(path))
    joint = table.codes("joint", _JOINT_CODES)
    table.require("joint", joint != _UNKNOWN, "a Kinect joint's name or number, such as SpineBase or 0")
    t_s = table.numbers("t_s")
    table.require("t_s", np.isfinite(t_s), "a finite number")
    position_m = np.stack([table.numbers(name) for name in ("x_m", "y_m", "z_m")], axis=1)
    state = _states(table, position_m)

    persons, person = table.persons()
    times, frame = np.unique(t_s, return_inverse=True)
    shape = (len(times), len(persons), len(JOINTS))
    cell = (frame, person, joint)

    # Rows whose cell has occurred before; np.unique gives the first row of each cell.
    flat = np.ravel_multi_index(cell, shape) if len(joint) else np.zeros(0, dtype=np.int64)
    repeated = np.ones(len(flat), dtype=bool)
    repeated[np.unique(flat, return_index=True)[1]] = False
    table.require("joint", ~repeated, "each joint once per time and person")

    joints = np.full((*shape, 3), np.nan)
    codes = np.zeros(shape, dtype=np.int8)
    joints[cell] = position_m
    codes[cell] = state
    return RecordedJoints(times, joints, codes, persons)


def _states(table: _Table, position_m: Array) -> IntArray:
    """(N,) tracking state of each row.

    An empty state is allowed where the position is unknown too: the joint is then not tracked.
    """
    if not table.has("state"):
        return np.full(len(position_m), TRACKED, dtype=np.int64)

    state = table.codes("state", _STATE_CODES)
    state[(state == _UNKNOWN) & table.empty("state") & ~np.isfinite(position_m).all(axis=1)] = NOT_TRACKED
    table.require("state", state != _UNKNOWN, "tracked, inferred or not_tracked, or 2, 1 or 0")
    return state


class _Table:
    """Columns of a file; methods convert them and name the first invalid row.

    Args:
        path: the file.

    Raises:
        RecordError: the file cannot be read as a table, or lacks a column.
    """

    def __init__(self, path: Path) -> None:
        self._path = path

        try:
            self._columns = _parquet_columns(path) if path.suffix.lower() == ".parquet" else _csv_columns(path)
        except FileNotFoundError:
            raise RecordError(f"{path} does not exist") from None
        except UnicodeDecodeError:
            raise RecordError(f"{path} cannot be read as a table: its text is not UTF-8") from None
        except (OSError, ValueError, csv.Error, pa.ArrowException) as error:
            raise RecordError(f"{path} cannot be read as a table: {str(error).splitlines()[0]}") from None

        missing = [name for name in COLUMNS if name not in self._columns]
        if missing:
            has = ", ".join(list(self._columns)[:12]) or "nothing"
            raise RecordError(f"{path}: no column {', '.join(missing)}; {_EXPECTED}; it has {has}")

    def has(self, name: str) -> bool:
        """Whether the file has a column."""
        return name in self._columns

    def empty(self, name: str) -> BoolArray:
        """(N,) whether each cell of a column is empty."""
        return np.asarray(pc.is_null(self._columns[name]).to_numpy(zero_copy_only=False))

    def numbers(self, name: str) -> Array:
        """(N,) a column as numbers, NaN where a cell is empty."""
        column = self._columns[name]

        try:
            return np.asarray(pc.cast(column, pa.float64()).to_numpy(zero_copy_only=False), dtype=np.float64)
        except pa.ArrowException:
            # Arrow's message does not name the row.
            self.require(name, np.array([_is_number(value) for value in column.to_pylist()]), "a number")
            raise

    def codes(self, name: str, codes: Mapping[str, int]) -> IntArray:
        """(N,) codes of a column's words, `_UNKNOWN` for empty cells and words without a code."""
        words, index = self._words(name)
        by_word = [codes.get(word.lower().translate(_SPACE_HYPHEN_UNDERSCORE), _UNKNOWN) for word in words]
        # Index -1, of an empty cell, picks the code that is appended last.
        return np.array([*by_word, _UNKNOWN], dtype=np.int64)[index]

    def persons(self) -> tuple[NDArray[np.generic], IntArray]:
        """(P,) persons, as integers if every name is one, and (N,) index of the person of each row."""
        words, index = self._words("person")
        valid = np.array([not _is_number(word) or _is_integer(word) for word in words] + [False])
        self.require("person", valid[index], "a whole number or a name")

        if all(map(_is_integer, words)):
            persons, order = np.unique(np.array([int(word) for word in words], dtype=np.int64), return_inverse=True)
            return persons, order[index]

        names = sorted(set(words), key=natural_order)
        return np.array(names), np.array([names.index(word) for word in words], dtype=np.int64)[index]

    def require(self, name: str, valid: BoolArray, expected: str) -> None:
        """Check that every row of a column is valid.

        Args:
            name: the column.
            valid: (N,) whether each row is valid.
            expected: ends the message.

        Raises:
            RecordError: a row is not; the message names the first one, where a header is line 1.
        """
        rows = np.flatnonzero(~valid)
        if len(rows):
            value = self._columns[name][int(rows[0])].as_py()
            found = "nothing" if value is None else repr(value)
            raise RecordError(f"{self._path}, line {rows[0] + 2}, {name}: {found}, expected {expected}")

    def _words(self, name: str) -> tuple[list[str], IntArray]:
        """The different words of a column, and (N,) index of the word of each row, -1 for an empty cell."""
        column = self._columns[name]
        # Parquet files of pandas store integers with gaps as floats: 1.0 means person 1.
        if pa.types.is_floating(column.type) and pc.all(pc.equal(column, pc.floor(column))).as_py():
            column = column.cast(pa.int64())

        encoded = column.cast(pa.string()).dictionary_encode()
        indices = np.asarray(encoded.indices.fill_null(-1).to_numpy(), dtype=np.int64)
        return encoded.dictionary.to_pylist(), indices


def _parquet_columns(path: Path) -> dict[str, Any]:
    """Columns of a Parquet file by name in lower case, with their own types."""
    stored = pq.read_table(path)
    columns = {}

    for name in stored.column_names:
        column = stored[name].combine_chunks()
        if pa.types.is_dictionary(column.type):
            column = column.dictionary_decode()
        is_text = pa.types.is_string(column.type) or pa.types.is_large_string(column.type)
        columns[name.strip().lower()] = _clean(column.cast(pa.string())) if is_text else column

    return columns


def _csv_columns(path: Path) -> dict[str, Any]:
    """Columns of a CSV file by name in lower case, as text with decimal points.

    If a required column is missing, the columns are None: their names serve for the error message.
    """
    with path.open(newline="", encoding="utf-8-sig") as file:
        header = file.readline()
        delimiter = separator(header)
        header_names = next(csv.reader([header], delimiter=delimiter), [])

    original_names = {name.strip().lower(): name for name in header_names}
    if any(name not in original_names for name in COLUMNS):
        return dict.fromkeys(original_names)

    used = [original_names[name] for name in (*COLUMNS, "state") if name in original_names]
    stored = pyarrow.csv.read_csv(
        path,
        parse_options=pyarrow.csv.ParseOptions(delimiter=delimiter),
        convert_options=pyarrow.csv.ConvertOptions(column_types=dict.fromkeys(used, pa.string()), include_columns=used),
    )
    columns = {name.strip().lower(): _clean(stored[name].combine_chunks()) for name in used}

    if delimiter != ",":
        for name in set(columns) - {"person", "joint", "state"}:
            columns[name] = pc.replace_substring(columns[name], ",", ".")
    return columns


def _clean(column: Any) -> Any:
    """A text column without surrounding blanks; null where a cell counts as empty."""
    plain = pc.utf8_trim_whitespace(column)
    return pc.if_else(pc.is_in(pc.utf8_lower(plain), value_set=_MISSING_WORDS), pa.scalar(None, pa.string()), plain)


def _is_number(value: object) -> bool:
    """Whether a cell is empty or reads as a number."""
    try:
        float(str(value))
    except ValueError:
        return value is None
    return True


def _is_integer(word: str) -> bool:
    """Whether a word is a whole number, possibly negative."""
    return word.removeprefix("-").isdecimal()
