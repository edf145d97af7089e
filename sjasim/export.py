"""``python -m sjasim.export``: a session's folder as files that other tools open."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import tyro

from .commands.options import main, parse
from .core.errors import RecordError
from .record.atomic_folder import check_file

ABOUT = "A session's folder as MCAP (ROS 2 messages: Foxglove, rosbags) or as CSV tables."


@dataclass(frozen=True)
class Options:
    """Files that other tools open.

    Attributes:
        folder: the session's folder.
        mcap: file for ROS 2 messages: odometry, transforms, speeds, skeletons, events, decisions.
        csv: folder for every table as CSV.
        overwrite: replace what exists.
    """

    folder: tyro.conf.Positional[Path]
    mcap: Path | None = None
    csv: Path | None = None
    overwrite: bool = False


def command(arguments: Sequence[str]) -> None:
    """Check the targets, read the session, write what was asked for."""
    options = parse(Options, arguments, None, "python -m sjasim.export", ABOUT)
    if options.mcap is None and options.csv is None:
        raise RecordError("nothing to export: name --mcap FILE, --csv DIR, or both")
    from .record.parquet import COLUMN_TABLES, ROW_TYPES, save_csv
    from .record.session_folder import read_summary

    read_summary(options.folder)
    tables = [*ROW_TYPES, *COLUMN_TABLES]
    if options.csv is not None:
        if options.csv.exists() and not options.csv.is_dir():
            raise RecordError(f"{options.csv} is a file: name a folder")
        for table in tables if options.csv.exists() else ():
            check_file(options.csv / f"{table}.csv", options.overwrite)
    if options.mcap is not None:
        check_file(options.mcap, options.overwrite)
        from .record.rerun.rrd_reader import read_with_joints
        from .record.ros2.mcap_export import save_mcap

        count = save_mcap(read_with_joints(options.folder), options.mcap)
        sys.stderr.write(f"{count} messages in {options.mcap}\n")
    if options.csv is not None:
        save_csv({options.folder / f"{table}.parquet": options.csv / f"{table}.csv" for table in tables})
        sys.stderr.write(f"{len(tables)} tables in {options.csv}\n")


if __name__ == "__main__":
    sys.exit(main(command))
