"""Who dances: the human timing model that a session's configuration names."""

from __future__ import annotations

from pathlib import Path

from .choreography.score import Timetable
from .clock import stream
from .config import SessionConfig
from .errors import PluginError
from .humans.parameters import preset, read_parameters
from .humans.timing import EnsembleTiming, HumanTiming
from .registry import resolve


def people(config: SessionConfig, timetable: Timetable) -> HumanTiming:
    """Make the human timing model of a session.

    ``config.humans`` is a preset's name, a TOML file of `TimingParameters`' fields, or ``module:Class`` of an own
    `HumanTiming` that takes the same arguments as `EnsembleTiming` but for the parameters.

    Raises:
        SjasimError: there is no such preset, the file is wrong, or the model does not fit the group.
    """
    name = config.humans
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
