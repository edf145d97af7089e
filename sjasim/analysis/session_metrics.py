"""Every figure of a session, from its log alone, so that session.json can be recomputed from the tables beside it."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..choreography.timetable import Timetable, timetable
from ..config.toml_file import from_plain
from ..core import ROBOT
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

SCHEMA = 2
"""Version of session.json."""


@dataclass(frozen=True, slots=True)
class IterationMeasures:
    """One danced iteration.

    Attributes:
        index: from 1.
        gsi: group synchronisation index from logged times, under the paper's edges.
        gsi_full_edges: the same under all edges.
        gsi_truth: from true onsets, all edges; what detection delay hides is the difference to the one above.
        msp: the most synchronous person.
        ta_mean_s: mean timing appropriateness [s]; NaN without a robot.
        human_events: logged regular events of the dancers.
        robot_events: the robot's events.
        robot_missed: steps that the robot did not perform.
    """

    index: int
    gsi: float
    gsi_full_edges: float
    gsi_truth: float
    msp: str
    ta_mean_s: float
    human_events: int
    robot_events: int
    robot_missed: int


@dataclass(frozen=True, slots=True)
class Latency:
    """Net latency of one event kind: robot's event minus the followed dancer's logged one."""

    mean: float
    sd: float
    n: int


@dataclass(frozen=True, slots=True)
class Measures:
    """All figures of a session; a figure that does not apply is NaN, and null in session.json.

    Attributes:
        config: the session's full configuration as plain data.
        versions: versions of the packages it ran with.
        iterations: one entry per danced iteration.
        gsi: mean over the iterations, paper's edges, logged times.
        gsi_full_edges: the same, all edges.
        gsi_truth: the same, true onsets.
        ta_s: every timing appropriateness value, in order of iteration and step [s].
        ta_mean_s: their mean.
        ta_truth_mean_s: mean from true onsets of dancers and robot.
        net_latency_s: by event kind, where the robot follows one dancer.
        detector: logged against true events.
        clocks: clock error by sensor.
        robot: commands executed, where it ended.
        bodies: tether, feet, falls.
        notices: what went wrong.
        cost: ``sim_s``, ``cpu_s``, ``wall_s``.
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
    net_latency_s: Mapping[str, Latency]
    detector: DetectorQuality
    clocks: Mapping[str, ClockQuality]
    robot: RobotQuality
    bodies: BodyQuality
    notices: tuple[Notice, ...]
    cost: Mapping[str, float]

    @property
    def robot_missed(self) -> int:
        """Steps that the robot did not perform, over all iterations."""
        return sum(row.robot_missed for row in self.iterations)

    def as_dict(self) -> dict[str, object]:
        """What session.json holds: plain data, NaN as None."""
        named = {key: self.config[key] for key in ("method", "seed", "fidelity", "sensing", "humans")}
        own = ("gsi", "gsi_full_edges", "gsi_truth", "ta_mean_s", "ta_truth_mean_s")
        body = dataclasses.asdict(self.bodies)
        result: dict[str, object] = {
            "schema": SCHEMA,
            **named,
            "config": self.config,
            "versions": dict(self.versions),
            "iterations": [_iteration_dict(row) for row in self.iterations],
            **{name: getattr(self, name) for name in own},
            "ta_s": list(self.ta_s),
            "net_latency_s": {kind: dataclasses.asdict(value) for kind, value in self.net_latency_s.items()},
            "detector": dataclasses.asdict(self.detector),
            "clocks": {sensor: dataclasses.asdict(value) for sensor, value in self.clocks.items()},
            "robot": {**dataclasses.asdict(self.robot), "missed": self.robot_missed},
            **body,
            "notices": [dataclasses.asdict(notice) for notice in self.notices],
            **{name: self.cost[name] for name in ("sim_s", "cpu_s", "wall_s") if name in self.cost},
        }
        plain = _without_nan(result)
        assert isinstance(plain, dict)
        return plain


def measures(log: SessionLog) -> Measures:
    """Measure a session.

    Raises:
        ConfigError: the log's configuration is not one of this version.
    """
    config = from_plain(log.config)
    table = timetable(config)
    logged = [
        AgentEvent(event.iteration, event.person, event.kind, event.t_s) for event in log.events if not event.early
    ]
    logged += log.robot_events
    onsets = dancer_events(log.truth, log.cues, table)
    rows = group_metrics(logged, config, table, log.followed)
    true_rows = group_metrics([*onsets, *robot_events(log.odometry, table)], config, table, log.followed)
    iterations = tuple(_iteration(row, true, logged, table) for row, true in zip(rows, true_rows, strict=True))
    ta_s = _finite(rows)
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
        ta_truth_mean_s=_mean(_finite(true_rows)),
        net_latency_s={
            kind: Latency(float(gaps.mean()), float(gaps.std()), len(gaps))
            for kind, gaps in net_latencies(rows, table).items()
        },
        detector=detector_quality(log.events, onsets),
        clocks=clock_quality(clock_errors(log.events, sent_s)),
        robot=robot_quality(log.commands, log.robot_events, log.odometry, config, table),
        bodies=body_quality(log.truth),
        notices=log.notices,
        cost=log.cost,
    )


def _iteration(
    row: GroupSynchronyRow, true: GroupSynchronyRow, logged: Sequence[AgentEvent], table: Timetable
) -> IterationMeasures:
    own = [event.agent for event in logged if event.iteration == row.iteration]
    robot = own.count(ROBOT)
    has_robot = len(row.ta_s) > 0
    return IterationMeasures(
        index=row.iteration,
        gsi=row.gsi,
        gsi_full_edges=row.gsi_full_edges,
        gsi_truth=true.gsi_full_edges,
        msp=row.msp,
        ta_mean_s=_mean(_finite([row])),
        human_events=len(own) - robot,
        robot_events=robot,
        robot_missed=int(np.isnan(row.steps_s[-1]).sum()) if has_robot else 0,
    )


def _iteration_dict(row: IterationMeasures) -> dict[str, object]:
    plain = dataclasses.asdict(row)
    events = {"humans": plain.pop("human_events"), "robot": plain.pop("robot_events")}
    missed = plain.pop("robot_missed")
    return {**plain, "events": events, "robot_missed": missed}


def _finite(rows: Sequence[GroupSynchronyRow]) -> list[float]:
    return [float(value) for row in rows for value in row.ta_s if np.isfinite(value)]


def _mean(values: Sequence[float]) -> float:
    return float(np.mean(values)) if len(values) else float("nan")


def _without_nan(value: object) -> object:
    if isinstance(value, float) and not math.isfinite(value):
        return None
    if isinstance(value, Mapping):
        return {key: _without_nan(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_without_nan(item) for item in value]
    return value
