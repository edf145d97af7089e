"""Compare the event-level world with simulated physics: one study and some sessions in both.

Three tables are printed: the values of one study in physics beside the 95 % interval of the same values over studies in
fidelity timing; the mean delay of detection by kind of event; and the net latency of SIA. Run, for example:

    python scripts/compare_fidelities.py --studies 200 --sessions 12
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence

import numpy as np

from sjasim.analysis.accuracy.timing_delays import delay_observations
from sjasim.analysis.published_values import PUBLISHED, StudyArrays, study_arrays
from sjasim.commands.tables import print_table
from sjasim.config import SessionConfig
from sjasim.core.session_log import SessionLog
from sjasim.session.session import run_session
from sjasim.studies.paper_reproduction import INTERVAL, study_design
from sjasim.studies.reproduction_options import ReproductionOptions
from sjasim.studies.study_execution import run_study

FIDELITIES = ("physics", "timing")

FIRST_SEED = 90_000
"""Seed of the first session; the statistics were measured with other seeds."""


def value_rows(physics: StudyArrays, timing: StudyArrays) -> tuple[list[tuple[str, ...]], int]:
    """Cells of the table of values, and the number of values inside."""
    rows = []
    count = 0
    for value in PUBLISHED:
        found = float(value.compute(physics)[0])
        low, high = np.nanpercentile(value.compute(timing), INTERVAL)
        inside = bool(low <= found <= high)
        count += inside
        rows.append((value.name, value.method, f"{found:.3f}", f"{low:.3f}", f"{high:.3f}", "yes" if inside else "no"))
    return rows, count


def mean_delays(logs: Sequence[SessionLog]) -> dict[tuple[str, str], float]:
    """(table, kind) -> mean delay of the logged events behind the plan, or of the robot's behind the command [s]."""
    found: dict[tuple[str, str], list[float]] = {}
    for log in logs:
        for item in delay_observations(log):
            if np.isfinite(item.delay_s):
                found.setdefault((item.table, item.kind.value), []).append(item.delay_s)
    return {key: float(np.mean(values)) for key, values in sorted(found.items())}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--humans", default="paper-entrainment")
    parser.add_argument("--studies", type=int, default=200, help="studies in fidelity timing")
    parser.add_argument("--sessions", type=int, default=12, help="sessions for the delays, in each fidelity")
    arguments = parser.parse_args()

    tables = {}
    for fidelity, studies in (("physics", 1), ("timing", arguments.studies)):
        options = ReproductionOptions(humans=arguments.humans, studies=studies, fidelity=fidelity)
        tables[fidelity] = run_study(study_design(options))
    rows, count = value_rows(study_arrays(tables["physics"]), study_arrays(tables["timing"]))
    print_table(("value", "method", "physics", "low", "high", "inside"), rows, left=(0, 1))
    print(f"{count} of {len(rows)} values of the study in physics lie inside the interval of fidelity timing")

    delays = {}
    for fidelity in FIDELITIES:
        configs = (
            SessionConfig(humans=arguments.humans, sensing="joints", fidelity=fidelity, seed=FIRST_SEED + number)
            for number in range(arguments.sessions)
        )
        delays[fidelity] = mean_delays([run_session(config) for config in configs])
    cells = [
        (*key, *(f"{1e3 * delays[fidelity][key]:.0f}" for fidelity in FIDELITIES),
         f"{1e3 * (delays['timing'][key] - delays['physics'][key]):+.0f}")
        for key in delays["physics"]
    ]  # fmt: skip
    print_table(("events", "kind", "physics [ms]", "timing [ms]", "difference [ms]"), cells, left=(0, 1))

    latency = {fidelity: np.nanmean(table.steps["latency_s"]) for fidelity, table in tables.items()}
    difference = 1e3 * (latency["timing"] - latency["physics"])
    print(f"net latency of SIA: {latency['physics']:.3f} s, {latency['timing']:.3f} s, difference {difference:+.0f} ms")


if __name__ == "__main__":
    main()
