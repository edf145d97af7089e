"""Measures of a session, computed from its log alone, so that they can be recomputed from the tables of a folder.

To add a measure of the session: add a field to `Measures`, compute it in `measures`, and add it to
`Measures.as_dict`, which session.json holds. To add one of each iteration: add a field to `IterationMeasures` and
compute it in `_measure_iteration`. The group's synchrony and timing come from `group_metrics`, the quality of
detectors, clocks, robot and bodies from `component_quality`.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..choreography.timetable import Timetable, timetable
from ..config.toml_file import from_plain
from ..core import ROBOT, Array, Cue
from ..core.session_log import AgentEvent, Notice, SessionLog
from .component_quality import (
    BodyQuality,
    ClockQuality,
    DetectorQuality,
    RobotQuality,
    body_quality,
    clock_errors,
    clock_quality,
    detector_quality,
    mean_delay_s,
    robot_quality,
    sent_times,
)
from .ground_truth_events import dancer_events, robot_events
from .group_metrics import GroupSynchronyRow, group_metrics, net_latencies
from .json_data import without_nan

SCHEMA = 2
"""Version of session.json."""

CONFIG_KEYS = ("method", "seed", "fidelity", "sensing", "humans")
"""Keys of the configuration that session.json repeats at its top level."""

INDEX_KEYS = ("gsi", "gsi_full_edges", "gsi_truth", "ta_mean_s", "ta_truth_mean_s", "late_mean_s")
"""Fields of `Measures` that session.json holds as they are."""


@dataclass(frozen=True, slots=True)
class IterationMeasures:
    """Measures of one danced iteration.

    Attributes:
        index: number of the iteration, from 1.
        gsi: group synchronisation index from logged times, under the paper's edges.
        gsi_full_edges: the index from logged times, under all edges.
        gsi_truth: the index from true onsets, under all edges. Its difference from ``gsi_full_edges`` is the effect of
            detection.
        msp: the most synchronous person of this iteration; SIA follows it in the next one.
        followed: the dancers whom the robot followed in this iteration; all of them for a method that uses everyone's
            events, and none without a robot.
        late_mean_s: mean time of the robot's steps behind the dancers' mean, negative for early [s]; NaN without a
            robot.
        ta_mean_s: mean timing appropriateness, which is the absolute value of the same difference [s]; NaN without a
            robot.
        human_events: number of the dancers' logged regular events.
        robot_events: number of the robot's events.
        robot_missed: number of steps that the robot did not perform.
    """

    index: int
    gsi: float
    gsi_full_edges: float
    gsi_truth: float
    msp: str
    followed: tuple[str, ...]
    late_mean_s: float
    ta_mean_s: float
    human_events: int
    robot_events: int
    robot_missed: int


@dataclass(frozen=True, slots=True)
class Latency:
    """Net latency of one event kind: time of the robot's event minus that of the followed dancer's logged one.

    Attributes:
        mean: mean [s].
        sd: standard deviation [s].
        n: number of events.
    """

    mean: float
    sd: float
    n: int


@dataclass(frozen=True, slots=True)
class Measures:
    """All measures of a session; one that does not apply is NaN here and null in session.json.

    Attributes:
        config: full configuration of the session as plain data.
        versions: package -> version.
        iterations: one entry per danced iteration.
        gsi: group synchronisation index, mean over iterations: logged times, the paper's edges.
        gsi_full_edges: the same with logged times and all edges.
        gsi_truth: the same with true onsets and all edges.
        ta_s: every value of timing appropriateness, in order of iteration and step [s].
        ta_mean_s: their mean [s].
        ta_truth_mean_s: mean timing appropriateness from true onsets of dancers and robot [s].
        late_mean_s: mean time of the robot's steps behind the dancers' mean, negative for early [s].
        net_latency_s: event kind -> net latency, over the steps that an event of a dancer triggered.
        detector: logged against true events.
        clocks: sensor -> clock error.
        robot: executed commands, and pose at the end.
        bodies: balance support, load and falls.
        notices: failures that the session reported.
        cost: simulated time ``sim_s``, CPU time ``cpu_s`` and elapsed time ``wall_s`` [s].
    """

    config: Mapping[str, object]
    versions: Mapping[str, str]
    iterations: tuple[IterationMeasures, ...]
    gsi: float
    gsi_full_edges: float
    gsi_truth: float
    ta_s: tuple[float, ...]
    ta_mean_s: float
    ta_truth_mean_s: float
    late_mean_s: float
    net_latency_s: Mapping[str, Latency]
    detector: DetectorQuality
    clocks: Mapping[str, ClockQuality]
    robot: RobotQuality
    bodies: BodyQuality
    notices: tuple[Notice, ...]
    cost: Mapping[str, float]

    @property
    def robot_missed(self) -> int:
        """Number of steps that the robot did not perform, over all iterations."""
        return sum(iteration.robot_missed for iteration in self.iterations)

    def as_dict(self) -> dict[str, object]:
        """Content of session.json: plain data, with None for NaN."""
        content: dict[str, object] = {
            "schema": SCHEMA,
            **{key: self.config[key] for key in CONFIG_KEYS},
            "config": self.config,
            "versions": dict(self.versions),
            "iterations": [_iteration_dict(iteration) for iteration in self.iterations],
            **{name: getattr(self, name) for name in INDEX_KEYS},
            "ta_s": list(self.ta_s),
            "net_latency_s": {kind: dataclasses.asdict(value) for kind, value in self.net_latency_s.items()},
            "detector": dataclasses.asdict(self.detector),
            "clocks": {sensor: dataclasses.asdict(value) for sensor, value in self.clocks.items()},
            "robot": {**dataclasses.asdict(self.robot), "missed": self.robot_missed},
            **dataclasses.asdict(self.bodies),
            "notices": [dataclasses.asdict(notice) for notice in self.notices],
            "cost": dict(self.cost),
        }

        plain = without_nan(content)
        assert isinstance(plain, dict)
        return plain


def measures(log: SessionLog) -> Measures:
    """Compute every measure of a session.

    Args:
        log: the session; a log of a session that was cut short is allowed.

    Raises:
        ConfigError: the log's configuration is not valid in this version.
    """
    config = from_plain(log.config)
    table = timetable(config)

    # Logged events are what the server knew.
    logged = logged_events(log)
    true_dancers, true_robot = true_events(log, table)
    rows = group_metrics(logged, config, table, log.followed)
    true_rows = group_metrics([*true_dancers, *true_robot], config, table, log.followed)
    iterations = tuple(_measure_iteration(row, true_row, logged) for row, true_row in zip(rows, true_rows, strict=True))

    ta_s = _finite_ta(rows)
    sent_s = sent_times(log.events, log.device_events, mean_delay_s(config.network))
    return Measures(
        config=log.config,
        versions=log.versions,
        iterations=iterations,
        gsi=_mean([row.gsi for row in iterations]),
        gsi_full_edges=_mean([row.gsi_full_edges for row in iterations]),
        gsi_truth=_mean([row.gsi_truth for row in iterations]),
        ta_s=tuple(ta_s),
        ta_mean_s=_mean(ta_s),
        ta_truth_mean_s=_mean(_finite_ta(true_rows)),
        late_mean_s=_mean(np.concatenate([_finite(row.late_s) for row in rows])),
        net_latency_s={kind: _latency(values) for kind, values in net_latencies(rows, table, log.decisions).items()},
        detector=detector_quality(log.events, true_dancers),
        clocks=clock_quality(clock_errors(log.events, sent_s)),
        robot=robot_quality(log.commands, log.robot_events, log.odometry, config, table),
        bodies=body_quality(log.truth),
        notices=log.notices,
        cost=log.cost,
    )


def logged_events(log: SessionLog) -> list[AgentEvent]:
    """Regular events of the dancers as the server logged them, then the robot's events."""
    dancers = [
        AgentEvent(event.iteration, event.person, event.kind, event.t_s) for event in log.events if not event.early
    ]
    return [*dancers, *log.robot_events]


