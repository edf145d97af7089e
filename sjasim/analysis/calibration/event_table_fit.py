"""Fits the human timing model to recorded groups: from files to parameters with which dancers can be simulated."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import fields, replace
from pathlib import Path

from ...choreography.timetable import timetable
from ...config import DanceConfig, SessionConfig
from ...config.toml_file import from_plain
from ...core.errors import ConfigError, RecordError
from ...humans.timing.parameters import TimingParameters
from ...record.event_table import read_event_table
from ...record.session_folder import read_summary
from .tapping_trials import TappingTrials, Time
from .timing_fit import TimingFit, fit_trials
from .trials import arrange_trials, concatenate_trials


def fit_timing(
    *paths: str | Path,
    dance: DanceConfig | None = None,
    time: Time = "music",
    coupling: str = "one",
    noise: str = "one",
) -> TimingFit:
    """Fit the human timing model to one or more recorded sessions.

    Args:
        paths: event tables (CSV or Parquet), or sessions' folders.
        dance: the dance that was recorded, for event tables; a session's folder contains its own.
        time: what people kept to: the dance's ``music``, a ``steady`` tempo of their own, or ``free`` time, in which
            only what differs between dancers is fitted.
        coupling: ``one`` number for all pairs of dancers, or ``matrix``, one for each.
        noise: ``one`` scale for all dancers, or ``each`` their own.

    Raises:
        RecordError: a file cannot be read, or a row is invalid.
        FitError: there are too few events, or the tables do not belong to one group and dance.
    """
    trials = read_trials([Path(path) for path in paths], dance, time)
    return fit_trials(trials, coupling=coupling, noise=noise)


def read_trials(paths: Sequence[Path], dance: DanceConfig | None, time: Time) -> TappingTrials:
    """Read the trials of all files; each file holds one or more sessions of its own. Arguments as in `fit_timing`."""
    if not paths:
        raise ConfigError("paths", (), "one event table or session's folder at least")
    return concatenate_trials([_read_file(path, dance, time) for path in paths])


def as_toml(fit: TimingFit) -> str:
    """A fit as a file for ``--humans FILE.toml``, with the intervals as comments.

    Raises:
        FitError: no group could dance with the fitted parameters.
    """
    lines = ["# A fit of python -m sjasim.calibrate; in comments the 95 % intervals. Times in seconds.", ""]
    for field in fields(TimingParameters):
        value = getattr(fit.parameters, field.name)
        if value == field.default:
            continue

        # The estimates of a matrix are named ``coupling[1][2]``.
        estimates = {name: item for name, item in fit.estimates.items() if name.partition("[")[0] == field.name}
        lines += [f"# {name}: {item.value:.4g}, {item.low:.4g} to {item.high:.4g}" for name, item in estimates.items()]
        lines.append(f"{field.name} = {_toml_value(value)}")
    return "\n".join(lines) + "\n"


def _read_file(path: Path, dance: DanceConfig | None, time: Time) -> TappingTrials:
    """Trials of one event table or session's folder."""
    config = SessionConfig()
    if path.is_dir():
        plain = read_summary(path)["config"]
        if not isinstance(plain, dict):
            raise RecordError(f"{path} is no session's folder: its session.json has no config")
        config = from_plain(plain)
    if dance is not None:
        config = replace(config, dance=dance)

    return arrange_trials(read_event_table(path), timetable(config) if time == "music" else None, time == "steady")


def _toml_value(value: object) -> str:
    """A number, string or nested tuple in TOML."""
    if isinstance(value, tuple):
        return f"[{', '.join(_toml_value(item) for item in value)}]"
    return f"{value:.6g}" if isinstance(value, float) else json.dumps(value, ensure_ascii=False)
