"""A session log's parts as Parquet tables and back: one row per value, one column per field.

Columns are named by the fields, but for the two event tables, which carry the columns of the common event table
(``session, iteration, agent, kind, t_s``, ``early``, ``source``).
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
"""Table -> the value that one row holds."""

COLUMN_TABLES: Mapping[str, tuple[str, ...]] = {
    "truth": (
        "t_s", "dancer", "x_m", "y_m", "z_m", "heading_rad", "hands_m", "tether_x_n", "tether_y_n",
        "tether_torque_nm", "load_n", "weight_n", "spine_seen", "hands_seen", "fallen",
    ),
    "odometry": (
        "t_s", "x_m", "y_m", "heading_rad", "step_m", "yaw_rate_rad_s", "true_x_m", "true_y_m", "true_heading_rad",
    ),
}  # fmt: skip
"""Table that a log holds as columns already -> the columns it has at least, unless it has none at all."""

RENAMED: Mapping[str, Mapping[str, str]] = {"events": {"person": "agent", "sensor": "source"}}
"""Table -> field -> column, where they differ."""

EXTRA: Mapping[str, Mapping[str, pa.DataType]] = {
    "events": {"session": pa.string()},
    "robot_events": {"session": pa.string()},
    "device_events": {"t_sent_s": pa.float64()},
}
"""Table -> columns beside the value's fields."""

PLAIN = {int: pa.int64(), float: pa.float64(), bool: pa.bool_(), str: pa.string()}


def write_rows(path: Path, table: str, rows: Sequence[object], extra: Mapping[str, Iterable[object]]) -> None:
    """Write values of one kind.

    Args:
        path: the file.
        table: one of `ROW_TYPES`; it fixes the columns, so that an empty table has them too.
        rows: the values.
        extra: the columns named in `EXTRA` for this table.
    """
    columns: dict[str, list[Any]] = {name: list(values) for name, values in extra.items()}
    for field in dataclasses.fields(ROW_TYPES[table]):
        name = RENAMED.get(table, {}).get(field.name, field.name)
        columns[name] = [getattr(row, field.name) for row in rows]
    pq.write_table(pa.table(columns, schema=_schema(table)), path)


def write_columns(path: Path, columns: Mapping[str, NDArray[np.generic]]) -> None:
    """Write columns of equal length as they are."""
    pq.write_table(pa.table({name: pa.array(values) for name, values in columns.items()}), path)


def read_columns(path: Path, table: str) -> dict[str, NDArray[Any]]:
    """Read a table as read-only columns.

    Raises:
        RecordError: the file is missing or damaged, or lacks a column that this table has.
    """
    stored = _table(path)
    if stored.column_names:
        _require(path, table, stored, COLUMN_TABLES[table])
    columns = {name: column.to_numpy() for name, column in zip(stored.column_names, stored.columns, strict=True)}
    for column in columns.values():
        column.flags.writeable = False
    return columns


def read_rows(path: Path, table: str) -> tuple[list[Any], dict[str, list[Any]]]:
    """Read values of one kind, and the columns named in `EXTRA` for this table.

    Raises:
        RecordError: the file is missing or damaged, lacks a column, or holds a value that is not allowed.
    """
    stored = _table(path)
    _require(path, table, stored, _schema(table).names)
    extra = {name: stored.column(name).to_pylist() for name in EXTRA.get(table, {})}
    columns = []
    for name, hint in get_type_hints(ROW_TYPES[table]).items():
        column = RENAMED.get(table, {}).get(name, name)
        values = stored.column(column).to_pylist()
        columns.append(_enumerated(path, column, hint, values) if _is_enum(hint) else values)
    return [ROW_TYPES[table](*row) for row in zip(*columns, strict=True)], extra


def save_csv(targets: Mapping[Path, Path]) -> None:
    """Write Parquet tables as CSV, all of them or, where one cannot be read, none; folders are made if absent.

    Args:
        targets: each table's Parquet file, and the CSV file to write.

    Raises:
        RecordError: a table cannot be read, or a target cannot be written.
    """
    import pyarrow.csv

    for target, stored in [(target, _table(path)) for path, target in targets.items()]:
        try:
            target.parent.mkdir(parents=True, exist_ok=True)
            pyarrow.csv.write_csv(stored, target)
        except OSError as error:
            raise RecordError(f"{target} cannot be written: {error.strerror or error}") from None


def _enumerated(path: Path, column: str, hint: Any, values: list[Any]) -> list[Any]:
    known = {item.value: item for item in hint}
    for row, value in enumerate(values):
        if value not in known:
            raise RecordError(f"{path}, row {row}, column {column!r}: {value!r} is none of {', '.join(known)}")
    return [known[value] for value in values]


def _is_enum(hint: Any) -> bool:
    return isinstance(hint, type) and issubclass(hint, StrEnum)


def _schema(table: str) -> pa.Schema:
    fields = dict(EXTRA.get(table, {}))
    for name, hint in get_type_hints(ROW_TYPES[table]).items():
        fields[RENAMED.get(table, {}).get(name, name)] = _arrow_type(hint)
    return pa.schema(list(fields.items()))


def _arrow_type(hint: Any) -> pa.DataType:
    if get_origin(hint) in (types.UnionType,):
        hint = next(item for item in get_args(hint) if item is not type(None))
    return pa.string() if _is_enum(hint) else PLAIN[hint]


def _table(path: Path) -> pa.Table:
    try:
        return pq.read_table(path)
    except FileNotFoundError:
        raise RecordError(f"{path} is missing: this is not a whole session's folder") from None
    except (OSError, pa.ArrowException) as error:
        raise RecordError(f"{path} cannot be read: {str(error).splitlines()[0]}") from None


def _require(path: Path, table: str, stored: pa.Table, columns: Iterable[str]) -> None:
    missing = [name for name in columns if name not in stored.column_names]
    if missing:
        raise RecordError(f"{path} is no {table} table: it lacks the column {missing[0]!r}")
