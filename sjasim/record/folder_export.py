"""Writes a session's folder as files that other tools open: CSV tables, ROS 2 messages."""

from __future__ import annotations

from pathlib import Path

from ..core.errors import RecordError
from .atomic_folder import check_file
from .parquet import COLUMN_TABLES, ROW_TYPES, save_csv

TABLES = (*ROW_TYPES, *COLUMN_TABLES)
"""Names of all tables of a session."""


def check_csv_folder(folder: Path, overwrite: bool) -> None:
    """Refuse a folder to which the tables cannot be written.

    Raises:
        RecordError: it is a file, or it holds one of the tables and ``overwrite`` is False.
    """
    if not folder.exists():
        return
    if not folder.is_dir():
        raise RecordError(f"{folder} is a file: name a folder")
    for table in TABLES:
        check_file(folder / f"{table}.csv", overwrite)


def save_tables(session: Path, folder: Path) -> int:
    """Write all tables of a session's folder to another folder, and return how many.

    Raises:
        RecordError: a table cannot be read, or a file cannot be written.
    """
    save_csv({session / f"{table}.parquet": folder / f"{table}.csv" for table in TABLES})
    return len(TABLES)


def save_messages(session: Path, path: Path) -> int:
    """Write a session's folder as ROS 2 messages to an MCAP file, and return how many.

    Raises:
        RecordError: the folder cannot be read, the file cannot be written, or the package that writes it is missing.
    """
    from .rerun.rrd_reader import read_with_joints
    from .ros2.mcap_export import save_mcap

    return save_mcap(read_with_joints(session), path)
