"""``python -m sjasim.benchmark``: computing times of sessions and environments on this machine."""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from dataclasses import dataclass

from .commands.main import main
from .commands.options import parse
from .commands.tables import print_table
from .config import SessionConfig
from .studies import benchmark_figures as figures

ABOUT = "Measure the computing time of sessions, depth images and environment steps, and of the bare physics."


@dataclass(frozen=True)
class Options:
    """Options of this command.

    Attributes:
        method: anticipation method of the session that is measured.
        seed: its seed.
        iterations: its number of iterations after the rehearsal.
        json: print the figures as JSON on stdout, and nothing else.
    """

    method: str = "sia"
    seed: int = 0
    iterations: int = 4
    json: bool = False


def command(arguments: Sequence[str], program: str = "python -m sjasim.benchmark") -> None:
    """Measure, and print the figures."""
    options = parse(Options, arguments, None, program, ABOUT)
    # Imported only now: the help needs neither MuJoCo nor Gymnasium.
    from sjasim_envs.profiling import profile_env, profile_workers

    from .simulation.profiling import profile, profile_depth

    sys.stderr.write("measuring sessions and their bare physics ...\n")
    config = SessionConfig(method=options.method, sensing="joints", seed=options.seed, iterations=options.iterations)
    measured = profile(config) | profile_env() | profile_depth(config) | profile_workers()
    measured |= figures.profile_timing(config)
    machine = figures.machine()
    report = {"schema": 1, "command": " ".join([program, *arguments]), "machine": machine}
    report |= {"versions": figures.versions(), **figures.benchmark_figures(measured, figures.import_time_s())}
    if options.json:
        sys.stdout.write(json.dumps(report, indent=1, allow_nan=False) + "\n")
    else:
        title = f"{machine['processor']}, {machine['cores']} cores"
        print_table(("figure", "value", "unit"), figures.table_rows(report), title=title, left=(0, 2))


if __name__ == "__main__":
    sys.exit(main(command))
