"""Who dances: the human timing model that a session's configuration names."""

from __future__ import annotations

from pathlib import Path

from .choreography.score import Timetable
from .clock import stream
from .config import SessionConfig
from .errors import ConfigError, PluginError
from .humans.parameters import preset, read_parameters
from .humans.replay import Replay
from .humans.timing import EnsembleTiming, HumanTiming
from .record.event_table import read_event_table
from .registry import resolve

REPLAY = "replay:"
"""What stands before the file of recorded events."""


def people(config: SessionConfig, timetable: Timetable) -> HumanTiming:
    """Make the human timing model of a session.

    ``config.humans`` is a preset's name, a TOML file of `TimingParameters`' fields, ``replay:FILE`` of an event table
    or a session's folder (``replay:FILE#SESSION`` where a table holds several), or ``module:Class`` of an own
    `HumanTiming` that takes the same arguments as `EnsembleTiming` but for the parameters.

    Raises:
        SjasimError: there is no such preset, the file is wrong, or the model does not fit the group.
    """
    name = config.humans
    if name.startswith(REPLAY):
        return _replay(name.removeprefix(REPLAY), timetable, config.group)
    streams = (
        stream(config.seed, "humans", "group"),
        stream(config.seed, "humans", "performance", config.performance or config.method),
    )
    if name.endswith(".toml"):
        return EnsembleTiming(read_parameters(Path(name)), timetable, config.group, *streams)
    if ":" not in name:
        return EnsembleTiming(preset(name), timetable, config.group, *streams)
    model = resolve("humans", name).factory(timetable, config.group, *streams)
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
