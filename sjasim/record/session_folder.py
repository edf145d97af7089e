"""Writes a session's folder (session.json, Parquet tables, session.rrd) and reads it back as the same log."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..config.renamed_fields import with_present_names
from ..core.errors import RecordError
from ..core.session_log import SessionLog
from .atomic_folder import atomic_folder, check_target
from .parquet import COLUMN_TABLES, ROW_TYPES, read_columns, read_rows, write_columns, write_rows
from .rerun.explanation import DelayReport

SCHEMAS = (1, 2)
"""Versions of session.json that can be read; `analysis.session_metrics.SCHEMA` is the one that is written.

In version 1, the configuration has the former names of its fields.
"""

COST_KEYS = ("sim_s", "cpu_s", "wall_s")
"""Keys of the cost that earlier session.json files have at their top level."""


def write(
    log: SessionLog,
    folder: str | Path,
    summary: Mapping[str, object],
    recording: bool = True,
    *,
    report: DelayReport | None = None,
    overwrite: bool = False,
) -> Path:
    """Write a session's folder; it appears complete or not at all.

    Args:
        log: the session.
        folder: the folder to write; see `atomic_folder.check_target`.
        summary: content of session.json: measures, configuration, versions, cost.
        recording: whether session.rrd is written too.
        report: delays and graphs that the recording shows beside the log.
        overwrite: whether an earlier session in the folder may be replaced.

    Returns:
        The absolute path of the folder.

    Raises:
        RecordError: the folder cannot be written.
    """
    target = check_target(folder, overwrite)

    with atomic_folder(target, overwrite) as draft:
        _write_tables(log, draft)

        text = json.dumps(summary, indent=1, allow_nan=False)
        (draft / "session.json").write_text(text + "\n", encoding="utf-8")

        if recording:
            # rerun takes long to import, and is not needed for tables.
            from .rerun.recording import save

            save(log, draft / "session.rrd", report)

    return target


def read(folder: str | Path) -> SessionLog:
    """Read a session's log from its folder, without joints, skeletons and depth images, which no table holds.

    `rerun.rrd_reader.read_with_joints` adds the joints and skeletons of the recording.

    Args:
        folder: a folder from `write`.

    Raises:
        RecordError: the folder is not a session's, or a file in it is missing or damaged.
    """
    path = Path(folder)
    summary = read_summary(path)
    rows = {table: read_rows(path / f"{table}.parquet", table) for table in ROW_TYPES}
    columns = {table: read_columns(path / f"{table}.parquet", table) for table in COLUMN_TABLES}

    devices, extra = rows["device_events"]
    return SessionLog(
        config=summary["config"],
        versions=summary["versions"],
        cues=tuple(rows["cues"][0]),
        device_events=tuple(zip(devices, extra["t_sent_s"], strict=True)),
        events=tuple(rows["events"][0]),
        commands=tuple(rows["commands"][0]),
        decisions=tuple(rows["decisions"][0]),
        robot_events=tuple(rows["robot_events"][0]),
        notices=tuple(rows["notices"][0]),
        handovers=tuple(rows["handovers"][0]),
        followed=tuple(rows["followed"][0]),
        odometry=columns["odometry"],
        truth=columns["truth"],
        cost=summary["cost"],
    )


def read_summary(folder: str | Path) -> dict[str, Any]:
    """Read the session.json of a folder, with the present names of its keys and of the configuration's fields.

    Args:
        folder: a session's folder.

    Raises:
        RecordError: the file is missing, damaged or of another version.
    """
    path = Path(folder) / "session.json"

    try:
        summary = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise RecordError(f"{folder} is not a session's folder: {path.name}: {error.strerror or error}") from None
    except ValueError as error:
        raise RecordError(f"{path} is damaged: {error}") from None

    if not isinstance(summary, dict) or summary.get("schema") not in SCHEMAS:
        raise RecordError(f"{path} is not a session.json of version {' or '.join(map(str, SCHEMAS))}")
    if not all(isinstance(summary.get(key), dict) for key in ("config", "versions")):
        raise RecordError(f"{path} lacks config or versions")

    summary["config"], _ = with_present_names(summary["config"])
    former_cost = {name: summary.pop(name) for name in COST_KEYS if name in summary}
    summary.setdefault("cost", former_cost)
    return summary


def session_name(log: SessionLog) -> str:
    """Name of a session in the event tables' ``session`` column: its method and seed."""
    return f"{log.config.get('method', 'unknown')}-{log.config.get('seed', 0)}"


def _write_tables(log: SessionLog, draft: Path) -> None:
    """Write every table of `parquet.ROW_TYPES` and `parquet.COLUMN_TABLES`."""
    rows = {table: getattr(log, table) for table in ROW_TYPES}
    # The log pairs each device event with the time at which it was sent; the table has that time as a column.
    rows["device_events"] = [event for event, _ in log.device_events]

    name = session_name(log)
    extra: dict[str, dict[str, list[object]]] = {
        "events": {"session": [name] * len(log.events)},
        "robot_events": {"session": [name] * len(log.robot_events)},
        "device_events": {"t_sent_s": [t_sent_s for _, t_sent_s in log.device_events]},
    }

    for table, values in rows.items():
        write_rows(draft / f"{table}.parquet", table, values, extra.get(table, {}))
    for table in COLUMN_TABLES:
        write_columns(draft / f"{table}.parquet", getattr(log, table))
