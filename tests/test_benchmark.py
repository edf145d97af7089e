"""Benchmark figures: what they are made of, and that one's time is not counted for two."""

import io
import re
import time

import pytest
from rich.console import Console

from sjasim.benchmark import FIGURES, results, show
from sjasim.simulation.profiling import CpuProfiler

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
    figures = results(PROFILE, 0.3)["figures"]
    assert tuple(figures) == FIGURES
    wanted = {
        "session_cost_ratio_joints": 1.5, "session_sim_s_per_cpu_s_depth": 2.0, "depth_frame_cpu_s": 0.015,
        "env_ratio_to_raw": 0.75, "async2_speedup": 1.8, "logging_share": 0.05, "planning_cpu_s": 0.002,
        "import_s": 0.3,
    }  # fmt: skip
    assert {name: figures[name] for name in wanted} == pytest.approx(wanted)
    assert figures["decision_cpu_s"] is None


def test_what_was_not_measured_is_null():
    figures = results({}, 0.3)["figures"]
    assert {name for name, value in figures.items() if value is not None} == {"import_s"}


def test_people_see_units_and_no_empty_figures():
    report = {"machine": {"processor": "P", "cores": 2}, **results(PROFILE, 0.3)}
    console = Console(file=io.StringIO(), width=100)
    show(report, console)
    said = console.file.getvalue()
    assert re.search(r"depth_frame_cpu_s +│ +0.015 │ s ", said)
    assert re.search(r"planning +│ +\S+ │ ms per 30 Hz tick", said)
    assert "timing_" not in said
    assert "decision_cpu_s" not in said


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
