"""Benchmark figures: which measurements they consist of, and what the table of them shows."""

import time

import pytest

from sjasim.simulation.profiling import CpuProfiler
from sjasim.studies.benchmark_figures import UNITS, benchmark_figures, table_rows

PROFILE = {
    "sim_s": 100.0,
    "cpu_s": 6.0,
    "raw_cpu_s": 4.0,
    "room_cpu_s": {"planning": 0.2, "logging": 0.3},
    "env_steps": 3000,
    "env_cpu_s": 6.0,
    "env_raw_cpu_s": 4.5,
    "depth_sim_s": 30.0,
    "depth_cpu_s": 15.0,
    "depth_frames": 300,
    "depth_frame_cpu_s": 4.5,
    "async_steps_per_s": [500.0, 900.0],
}


def test_figures_are_ratios_of_what_was_measured():
    figures = benchmark_figures(PROFILE, 0.3)["figures"]
    assert tuple(figures) == tuple(UNITS)
    wanted = {
        "session_cost_ratio_joints": 1.5, "session_sim_s_per_cpu_s_depth": 2.0, "depth_frame_cpu_s": 0.015,
        "env_ratio_to_raw": 0.75, "async2_speedup": 1.8, "logging_share": 0.05, "planning_cpu_s": 0.002,
        "import_s": 0.3,
    }  # fmt: skip
    assert {name: figures[name] for name in wanted} == pytest.approx(wanted)
    assert figures["decision_cpu_s"] is None


def test_what_was_not_measured_is_null():
    figures = benchmark_figures({}, 0.3)["figures"]
    assert {name for name, value in figures.items() if value is not None} == {"import_s"}


def test_the_table_has_units_and_no_empty_figures():
    rows = {name: (value, unit) for name, value, unit in table_rows(benchmark_figures(PROFILE, 0.3))}
    assert rows["depth_frame_cpu_s"] == ("0.015", "s")
    assert rows["planning"] == ("0.06667", "ms per 30 Hz frame")
    assert "decision_cpu_s" not in rows
    assert not [name for name in rows if name.startswith("timing_")]


def test_a_call_inside_anothers_counts_for_the_inner_room_only():
    class Rooms:
        def outer(self):
            self.inner()

        def inner(self):
            begin = time.process_time()
            while time.process_time() - begin < 0.02:
                pass

    rooms, meter = Rooms(), CpuProfiler()
    meter.wrap(rooms, "inner", "inner")
    meter.wrap(rooms, "outer", "outer")
    rooms.outer()
    assert meter.calls == {"inner": 1, "outer": 1}
    assert meter.spent_s["inner"] >= 0.02
    assert meter.spent_s["outer"] < 0.01
