"""Write the statistics that the event-level world draws from, as `sjasim characterise` measured them in physics.

python -m sjasim.characterise --sessions 14 --seed 40000 --out characterised
python scripts/write_timing_statistics.py characterised/characterise.json
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

TARGET = Path(__file__).parents[1] / "sjasim" / "assets" / "timing_statistics.toml"

HEADER = """\
# Delays, misses and false events of detectors and robot, measured in simulated physics.
# Made by:
#   python -m sjasim.characterise --sessions {sessions} --seed {seed} --out characterised
#   python scripts/write_timing_statistics.py characterised/characterise.json
# [SENSING.LAYOUT.regular.KIND]: delay of the logged event behind the dancer's planned one [s].
# [SENSING.LAYOUT.early.KIND]: the same of the early event. [robot.KIND]: delay of the robot's event behind the arrival
# of its command. delay_s has {quantiles} quantiles from the smallest to the largest value; missed is a probability;
# false_per_minute is the rate of events without a cause for each dancer; n is the number of observations.
"""


def tables(content: Mapping[str, Any], path: tuple[str, ...] = ()) -> Iterator[str]:
    """Lines of all tables of statistics, one line for each value."""
    if "delay_s" in content:
        yield ""
        yield f"[{'.'.join(path)}]"
        for name, value in content.items():
            yield f"{name} = {value}"
        return
    for name, value in content.items():
        yield from tables(value, (*path, name))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("report", type=Path, help="characterise.json")
    parser.add_argument("--out", type=Path, default=TARGET, help="file to write")
    arguments = parser.parse_args()

    report = json.loads(arguments.report.read_text(encoding="utf-8"))
    seeds = {session["seed"] for session in report["sessions"]}
    quantiles = len(report["timing"]["robot"]["turn"]["delay_s"])
    header = HEADER.format(sessions=len(seeds), seed=report["seed"], quantiles=quantiles)
    arguments.out.write_text(header + "\n".join(tables(report["timing"])) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
