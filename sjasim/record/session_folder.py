"""A session's folder: written beside its target and renamed when whole, read back as the same log."""

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
"""Versions of session.json that can be read. In version 1 the configuration has the former names of its fields."""

COST = ("sim_s", "cpu_s", "wall_s")
"""What session.json keeps of a log's cost."""


def write(
    log: SessionLog,
    folder: str | Path,
    summary: Mapping[str, object],
    recording: bool = True,
    *,
    report: DelayReport | None = None,
    overwrite: bool = False,
) -> Path:
    """Write a session's folder; it appears whole or not at all.

    Args:
        log: the session.
        folder: where to; see `whole.check_target`.
        summary: what session.json holds: the measures, the configuration, the cost.
        recording: whether session.rrd is written too.
        report: what the recording shows beside the log.
        overwrite: whether an earlier session may be replaced.

    Returns:
        the folder's full path.

    Raises:
        RecordError: the folder cannot be written.
    """
    target = check_target(folder, overwrite)
    with atomic_folder(target, overwrite) as draft:
        _write_all(log, draft, summary)
        if recording:
            from .rerun.recording import save

            save(log, draft / "session.rrd", report)
    return target


def read(folder: str | Path) -> SessionLog:
    """Read a session's folder back; the same log, but for the recorded joints, which are None.

    Raises:
        RecordError: the folder is not a session's, or not whole.
    """
    place = Path(folder)
    summary = read_summary(place)
    rows = {table: read_rows(place / f"{table}.parquet", table) for table in ROW_TYPES}
    columns = {table: read_columns(place / f"{table}.parquet", table) for table in COLUMN_TABLES}
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
        cost={name: summary[name] for name in COST if name in summary},
    )


def read_summary(folder: str | Path) -> dict[str, Any]:
    """A folder's session.json, with the present names of the configuration's fields.

    Raises:
        RecordError: it is missing, damaged or of another version.
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
    return summary


def _write_all(log: SessionLog, draft: Path, summary: Mapping[str, object]) -> None:
    name = session_name(log)
    rows = {table: getattr(log, table) for table in ROW_TYPES}
    rows["device_events"] = [event for event, _ in log.device_events]
    extra: dict[str, dict[str, list[object]]] = {
        "events": {"session": [name] * len(log.events)},
        "robot_events": {"session": [name] * len(log.robot_events)},
        "device_events": {"t_sent_s": [t_sent_s for _, t_sent_s in log.device_events]},
    }
    for table, values in rows.items():
        write_rows(draft / f"{table}.parquet", table, values, extra.get(table, {}))
    for table in COLUMN_TABLES:
        write_columns(draft / f"{table}.parquet", getattr(log, table))
    text = json.dumps(summary, indent=1, allow_nan=False)
    (draft / "session.json").write_text(text + "\n", encoding="utf-8")


def session_name(log: SessionLog) -> str:
    """What the event tables call the session: its method and seed."""
    return f"{log.config.get('method', 'unknown')}-{log.config.get('seed', 0)}"
