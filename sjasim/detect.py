"""``python -m sjasim.detect``: detects events in recorded joints, such as a laboratory's own."""

from __future__ import annotations

import csv
import json
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

import tyro

from .commands.flags import INLINE, Metavar
from .commands.main import main
from .commands.options import parse
from .sensors.recordings.detect import recording
from .sensors.recordings.event_table import COLUMNS, EventTableConfig, event_table

ABOUT = (
    "Detect starts, stops and claps in recorded joints, and print them as an event table (CSV), which the command "
    "calibrate reads. Columns: session, iteration, agent, kind, t_s (time of detection), early, t_onset_s (estimated "
    "onset; empty for early events). Warnings about the recording are on stderr."
)


@dataclass(frozen=True)
class Options:
    """Options of this command.

    Attributes:
        joints: CSV or Parquet file with the columns t_s, person, joint, x_m, y_m, z_m in the Kinect's camera space, and
            optionally state.
        table: how the event table is made.
        json: print JSON instead of CSV.
    """

    joints: Annotated[tyro.conf.Positional[Path], Metavar("FILE")]
    table: Annotated[EventTableConfig, INLINE] = field(default_factory=EventTableConfig)
    json: bool = False


def command(arguments: Sequence[str], program: str = "python -m sjasim.detect") -> None:
    """Read the joints, detect the events, and print the table."""
    options = parse(Options, arguments, None, program, ABOUT)
    from .record.joint_table import read_joints

    table = event_table(recording(*read_joints(options.joints)), options.table, options.joints.stem)
    sys.stderr.writelines(f"warning: {line}\n" for line in table.warnings)
    if options.json:
        sys.stdout.write(json.dumps({"schema": 1, "events": table.rows}, indent=1) + "\n")
        return
    writer = csv.DictWriter(sys.stdout, COLUMNS, lineterminator="\n")
    writer.writeheader()
    writer.writerows(table.rows)


if __name__ == "__main__":
    sys.exit(main(command))