def true_events(log: SessionLog, table: Timetable) -> tuple[list[AgentEvent], list[AgentEvent]]:
    """True regular events of the dancers, and those of the robot, each in order of time.

    They come from the ground truth. In the event-level world, which has no bodies, the dancers' plans and the robot's
    logged events are the truth.

    Args:
        log: the session.
        table: its timetable.
    """
    dancers = dancer_events(log.truth, log.cues, table) if log.truth else planned_events(log.cues)
    robot = robot_events(log.odometry, table) if log.odometry else list(log.robot_events)
    return dancers, robot


def planned_events(cues: Sequence[Cue]) -> list[AgentEvent]:
    """Events of the dancers as they planned them, in order of time."""
    events = [AgentEvent(cue.iteration, cue.dancer, kind, t_s) for cue in cues for kind, t_s in cue.events()]
    return sorted(events, key=lambda event: (event.t_s, event.agent))


def _measure_iteration(
    row: GroupSynchronyRow, true_row: GroupSynchronyRow, logged: Sequence[AgentEvent]
) -> IterationMeasures:
    """Measures of one iteration, from its logged and true events."""
    agents = [event.agent for event in logged if event.iteration == row.iteration]
    robot_count = agents.count(ROBOT)
    has_robot = len(row.ta_s) > 0
    return IterationMeasures(
        index=row.iteration,
        gsi=row.gsi,
        gsi_full_edges=row.gsi_full_edges,
        # Without any true event, as in a real laboratory, there is no such figure.
        gsi_truth=true_row.gsi_full_edges if np.isfinite(true_row.steps_s).any() else float("nan"),
        msp=row.msp,
        followed=row.followed,
        late_mean_s=_mean(_finite(row.late_s)),
        ta_mean_s=_mean(_finite_ta([row])),
        human_events=len(agents) - robot_count,
        robot_events=robot_count,
        robot_missed=int(np.isnan(row.steps_s[-1]).sum()) if has_robot else 0,
    )


def _latency(values_s: Array) -> Latency:
    """Mean, standard deviation and number of net latencies."""
    return Latency(float(values_s.mean()), float(values_s.std()), len(values_s))


def _iteration_dict(iteration: IterationMeasures) -> dict[str, object]:
    """Entry of an iteration in session.json, which groups the numbers of events."""
    plain = dataclasses.asdict(iteration)
    events = {"humans": plain.pop("human_events"), "robot": plain.pop("robot_events")}
    missed = plain.pop("robot_missed")
    return {**plain, "events": events, "robot_missed": missed}


def _finite_ta(rows: Sequence[GroupSynchronyRow]) -> list[float]:
    """Defined values of timing appropriateness, in order [s]."""
    return [float(value) for row in rows for value in _finite(row.ta_s)]


def _finite(values: Array) -> Array:
    """The values that are finite."""
    return values[np.isfinite(values)]


def _mean(values: Sequence[float] | Array) -> float:
    """Mean; NaN without values."""
    return float(np.mean(values)) if len(values) else float("nan")
