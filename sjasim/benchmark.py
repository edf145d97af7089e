"""``python -m sjasim.benchmark``: what a session costs, against the raw physics of the same scene."""

from __future__ import annotations

import json
import os
import platform
import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from typing import Any

from rich.console import Console
from rich.table import Table

from .commands.options import main, parse
from .config import SessionConfig

ABOUT = "What a session, a depth frame and an environment's step cost to compute, on this machine."

UNITS = {
    "raw_physics_sim_s_per_cpu_s": "s/s", "session_sim_s_per_cpu_s_joints": "s/s", "session_cost_ratio_joints": "",
    "session_sim_s_per_cpu_s_depth": "s/s", "depth_frame_cpu_s": "s", "planning_cpu_s": "s per simulated s",
    "stabiliser_tick_cpu_s": "s", "env_steps_per_s": "1/s", "env_ratio_to_raw": "", "async2_speedup": "",
    "timing_session_cpu_s": "s", "timing_env_steps_per_s": "1/s", "decision_cpu_s": "s", "logging_share": "",
    "import_s": "s", "peak_mb": "MB",
}  # fmt: skip
"""Every figure, in the order of the report, and its unit."""

FIGURES = tuple(UNITS)
PACKAGES = ("sjasim", "numpy", "scipy", "mujoco", "gymnasium", "numba", "rerun-sdk")
FRAME_HZ = 30


@dataclass(frozen=True)
class Options:
    """Performance figures.

    Attributes:
        seed: of the session that is measured.
        method: its anticipation method.
        iterations: its length.
        json: print the figures as JSON, and nothing else, on stdout.
    """

    seed: int = 0
    method: str = "sia"
    iterations: int = 4
    json: bool = False


def command(arguments: Sequence[str]) -> None:
    """Measure and print."""
    options = parse(Options, arguments, Options(), "python -m sjasim.benchmark", ABOUT)
    from sjasim_envs.profiling import profile_env, profile_workers

    from .simulation.profiling import profile, profile_depth

    sys.stderr.write("measuring sessions and their raw physics ...\n")
    config = SessionConfig(method=options.method, sensing="joints", seed=options.seed, iterations=options.iterations)
    found = profile(config) | profile_env() | profile_depth(config) | profile_workers()
    report = {
        "schema": 1,
        "command": f"python -m sjasim.benchmark {' '.join(arguments)}".rstrip(),
        "machine": machine(),
        "versions": versions(),
        **results(found, import_s()),
    }
    if options.json:
        sys.stdout.write(json.dumps(report, indent=1, allow_nan=False) + "\n")
    else:
        show(report, Console())


def results(profile: Mapping[str, Any], import_time_s: float) -> dict[str, Any]:
    """Figures from what a profiled session hands over.

    Args:
        profile: ``sim_s``; ``cpu_s`` of the session; ``raw_cpu_s`` of its recorded controls replayed through the
            bare physics of the same scene; ``room_cpu_s`` by room (``physics``, ``planning``, ``stabiliser``,
            ``sensing``, ``server``, ``decision``, ``logging``, ...); ``stabiliser_ticks``; ``decisions``, how
            often a method was called; ``peak_mb``; ``env_steps``, ``env_cpu_s`` and ``env_raw_cpu_s`` of the
            environment and the bare physics of its steps; ``depth_sim_s`` and ``depth_cpu_s`` of a session with depth
            sensing, ``depth_frames`` and ``depth_frame_cpu_s`` of its active sensor; ``async_steps_per_s`` of one
            worker and two. Absent ones make null figures.
        import_time_s: time of ``import sjasim`` [s].

    Returns:
        ``figures`` and ``room_ms_per_frame``: milliseconds of CPU time per 30 Hz tick, by room.
    """
    sim_s, cpu_s, raw_s = (profile.get(key) for key in ("sim_s", "cpu_s", "raw_cpu_s"))
    rooms = profile.get("room_cpu_s", {})
    figures: dict[str, float | None] = dict.fromkeys(FIGURES)
    figures |= {
        "raw_physics_sim_s_per_cpu_s": _ratio(sim_s, raw_s),
        "session_sim_s_per_cpu_s_joints": _ratio(sim_s, cpu_s),
        "session_cost_ratio_joints": _ratio(cpu_s, raw_s),
        "session_sim_s_per_cpu_s_depth": _ratio(profile.get("depth_sim_s"), profile.get("depth_cpu_s")),
        "depth_frame_cpu_s": _ratio(profile.get("depth_frame_cpu_s"), profile.get("depth_frames")),
        "planning_cpu_s": _ratio(rooms.get("planning"), sim_s),
        "stabiliser_tick_cpu_s": _ratio(rooms.get("stabiliser"), profile.get("stabiliser_ticks")),
        "decision_cpu_s": _ratio(rooms.get("decision"), profile.get("decisions")),
        "logging_share": _ratio(rooms.get("logging"), cpu_s),
        "env_steps_per_s": _ratio(profile.get("env_steps"), profile.get("env_cpu_s")),
        "env_ratio_to_raw": _ratio(profile.get("env_raw_cpu_s"), profile.get("env_cpu_s")),
        "async2_speedup": _ratio(*reversed(profile.get("async_steps_per_s", (None, None)))),
        "import_s": import_time_s,
        "peak_mb": profile.get("peak_mb"),
    }
    frames = None if sim_s is None else sim_s * FRAME_HZ / 1000
    return {"figures": figures, "room_ms_per_frame": {room: _ratio(spent, frames) for room, spent in rooms.items()}}


def import_s(times: int = 3) -> float:
    """Fastest of some ``import sjasim`` in processes of their own [s]."""
    probe = "import time; t = time.perf_counter(); import sjasim; print(time.perf_counter() - t)"
    runs = [subprocess.run([sys.executable, "-c", probe], capture_output=True, check=True) for _ in range(times)]
    return min(float(run.stdout) for run in runs)


def machine() -> dict[str, object]:
    """What the figures were measured on."""
    return {
        "system": platform.platform(),
        "processor": _processor() or platform.processor() or platform.machine(),
        "cores": os.cpu_count(),
        "python": platform.python_version(),
    }


def versions() -> dict[str, str | None]:
    """Versions of the packages that the figures depend on."""
    found: dict[str, str | None] = {}
    for package in PACKAGES:
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            found[package] = None
    return found


def show(report: Mapping[str, Any], console: Console) -> None:
    """Print the figures for people; those that nothing has been measured for are left out."""
    table = Table(title=f"{report['machine']['processor']}, {report['machine']['cores']} cores")
    table.add_column("figure")
    table.add_column("value", justify="right")
    table.add_column("unit")
    rooms = [(room, value, "ms per 30 Hz tick") for room, value in report["room_ms_per_frame"].items()]
    for name, value, unit in [*((name, value, UNITS[name]) for name, value in report["figures"].items()), *rooms]:
        if value is not None:
            table.add_row(name, f"{value:.4g}", unit)
    console.print(table)


def _processor() -> str:
    """The processor's name where Linux tells it."""
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as lines:
            named = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    except OSError:
        return ""
    return named[0] if named else ""


def _ratio(part: float | None, whole: float | None) -> float | None:
    return part / whole if part is not None and whole else None


if __name__ == "__main__":
    sys.exit(main(command))
