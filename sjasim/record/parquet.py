"""Parquet tables of a session's log, and back: one row per value and one column per field.

To log one more column:

- of events, cues, commands, decisions, notices, handovers or followed dancers: add a field to the dataclass that
  `ROW_TYPES` names for the table. The column follows from the field, under the field's name.
- of ``truth`` or ``odometry``: fill the column where the log is made (`simulation.ground_truth_recorder`), and name it
  in `COLUMN_TABLES`.
- that is no field of the value, such as the session's name: name it in `EXTRA_COLUMNS`, and pass its values to
  `write_rows` in `session_folder`.

The two event tables carry the columns of the common event table (``session, iteration, agent, kind, t_s``, ``early``,
``source``), of which `RENAMED_FIELDS` maps those whose field has another name.
"""

from __future__ import annotations

import dataclasses
import types
from collections.abc import Iterable, Mapping, Sequence
from enum import StrEnum
from pathlib import Path
from typing import Any, get_args, get_origin, get_type_hints

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from ..core import Cue, DeviceEvent, Event, MoveCommand
from ..core.errors import RecordError
from ..core.session_log import AgentEvent, Decision, Followed, Handover, Notice

ROW_TYPES: Mapping[str, type] = {
    "cues": Cue,
    "device_events": DeviceEvent,
    "events": Event,
    "commands": MoveCommand,
    "decisions": Decision,
    "robot_events": AgentEvent,
    "notices": Notice,
    "handovers": Handover,
    "followed": Followed,
}
"""Table -> dataclass of which each row holds one value; its fields are the table's columns."""

COLUMN_TABLES: Mapping[str, tuple[str, ...]] = {
    "truth": (
        "t_s", "dancer", "x_m", "y_m", "z_m", "heading_rad", "hands_m", "tether_x_n", "tether_y_n",
        "tether_torque_nm", "load_n", "weight_n", "spine_seen", "hands_seen", "fallen",
    ),
    "odometry": (
        "t_s", "x_m", "y_m", "heading_rad", "step_m", "yaw_rate_rad_s", "true_x_m", "true_y_m", "true_heading_rad",
    ),
}  # fmt: skip
"""Table that the log holds as arrays -> columns that a file must have, unless the table has no columns at all."""

RENAMED_FIELDS: Mapping[str, Mapping[str, str]] = {"events": {"person": "agent", "sensor": "source"}}
"""Table -> field -> name of its column, where the two differ."""

EXTRA_COLUMNS: Mapping[str, Mapping[str, pa.DataType]] = {
    "events": {"session": pa.string()},
    "robot_events": {"session": pa.string()},
    "device_events": {"t_sent_s": pa.float64()},
}
"""Table -> columns beside the fields, with their types."""

ARROW_TYPES = {int: pa.int64(), float: pa.float64(), bool: pa.bool_(), str: pa.string()}
"""Type of a field -> type of its column; enumerations are stored as their string values."""


def write_rows(path: Path, table: str, rows: Sequence[object], extra: Mapping[str, Iterable[object]]) -> None:
    """Write values of one dataclass as a Parquet file.

    Args:
        path: the file to write.
        table: key of `ROW_TYPES`. It fixes the columns, so that a table without rows has them too.
        rows: values of that dataclass.
        extra: values of the columns that `EXTRA_COLUMNS` names for this table.
    """
    columns: dict[str, list[Any]] = {name: list(values) for name, values in extra.items()}
    for field in dataclasses.fields(ROW_TYPES[table]):
        columns[_column_name(table, field.name)] = [getattr(row, field.name) for row in rows]

    pq.write_table(pa.table(columns, schema=_schema(table)), path)


def write_columns(path: Path, columns: Mapping[str, NDArray[np.generic]]) -> None:
    """Write arrays of equal length as the columns of a Parquet file."""
    pq.write_table(pa.table({name: pa.array(values) for name, values in columns.items()}), path)


