"""``python -m sjasim.calibrate``: fit the human timing model to recorded groups, and keep it as a preset's file."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import tyro
from rich.console import Console
from rich.table import Table

from .commands.options import counted, main, parse
from .config import DanceConfig
from .record.atomic_folder import check_file

if TYPE_CHECKING:
    from .analysis.calibration.timing_fit import TimingFit

ABOUT = "Fit coupling and noise of the human timing model to event tables or sessions' folders."


@dataclass(frozen=True)
class Options:
    """The human timing model fitted to recorded groups.

    Attributes:
        paths: event tables (.csv, .parquet) or sessions' folders.
        out: TOML file for the fit, to be danced with --humans FILE.toml.
        time: whether people kept to the dance's music, or free time, where only what divides them is fitted.
        coupling: one number for all pairs of dancers, or a matrix.
        noise: one scale for all dancers, or one for each.
        dance: what was danced, for tables that come without it; a session's folder knows its own.
        overwrite: replace an earlier file.
        json: print the fit, and nothing else, as JSON on stdout.
    """

    paths: tyro.conf.Positional[tuple[Path, ...]]
    out: Path | None = None
    time: Literal["music", "free"] = "music"
    coupling: Literal["one", "matrix"] = "one"
    noise: Literal["one", "each"] = "one"
    dance: DanceConfig = field(default_factory=DanceConfig)
    overwrite: bool = False
    json: bool = False


def command(arguments: Sequence[str]) -> None:
    """Read, fit, show, and keep what could be danced."""
    options = parse(Options, arguments, None, "python -m sjasim.calibrate", ABOUT)
    if options.out is not None:
        check_file(options.out, options.overwrite)
    from .analysis.calibration.event_table_fit import as_toml, read_trials
    from .analysis.calibration.timing_fit import fit_trials

    dance = None if options.dance == DanceConfig() else options.dance
    data = read_trials(options.paths, dance, options.time == "music")
    if data.unused:
        unused = f"{counted(data.unused, 'event')} not used"
        sys.stderr.write(f"{unused}: another of the same dancer is nearer to the same step\n")
    fit = fit_trials(data, coupling=options.coupling, noise=options.noise)
    (_print_json if options.json else _print_table)(fit)
    sys.stderr.writelines(f"warning: {doubt}\n" for doubt in fit.warnings)
    if options.out is not None:
        options.out.write_text(as_toml(fit), encoding="utf-8")
        sys.stderr.write(f"kept in {options.out}\n")


def _print_json(fit: TimingFit) -> None:
    plain = {"schema": 1, "agents": fit.agents, "performances": fit.performances, "events": fit.events}
    estimates = {name: _finite(asdict(item)) for name, item in fit.estimates.items()}
    whole = {**plain, "log_likelihood": fit.log_likelihood, "estimates": estimates, "doubts": fit.warnings}
    sys.stdout.write(json.dumps(whole, allow_nan=False) + "\n")


def _print_table(fit: TimingFit) -> None:
    events, trials = counted(fit.events, "event"), counted(fit.performances, "performance")
    console, table = Console(), Table()
    for name in ("parameter", "fitted", "95 % interval"):
        table.add_column(name, justify="left" if name == "parameter" else "right")
    for name, item in fit.estimates.items():
        known = f"{item.low:.4f} to {item.high:.4f}" if math.isfinite(item.high - item.low) else "-"
        table.add_row(name.replace("[", "\\["), f"{item.value:.4f}", known)
    console.print(f"{events} of {', '.join(fit.agents)} in {trials}", markup=False, highlight=False)
    console.print(table)


def _finite(plain: dict[str, float]) -> dict[str, float | None]:
    """What JSON can hold; an end that is not known is null."""
    return {name: value if math.isfinite(value) else None for name, value in plain.items()}


if __name__ == "__main__":
    sys.exit(main(command))
