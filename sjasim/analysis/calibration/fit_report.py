"""Fits the human timing model to recorded groups, and reports the fit as plain data, a table or a preset's file."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from ...config import DanceConfig
from ...core.text import counted

if TYPE_CHECKING:
    from .timing_fit import TimingFit


@dataclass(frozen=True)
class FitConfig:
    """What is fitted, and to what music.

    Attributes:
        time: what people kept to: the dance's music, a steady tempo of their own, or free time, in which only the
            differences between them are fitted.
        coupling: one number for all pairs of dancers, or a matrix.
        noise: one scale for all dancers, or one for each.
        dance: what was danced, for tables; the folder of a session names its own.
    """

    time: Literal["music", "steady", "free"] = "music"
    coupling: Literal["one", "matrix"] = "one"
    noise: Literal["one", "each"] = "one"
    dance: DanceConfig = field(default_factory=DanceConfig)


def fit_recordings(paths: Sequence[Path], config: FitConfig) -> tuple[TimingFit, list[str]]:
    """Fit the model to event tables and folders of sessions.

    Returns:
        the fit, and lines about events that were not used and about what makes the fit doubtful.

    Raises:
        RecordError: a file cannot be read, or a row is wrong.
        FitError: there are too few events, or they do not fit together.
    """
    # scipy is imported here because it takes longer to import than --help may take.
    from .event_table_fit import read_trials
    from .timing_fit import fit_trials

    dance = None if config.dance == DanceConfig() else config.dance
    trials = read_trials(paths, dance, config.time)
    fit = fit_trials(trials, coupling=config.coupling, noise=config.noise)

    lines = [f"warning: {text}" for text in fit.warnings]
    if trials.unused:
        unused = counted(trials.unused, "event")
        lines.insert(0, f"{unused} not used: another of the same dancer is nearer to the same step")
    return fit, lines


def save_fit(fit: TimingFit, path: Path) -> None:
    """Write the fit as a preset's file.

    Raises:
        FitError: no group with these parameters can dance.
    """
    from .event_table_fit import as_toml

    path.write_text(as_toml(fit), encoding="utf-8")
    sys.stderr.write(f"fit written to {path}\n")


def fit_as_dict(fit: TimingFit) -> dict[str, object]:
    """The fit as JSON can hold it: the end of an interval that is not known is None."""
    estimates = {name: _finite(asdict(item)) for name, item in fit.estimates.items()}
    return {
        "schema": 2,
        "agents": fit.agents,
        "iterations": fit.iterations,
        "events": fit.events,
        "log_likelihood": fit.log_likelihood,
        "estimates": estimates,
        "doubts": fit.warnings,
    }


def fit_title(fit: TimingFit) -> str:
    """What the model was fitted to, in one line."""
    return f"{counted(fit.events, 'event')} of {', '.join(fit.agents)} in {counted(fit.iterations, 'iteration')}"


def fit_rows(fit: TimingFit) -> Iterator[tuple[str, str, str]]:
    """(parameter, fitted value, 95 % interval) of every parameter."""
    for name, item in fit.estimates.items():
        known = math.isfinite(item.high - item.low)
        interval = f"{item.low:.4f} to {item.high:.4f}" if known else "-"
        yield name, f"{item.value:.4f}", interval


def _finite(plain: dict[str, float]) -> dict[str, float | None]:
    return {name: value if math.isfinite(value) else None for name, value in plain.items()}
