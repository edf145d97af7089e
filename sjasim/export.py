"""``python -m sjasim.export``: writes a session's folder as files that other tools open."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from .commands.flags import Metavar
from .commands.main import main
from .commands.options import parse
from .core.errors import RecordError
from .record.atomic_folder import check_file

ABOUT = "Write a recorded session as MCAP (ROS 2 messages, for Foxglove and rosbags) or as CSV tables."


@dataclass(frozen=True)
class Options:
    """Options of this command.

    Attributes:
        folder: the session's folder.
        mcap: file to write ROS 2 messages to: odometry, transforms, speeds, skeletons, events, decisions.
        csv: folder to write every table to as CSV.
        overwrite: replace existing files.
    """

    folder: Annotated[tyro.conf.Positional[Path], Metavar("DIR")]
    mcap: Annotated[Path | None, Metavar("FILE.mcap")] = None
    csv: Annotated[Path | None, Metavar("DIR")] = None
    overwrite: bool = False


def command(arguments: Sequence[str], program: str = "python -m sjasim.export") -> None:
    """Check the targets, read the session, and write what was asked for."""
    options = parse(Options, arguments, None, program, ABOUT)
    if options.mcap is None and options.csv is None:
        raise RecordError("nothing to export: name --mcap FILE, --csv DIR, or both")
    from .record.folder_export import check_csv_folder, save_messages, save_tables
    from .record.session_folder import read_summary

    read_summary(options.folder)  # refuses what is no session's folder
    if options.csv is not None:
        check_csv_folder(options.csv, options.overwrite)
    if options.mcap is not None:
        check_file(options.mcap, options.overwrite)
        sys.stderr.write(f"{save_messages(options.folder, options.mcap)} messages in {options.mcap}\n")
    if options.csv is not None:
        sys.stderr.write(f"{save_tables(options.folder, options.csv)} tables in {options.csv}\n")


if __name__ == "__main__":
    sys.exit(main(command))
