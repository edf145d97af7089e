"""``python -m sjasim.detect``: the detectors on recorded joints, such as a laboratory's own."""

from __future__ import annotations

import csv
import json
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

import tyro

from . import cli
from .config import DetectorConfig
from .recorded import detect_events

ABOUT = "Starts, stops and claps in recorded joints (CSV or Parquet); a table of events as CSV."


@dataclass(frozen=True)
class Options:
    """Events of recorded joints.

    Attributes:
        joints: CSV or Parquet file with the columns t_s, person, joint, x_m, y_m, z_m in the Kinect's camera space,
            and perhaps state.
        detectors: thresholds.
        json: print JSON instead of CSV.
    """

    joints: Annotated[Path, tyro.conf.Positional]
    detectors: DetectorConfig = field(default_factory=DetectorConfig)
    json: bool = False


def command(arguments: Sequence[str]) -> None:
    """Read, detect, print."""
    options = cli.parse(Options, arguments, None, "python -m sjasim.detect", ABOUT)
    from .record.joint_table import read_joints

    read = read_joints(options.joints)
    found = detect_events(read.t_s, read.joints_m, read.state, read.persons, options.detectors)
    if not found:
        sys.stderr.write(f"no events in {len(read.t_s)} frames of {len(read.persons)} persons\n")
    if options.json:
        rows = [one._asdict() | {"kind": one.kind.value} for one in found]
        sys.stdout.write(json.dumps({"schema": 1, "events": rows}, indent=1) + "\n")
        return
    writer = csv.writer(sys.stdout, lineterminator="\n")
    writer.writerow(("t_s", "person", "kind", "early", "t_onset_s"))
    writer.writerows((one.t_s, one.person, one.kind.value, one.early, one.t_onset_s) for one in found)


if __name__ == "__main__":
    sys.exit(cli.main(command))
