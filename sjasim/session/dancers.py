"""The dancers of a session, as every world needs them: their timing model, what they perceive, and their faults."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from ..choreography.timetable import Timetable
from ..config import FaultConfig, SessionConfig
from ..config.toml_file import checked_value
from ..core import Cue, Kind
from ..core.clock import stream
from ..core.errors import ConfigError, PluginError
from ..core.registry import names, resolve
from ..core.session_log import AgentEvent
from ..humans.timing.ensemble import EnsembleTiming
from ..humans.timing.human_timing import HumanTiming
from ..humans.timing.parameters import (
    ENSEMBLE,
    parameters_at_expertise,
    parameters_from,
    preset,
    preset_names,
    read_table,
)
from ..humans.timing.replay import Replay
from ..record.event_table import read_event_table

REPLAY_PREFIX = "replay:"
"""Prefix of ``SessionConfig.humans`` that is followed by a file of recorded events."""

EXPERTISE_PREFIX = "expertise:"
"""Prefix of ``SessionConfig.humans`` that is followed by a number from 0 to 1."""


def make_human_timing(config: SessionConfig, timetable: Timetable) -> HumanTiming:
    """Create the human timing model of a session.

    ``config.humans`` is one of

    - a preset's name, or that of another registered model, which then has its default parameters,
    - ``expertise:NUMBER``, people between novices (0) and musicians (1),
    - a TOML file with the fields of `TimingParameters`; with ``model = "NAME"``, with those of another model,
    - ``replay:FILE``, an event table or a session's folder; ``replay:FILE#SESSION`` for a table of several sessions,
    - ``module:Class``, an implementation of `HumanTiming`. Its constructor takes the arguments of `EnsembleTiming`
      without ``parameters``.

    Raises:
        SjasimError: the preset does not exist, the file is invalid, or the model does not match the number of dancers.
    """
    name = config.humans
    if name.startswith(REPLAY_PREFIX):
        return _replay(name.removeprefix(REPLAY_PREFIX), timetable, config.dancers)

    # Separate streams: the same persons can give different performances, and all methods meet the same persons.
    person_rng = stream(config.seed, "humans", "group")
    performance_rng = stream(config.seed, "humans", "performance", config.performance or config.method)
    if ":" not in name or name.endswith(".toml") or name.startswith(EXPERTISE_PREFIX):
        parameters, factory = _model(name)
        model = factory(parameters, timetable, config.dancers, person_rng, performance_rng)
    else:
        model = resolve("humans", name).factory(timetable, config.dancers, person_rng, performance_rng)

    if not isinstance(model, HumanTiming):
        raise PluginError(f"humans {name!r} made {type(model).__name__}, which lacks begin, decide or next_due_s")
    return model


def _model(name: str) -> tuple[object, Callable[..., object]]:
    """Parameters that a preset, a file, an expertise or a registered model names, and the model that they are for."""
    if name.endswith(".toml"):
        data = read_table(Path(name))
        model = data.pop("model", ENSEMBLE)
        if model == ENSEMBLE:
            return parameters_from(data, f"humans ({name})"), EnsembleTiming

        entry = resolve("humans", str(model))
        if entry.config is None:
            raise ConfigError("humans.model", model, "a model with parameters")
        return checked_value(entry.config, data, f"humans ({name})"), entry.factory

    if name.startswith(EXPERTISE_PREFIX):
        number = name.removeprefix(EXPERTISE_PREFIX)
        try:
            expertise = float(number)
        except ValueError:
            raise ConfigError("humans", name, f"{EXPERTISE_PREFIX} and a number from 0 to 1") from None
        return parameters_at_expertise(expertise), EnsembleTiming

    # Presets come first: resolving a registered name imports every model.
    if name not in preset_names() and name in names("humans"):
        entry = resolve("humans", name)
        assert entry.config is not None
        return entry.config(), entry.factory
    return preset(name), EnsembleTiming


def _replay(source: str, timetable: Timetable, dancers: int) -> Replay:
    """Create the timing model that replays the events of one recorded session."""
    file, _, wanted = source.partition("#")
    events = read_event_table(Path(file))
    sessions = sorted({event.session for event in events})
    if not wanted and len(sessions) == 1:
        wanted = sessions[0]

    if wanted not in sessions:
        choices = ", ".join(f"{REPLAY_PREFIX}{file}#{session}" for session in sessions)
        raise ConfigError("humans", REPLAY_PREFIX + source, f"one session of the table: {choices}")
    return Replay([event for event in events if event.session == wanted], file, timetable, dancers)


def perceived_timing_error_s(cues: Sequence[Cue], robot_events: Sequence[AgentEvent]) -> float | None:
    """Compute the mean timing error of the robot in an iteration, as the dancers perceive it [s].

    The error of a robot event is its distance from the mean time of the dancers' nearest event of the same kind. A turn
    of the robot is compared with the dancers' claps, since the choreography has the robot turn where dancers clap.

    Args:
        cues: the dancers' cues of the iteration.
        robot_events: the robot's events of the iteration.

    Returns:
        the mean over the robot's events, or None if no robot event has a counterpart.
    """
    times: dict[tuple[Kind, int], list[float]] = {}
    for cue in cues:
        for kind, t_s in cue.events():
            times.setdefault((kind, cue.ordinal), []).append(t_s)

    means: dict[Kind, list[float]] = {}
    for (kind, _), values in times.items():
        means.setdefault(kind, []).append(sum(values) / len(values))

    errors = []
    for event in robot_events:
        kind = Kind.CLAP if event.kind is Kind.TURN else event.kind
        if kind in means:
            errors.append(min([abs(event.t_s - mean) for mean in means[kind]]))
    return float(np.mean(errors)) if errors else None


def cues_with_faults(cues: tuple[Cue, ...], faults: Sequence[FaultConfig]) -> tuple[Cue, ...]:
    """Apply the faults ``dancer_late`` and ``dancer_stops``, and return the cues that are performed.

    ``dancer_late`` delays the cues of its target by ``FaultConfig.value``; ``dancer_stops`` removes them. Both affect
    cues from ``FaultConfig.t_s`` on.
    """
    performed = cues
    for fault in faults:
        if fault.kind == "dancer_late":
            performed = tuple(cue.delayed(fault.value) if _is_affected(cue, fault) else cue for cue in performed)
        elif fault.kind == "dancer_stops":
            performed = tuple(cue for cue in performed if not _is_affected(cue, fault))
    return performed


def _is_affected(cue: Cue, fault: FaultConfig) -> bool:
    """Whether a cue belongs to the fault's target and begins at or after the fault."""
    return cue.dancer == fault.target and cue.t_s >= fault.t_s
