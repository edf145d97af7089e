"""The timetable that a configuration asks for: its dance, its tempo, its iterations."""

from __future__ import annotations

from ..config import SessionConfig
from ..core.errors import PluginError
from ..core.registry import resolve
from ..core.tempo import TempoMap
from .score import Choreography, Timetable


def timetable(config: SessionConfig) -> Timetable:
    """Lay out a session's dance in time.

    Raises:
        UnknownNameError: no choreography of that name.
        PluginError: the named object does not make a `Choreography`.
    """
    dance = resolve("choreography", config.dance.name).factory()
    if not isinstance(dance, Choreography):
        raise PluginError(f"choreography {config.dance.name!r} made {type(dance).__name__}, not a Choreography")
    own = config.dance
    tempo = TempoMap.changing(own.bpm, own.tempo, own.pauses)
    return Timetable(dance, tempo, own.lead_in_s, 0 if own.rehearsal else 1, config.iterations)
