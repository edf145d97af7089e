"""``python -m sjasim.detect``: the detectors on recorded joints, such as a laboratory's own."""

from __future__ import annotations

import bisect
import csv
import json
import sys
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any

import tyro

from .commands.options import counted, main, parse
from .config import DetectorConfig
from .core.errors import ConfigError
from .sensors.recordings.detect import Detected, events_of, recording
from .sensors.recordings.interpolation import BRIDGE_S, SMOOTH_S, preprocess
from .sensors.recordings.validation import quality_warnings

ABOUT = (
    "Starts, stops and claps in recorded joints (CSV or Parquet), as an event table (CSV) that sjasim.calibrate takes: "
    "session, iteration, agent, kind, t_s (when the event was detected), early, t_onset_s (when it is estimated to "
    "have begun; empty for early events). What keeps events from being found is said on stderr."
)
COLUMNS = ("session", "iteration", "agent", "kind", "t_s", "early", "t_onset_s")
DECIMALS = 6


@dataclass(frozen=True)
class Options:
    """Events of recorded joints.

    Attributes:
        joints: CSV or Parquet file with the columns t_s, person, joint, x_m, y_m, z_m in the Kinect's camera space,
            and perhaps state.
        session: what to call the session in the event table; by default the file's name.
        iteration_starts_s: times at which iterations 0, 1, ... start; events before the first are left out. By default
            all is iteration 0.
        bridge_s: gaps of a joint no longer than this are bridged; 0 bridges none.
        smooth_s: width over which trunks are smoothed; 0 smooths nothing.
        detectors: thresholds.
        json: print JSON instead of CSV.
    """

    joints: Annotated[Path, tyro.conf.Positional]
    session: str | None = None
    iteration_starts_s: tuple[float, ...] = ()
    bridge_s: float = BRIDGE_S
    smooth_s: float = SMOOTH_S
    detectors: DetectorConfig = field(default_factory=DetectorConfig)
    json: bool = False

    def __post_init__(self) -> None:
        if not all(before < after for before, after in pairwise(self.iteration_starts_s)):
            raise ConfigError("iteration_starts_s", self.iteration_starts_s, "times that rise")
        if self.session is not None and not self.session.strip():
            raise ConfigError("session", self.session, "a name")


def command(arguments: Sequence[str]) -> None:
    """Read, mend, detect, print."""
    options = parse(Options, arguments, None, "python -m sjasim.detect", ABOUT)
    from .record.joint_table import read_joints

    joints = preprocess(recording(*read_joints(options.joints)), options.bridge_s, options.smooth_s)
    found = events_of(joints, options.detectors)
    rows = _rows(found, options)
    _tell(quality_warnings(joints))
    if not found:
        frames, persons = counted(len(joints.t_s), "frame"), counted(len(joints.persons), "person")
        _tell([f"no events in {frames} of {persons}"])
    if len(rows) < len(found):
        _tell([f"left out: {counted(len(found) - len(rows), 'event')} before the first iteration starts"])
    if options.json:
        sys.stdout.write(json.dumps({"schema": 1, "events": rows}, indent=1) + "\n")
        return
    writer = csv.DictWriter(sys.stdout, COLUMNS, lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)


def _rows(found: Iterable[Detected], options: Options) -> list[dict[str, Any]]:
    """The event table, without what came before the first iteration."""
    starts_s = options.iteration_starts_s or (float("-inf"),)
    session = options.session or options.joints.stem
    rows = []
    for one in found:
        iteration = bisect.bisect_right(starts_s, one.t_s) - 1
        onset_s = None if one.t_onset_s is None else round(one.t_onset_s, DECIMALS)
        values = session, iteration, one.person, one.kind.value, round(one.t_s, DECIMALS), one.early, onset_s
        rows += [dict(zip(COLUMNS, values, strict=True))] if iteration >= 0 else []
    return rows


def _tell(lines: Iterable[str]) -> None:
    sys.stderr.writelines(f"{line}\n" for line in lines)


if __name__ == "__main__":
    sys.exit(main(command))
