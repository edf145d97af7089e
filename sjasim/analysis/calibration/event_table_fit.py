"""The human timing model fitted to recorded groups: from files to parameters that can be danced."""

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
from .timing_fit import TappingTrials, TimingFit, fit_trials
from .trials import arrange_trials, concatenate_trials


def fit_timing(
    *paths: str | Path,
    dance: DanceConfig | None = None,
    music: bool = True,
    coupling: str = "one",
    noise: str = "one",
) -> TimingFit:
    """Fit the human timing model to one or more recorded sessions.

    Args:
        paths: event tables (CSV or Parquet), or folders of sessions.
        dance: what was danced, for tables that come without it; a session's folder knows its own.
        music: whether people kept to the dance's music. In free time only what divides them is fitted.
        coupling: ``one`` number for all pairs, or ``matrix``.
        noise: ``one`` scale for all dancers, or ``each`` their own.

    Raises:
        RecordError: a file cannot be read, or a row is wrong.
        FitError: there is too little, or it does not fit together.
    """
    return fit_trials(read_trials([Path(path) for path in paths], dance, music), coupling=coupling, noise=noise)


def read_trials(paths: Sequence[Path], dance: DanceConfig | None, music: bool) -> TappingTrials:
    """TappingTrials of all the files, each a session or more of its own; arguments as in `fit_timing`."""
    if not paths:
        raise ConfigError("paths", (), "one event table or session's folder at least")
    return concatenate_trials([_read(path, dance, music) for path in paths])


def _read(path: Path, dance: DanceConfig | None, music: bool) -> TappingTrials:
    config = SessionConfig()
    if path.is_dir():
        plain = read_summary(path)["config"]
        if not isinstance(plain, dict):
            raise RecordError(f"{path} is no session's folder: its session.json has no config")
        config = from_plain(plain)
    if dance is not None:
        config = replace(config, dance=dance)
    return arrange_trials(read_event_table(path), timetable(config) if music else None)


def as_toml(fit: TimingFit) -> str:
    """A fit as a preset's file for ``--humans FILE.toml``, its intervals as comments."""
    lines = ["# A fit of python -m sjasim.calibrate; in comments the 95 % intervals. Times in seconds.", ""]
    for field in fields(TimingParameters):
        value = getattr(fit.parameters, field.name)
        if value == field.default:
            continue
        own = {name: item for name, item in fit.estimates.items() if name.partition("[")[0] == field.name}
        lines += [f"# {name}: {item.value:.4g}, {item.low:.4g} to {item.high:.4g}" for name, item in own.items()]
        lines.append(f"{field.name} = {_toml(value)}")
    return "\n".join(lines) + "\n"


def _toml(value: object) -> str:
    if isinstance(value, tuple):
        return f"[{', '.join(_toml(item) for item in value)}]"
    return f"{value:.6g}" if isinstance(value, float) else json.dumps(value, ensure_ascii=False)
