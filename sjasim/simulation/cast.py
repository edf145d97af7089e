"""Who dances: the human timing model that a configuration names, their builds, what they feel and what befalls them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ..choreography.timetable import Timetable
from ..config import FaultConfig, SessionConfig
from ..core import Cue, Kind
from ..core.clock import stream
from ..core.errors import ConfigError, PluginError
from ..core.registry import resolve
from ..core.session_log import AgentEvent
from ..humans.body.anatomy import Build
from ..humans.timing.ensemble import EnsembleTiming
from ..humans.timing.human_timing import HumanTiming
from ..humans.timing.parameters import preset, read_parameters
from ..humans.timing.replay import Replay
from ..record.event_table import read_event_table

REPLAY = "replay:"
"""What stands before the file of recorded events."""


def make_human_timing(config: SessionConfig, timetable: Timetable) -> HumanTiming:
    """Make the human timing model of a session.

    ``config.humans`` is a preset's name, a TOML file of `TimingParameters`' fields, ``replay:FILE`` of an event table
    or a session's folder (``replay:FILE#SESSION`` where a table holds several), or ``module:Class`` of an own
    `HumanTiming` that takes the same arguments as `EnsembleTiming` but for the parameters.

    Raises:
        SjasimError: there is no such preset, the file is wrong, or the model does not fit the group.
    """
    name = config.humans
    if name.startswith(REPLAY):
        return _replay(name.removeprefix(REPLAY), timetable, config.dancers)
    streams = (
        stream(config.seed, "humans", "group"),
        stream(config.seed, "humans", "performance", config.performance or config.method),
    )
    if name.endswith(".toml"):
        return EnsembleTiming(read_parameters(Path(name)), timetable, config.dancers, *streams)
    if ":" not in name:
        return EnsembleTiming(preset(name), timetable, config.dancers, *streams)
    model = resolve("humans", name).factory(timetable, config.dancers, *streams)
    if not isinstance(model, HumanTiming):
        raise PluginError(f"humans {name!r} made {type(model).__name__}, which lacks begin, decide or next_due_s")
    return model


def _replay(source: str, timetable: Timetable, group: int) -> Replay:
    file, _, wanted = source.partition("#")
    events = read_event_table(Path(file))
    sessions = sorted({event.session for event in events})
    if not wanted and len(sessions) == 1:
        wanted = sessions[0]
    if wanted not in sessions:
        allowed = f"one session of the table: {', '.join(f'{REPLAY}{file}#{session}' for session in sessions)}"
        raise ConfigError("humans", REPLAY + source, allowed)
    return Replay([event for event in events if event.session == wanted], file, timetable, group)


def perceived_timing_error_s(cues: Sequence[Cue], robot_events: Sequence[AgentEvent]) -> float | None:
    """Mean distance from each robot event to the dancers' mean time of the nearest move of its kind [s].

    None where nobody moved or the robot did not.
    """
    times: dict[tuple[Kind, int], list[float]] = {}
    for cue in cues:
        for kind, t_s in cue.events():
            times.setdefault((kind, cue.ordinal), []).append(t_s)
    errors = []
    for event in robot_events:
        kind = Kind.CLAP if event.kind is Kind.TURN else event.kind
        means = [float(np.mean(values)) for (other, _), values in times.items() if other is kind]
        if means:
            errors.append(min(abs(event.t_s - mean) for mean in means))
    return float(np.mean(errors)) if errors else None


def sample_build(config: SessionConfig, index: int) -> Build:
    """Who stands in a slot: the same under every method."""
    rng = stream(config.seed, "humans", "person", index)
    stature = rng.uniform(*config.body.stature_m)
    return Build(float(stature), float(rng.uniform(*config.body.mass_kg)))


def cues_with_faults(cues: tuple[Cue, ...], faults: Sequence[FaultConfig]) -> tuple[Cue, ...]:
    """Cues as they are performed by a dancer who is made late or made to stop."""
    out = cues
    for fault in faults:
        if fault.kind == "dancer_late":
            out = tuple(cue.delayed(fault.value) if _hit(cue, fault) else cue for cue in out)
        elif fault.kind == "dancer_stops":
            out = tuple(cue for cue in out if not _hit(cue, fault))
    return out


def _hit(cue: Cue, fault: FaultConfig) -> bool:
    return cue.dancer == fault.target and cue.t_s >= fault.t_s
