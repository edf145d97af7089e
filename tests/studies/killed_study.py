"""Runs a study that is killed at random moments and resumed: ``python killed_study.py FOLDER KILLS SEED``.

Each attempt is a forked process with everything imported, which is killed with SIGKILL after a random time. Prints one
line of JSON: the number of kills, and the chunks that were computed although their part was finished.
"""

from __future__ import annotations

import json
import os
import random
import signal
import sys
import time
from pathlib import Path

from sjasim.studies import study_parts
from sjasim.studies.study_design import StudyDesign, StudyPlan
from sjasim.studies.study_execution import Execution, execute

CHUNK = 2
"""Sessions in a chunk: many parts, so that kills fall between them and into their writing."""


def main(folder: Path, kills: int, seed: int) -> None:
    study_parts.TIMING_CHUNK = CHUNK
    design = StudyDesign(groups=14)
    whole_s = duration_s(folder.with_name("whole"), design)
    rng = random.Random(seed)
    repeated = 0
    done = 0

    while done < kills:
        before = {path.name: path.stat().st_mtime_ns for path in folder.glob("parts/*.part")}
        child = started(folder, design)
        # Short times, so that one study takes many kills; the longest reach the writing of the tables.
        time.sleep(rng.uniform(0.0, 0.35 * whole_s))
        os.kill(child, signal.SIGKILL)
        _, status = os.waitpid(child, 0)
        done += os.WIFSIGNALED(status)

        after = {path.name: path.stat().st_mtime_ns for path in folder.glob("parts/*.part")}
        repeated += sum(name in after and after[name] != time_ns for name, time_ns in before.items())
        if (folder / "study.json").exists() and done < kills:
            # The study was finished before all kills: the next one begins anew, elsewhere.
            folder = folder.with_name(f"{folder.name}_")

    os.waitpid(started(folder, design), 0)
    chunks = -(-len(StudyPlan(design)) // CHUNK)
    print(json.dumps({"kills": done, "repeated": repeated, "chunks": chunks}))


def duration_s(folder: Path, design: StudyDesign) -> float:
    """Run the study once without interruption, and return how long it took [s]."""
    start_s = time.perf_counter()
    os.waitpid(started(folder, design), 0)
    return time.perf_counter() - start_s


def started(folder: Path, design: StudyDesign) -> int:
    """Start the study in a forked process and return its number."""
    child = os.fork()
    if child == 0:
        with open(os.devnull, "w") as nowhere:
            os.dup2(nowhere.fileno(), 2)
        execute(design, Execution(out=folder, jobs=1, resume=True))
        os._exit(0)
    return child


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]))
