"""Computing times of sessions, sensors and environments, compared with the bare physics of the same scene."""

from __future__ import annotations

import os
import platform
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping
from dataclasses import replace
from importlib.metadata import PackageNotFoundError, version
from typing import Any

from ..config import SessionConfig

UNITS = {
    "raw_physics_sim_s_per_cpu_s": "s/s",
    "session_sim_s_per_cpu_s_joints": "s/s",
    "session_cost_ratio_joints": "",
    "session_sim_s_per_cpu_s_depth": "s/s",
    "depth_frame_cpu_s": "s",
    "planning_cpu_s": "s per simulated s",
    "stabiliser_tick_cpu_s": "s",
    "env_steps_per_s": "1/s",
    "env_ratio_to_raw": "",
    "async2_speedup": "",
    "timing_session_cpu_s": "s",
    "timing_env_steps_per_s": "1/s",
    "decision_cpu_s": "s",
    "logging_share": "",
    "import_s": "s",
    "peak_mb": "MB",
}
"""Every figure, in the order of the report, and its unit."""

PACKAGES = ("sjasim", "numpy", "scipy", "mujoco", "gymnasium", "numba", "rerun-sdk")
"""Packages whose versions the report names."""

FRAME_HZ = 30
"""Frames of a sensor per second: the time of each part of a session is given per frame [Hz]."""


def benchmark_figures(profile: Mapping[str, Any], import_time_s: float) -> dict[str, Any]:
    """The figures of the report, from what a profiled session measured.

    Args:
        profile: ``sim_s``; ``cpu_s`` of the session; ``raw_cpu_s`` of its recorded controls replayed through the
            bare physics of the same scene; ``room_cpu_s`` by part of the session (``physics``, ``planning``,
            ``stabiliser``, ``sensing``, ``server``, ``decision``, ``logging``, ...); ``stabiliser_ticks``;
            ``decisions``, the number of calls of the method; ``peak_mb``; ``env_steps``, ``env_cpu_s`` and
            ``env_raw_cpu_s`` of the environment and the bare physics of its steps; ``depth_sim_s`` and ``depth_cpu_s``
            of a session with depth sensing, ``depth_frames`` and ``depth_frame_cpu_s`` of its active sensor;
            ``async_steps_per_s`` of one worker and of two; ``timing_sessions`` and ``timing_cpu_s`` of sessions in
            fidelity timing. A figure whose parts are absent is None.
        import_time_s: duration of ``import sjasim`` [s].

    Returns:
        ``figures``; and ``room_ms_per_frame``, milliseconds of CPU time per frame by part of the session.
    """
    sim_s = profile.get("sim_s")
    cpu_s = profile.get("cpu_s")
    raw_s = profile.get("raw_cpu_s")
    parts = profile.get("room_cpu_s", {})
    one_worker, two_workers = profile.get("async_steps_per_s", (None, None))

    figures: dict[str, float | None] = dict.fromkeys(UNITS)
    figures |= {
        "raw_physics_sim_s_per_cpu_s": _ratio(sim_s, raw_s),
        "session_sim_s_per_cpu_s_joints": _ratio(sim_s, cpu_s),
        "session_cost_ratio_joints": _ratio(cpu_s, raw_s),
        "session_sim_s_per_cpu_s_depth": _ratio(profile.get("depth_sim_s"), profile.get("depth_cpu_s")),
        "depth_frame_cpu_s": _ratio(profile.get("depth_frame_cpu_s"), profile.get("depth_frames")),
        "planning_cpu_s": _ratio(parts.get("planning"), sim_s),
        "stabiliser_tick_cpu_s": _ratio(parts.get("stabiliser"), profile.get("stabiliser_ticks")),
        "decision_cpu_s": _ratio(parts.get("decision"), profile.get("decisions")),
        "logging_share": _ratio(parts.get("logging"), cpu_s),
        "env_steps_per_s": _ratio(profile.get("env_steps"), profile.get("env_cpu_s")),
        "env_ratio_to_raw": _ratio(profile.get("env_raw_cpu_s"), profile.get("env_cpu_s")),
        "async2_speedup": _ratio(two_workers, one_worker),
        "timing_session_cpu_s": _ratio(profile.get("timing_cpu_s"), profile.get("timing_sessions")),
        "import_s": import_time_s,
        "peak_mb": profile.get("peak_mb"),
    }

    # Divided by 1000 so that seconds per frame become milliseconds.
    kiloframes = None if sim_s is None else sim_s * FRAME_HZ / 1000
    return {"figures": figures, "room_ms_per_frame": {name: _ratio(spent, kiloframes) for name, spent in parts.items()}}


def profile_timing(config: SessionConfig, sessions: int = 50) -> dict[str, float]:
    """Measure sessions in fidelity timing, with their rows of a study's tables.

    Args:
        config: method, people and first seed.
        sessions: number of measured sessions; a few more run before, which import modules and fill caches.

    Returns:
        ``timing_sessions`` and ``timing_cpu_s``, as `benchmark_figures` takes them.
    """
    from .study_parts import simulated

    configs = [replace(config, fidelity="timing", seed=config.seed + number) for number in range(sessions + 3)]
    for number, warm_up in enumerate(configs[:3]):
        simulated(warm_up, number)

    start_s = time.process_time()
    for number, measured in enumerate(configs[3:]):
        simulated(measured, number)
    return {"timing_sessions": float(sessions), "timing_cpu_s": time.process_time() - start_s}


def table_rows(report: Mapping[str, Any]) -> Iterator[tuple[str, str, str]]:
    """(figure, value, unit) of every figure that was measured."""
    values = [(name, value, UNITS[name]) for name, value in report["figures"].items()]
    values += [(name, value, f"ms per {FRAME_HZ} Hz frame") for name, value in report["room_ms_per_frame"].items()]
    for name, value, unit in values:
        if value is not None:
            yield name, f"{value:.4g}", unit


def import_time_s(times: int = 3) -> float:
    """Shortest of some ``import sjasim``, each in a process of its own [s]."""
    probe = "import time; t = time.perf_counter(); import sjasim; print(time.perf_counter() - t)"
    # A module is imported once in a process, so each measurement needs a process of its own.
    runs = [subprocess.run([sys.executable, "-c", probe], capture_output=True, check=True) for _ in range(times)]
    return min(float(run.stdout) for run in runs)


def machine() -> dict[str, object]:
    """System, processor, cores and Python of this computer."""
    return {
        "system": platform.platform(),
        "processor": _processor() or platform.processor() or platform.machine(),
        "cores": os.cpu_count(),
        "python": platform.python_version(),
    }


def versions() -> dict[str, str | None]:
    """Versions of the packages that the figures depend on; None for one that is not installed."""
    found: dict[str, str | None] = {}
    for package in PACKAGES:
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            found[package] = None
    return found


def _processor() -> str:
    """The processor's name, which only Linux gives in full; "" elsewhere."""
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as lines:
            names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    except OSError:
        return ""
    return names[0] if names else ""


def _ratio(part: float | None, whole: float | None) -> float | None:
    return part / whole if part is not None and whole else None