def read_rows(path: Path, table: str) -> tuple[list[Any], dict[str, list[Any]]]:
    """Read a file from `write_rows`.

    Args:
        path: the file.
        table: key of `ROW_TYPES`.

    Returns:
        The values, and the columns that `EXTRA_COLUMNS` names for this table.

    Raises:
        RecordError: the file is missing or damaged, lacks a column, or holds a value that is not allowed.
    """
    stored = _read(path)
    _require_columns(path, table, stored, _schema(table).names)

    extra = {name: stored.column(name).to_pylist() for name in EXTRA_COLUMNS.get(table, {})}

    # Columns are gathered in the order of the fields, so that a row can be passed to the dataclass by position.
    columns = []
    for field, hint in get_type_hints(ROW_TYPES[table]).items():
        column = _column_name(table, field)
        values = stored.column(column).to_pylist()
        columns.append(_to_enum(path, column, hint, values) if _is_enum(hint) else values)

    return [ROW_TYPES[table](*row) for row in zip(*columns, strict=True)], extra


def read_columns(path: Path, table: str) -> dict[str, NDArray[Any]]:
    """Read a file from `write_columns` as read-only arrays.

    Args:
        path: the file.
        table: key of `COLUMN_TABLES`.

    Raises:
        RecordError: the file is missing or damaged, or lacks a column of `COLUMN_TABLES`.
    """
    stored = _read(path)
    if stored.column_names:
        _require_columns(path, table, stored, COLUMN_TABLES[table])

    columns = {name: column.to_numpy() for name, column in zip(stored.column_names, stored.columns, strict=True)}
    # A log is immutable, and so are its arrays.
    for column in columns.values():
        column.flags.writeable = False
    return columns


def save_csv(targets: Mapping[Path, Path]) -> None:
    """Convert Parquet tables to CSV files; if one table cannot be read, no file is written.

    Args:
        targets: Parquet file -> CSV file to write. Missing folders are created.

    Raises:
        RecordError: a table cannot be read, or a CSV file cannot be written.
    """
    import pyarrow.csv

    # All tables are read before the first file is written.
    tables = [(target, _read(path)) for path, target in targets.items()]

    for target, table in tables:
        try:
            target.parent.mkdir(parents=True, exist_ok=True)
            pyarrow.csv.write_csv(table, target)
        except OSError as error:
            raise RecordError(f"{target} cannot be written: {error.strerror or error}") from None


def _read(path: Path) -> pa.Table:
    """The Parquet file of a session's folder; errors are named as `RecordError`."""
    try:
        return pq.read_table(path)
    except FileNotFoundError:
        raise RecordError(f"{path} is missing: this is not a complete session's folder") from None
    except (OSError, pa.ArrowException) as error:
        raise RecordError(f"{path} cannot be read: {str(error).splitlines()[0]}") from None


def _require_columns(path: Path, table: str, stored: pa.Table, columns: Iterable[str]) -> None:
    """Raise `RecordError` that names the first column which the file lacks."""
    missing = [name for name in columns if name not in stored.column_names]
    if missing:
        raise RecordError(f"{path} is no {table} table: it lacks the column {missing[0]!r}")


def _column_name(table: str, field: str) -> str:
    """Name of the column that holds a field."""
    return RENAMED_FIELDS.get(table, {}).get(field, field)


def _schema(table: str) -> pa.Schema:
    """Arrow schema of a table of rows: its extra columns, then its fields."""
    columns = dict(EXTRA_COLUMNS.get(table, {}))
    for field, hint in get_type_hints(ROW_TYPES[table]).items():
        columns[_column_name(table, field)] = _arrow_type(hint)
    return pa.schema(list(columns.items()))


def _arrow_type(hint: Any) -> pa.DataType:
    """Type of the column for a field with this type hint; ``X | None`` gives a column of X with nulls."""
    if get_origin(hint) is types.UnionType:
        hint = next(item for item in get_args(hint) if item is not type(None))
    return pa.string() if _is_enum(hint) else ARROW_TYPES[hint]


def _is_enum(hint: Any) -> bool:
    """Whether a type hint is one of the string enumerations."""
    return isinstance(hint, type) and issubclass(hint, StrEnum)


def _to_enum(path: Path, column: str, hint: Any, values: list[Any]) -> list[Any]:
    """Members of an enumeration by their values.

    Raises:
        RecordError: a value is none of them; the message names the row and the allowed values.
    """
    members = {member.value: member for member in hint}
    for row, value in enumerate(values):
        if value not in members:
            raise RecordError(f"{path}, row {row}, column {column!r}: {value!r} is none of {', '.join(members)}")
    return [members[value] for value in values]
