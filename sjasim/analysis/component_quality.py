"""How well each part did its work: detectors, clocks, robot, bodies."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..choreography.layout import layout
from ..choreography.timetable import Timetable
from ..config import NetworkConfig, SessionConfig
from ..core import Array, DeviceEvent, Event, Kind, MoveCommand
from ..core.session_log import AgentEvent
from .event_matching import matched

WITHIN_S = 0.4
"""A logged and a true event this close may be the same one."""

ARRIVED_WITHIN_S = 0.5
"""An event that arrived this close to when a device event should have, by the network's mean delay, may be that one;
whatever the clocks showed."""

EXECUTED_S = 1.0
"""A command counts as executed if its robot event follows within this time."""


@dataclass(frozen=True, slots=True)
class DetectorQuality:
    """Logged against true events, matched one to one within `WITHIN_S`.

    Attributes:
        recall: share of the visible true events that were logged; NaN without any.
        precision: share of the logged events that are true; NaN without any.
        timing_p95_s: 95th percentile of |logged - true| [s].
        timing_bias_s: mean of logged - true [s].
        visible: number of visible true events.
        true: number of true events.
        logged: number of logged regular events.
    """

    recall: float
    precision: float
    timing_p95_s: float
    timing_bias_s: float
    visible: int
    true: int
    logged: int


@dataclass(frozen=True, slots=True)
class ClockQuality:
    """Error of one sensor's events in session time: the server's stamp minus the true time of stamping.

    Attributes:
        p95_s: 95th percentile of the absolute error [s].
        bias_s: mean error [s]; an asymmetric link shows here.
        n: number of events.
    """

    p95_s: float
    bias_s: float
    n: int


@dataclass(frozen=True, slots=True)
class RobotQuality:
    """What the robot made of its commands.

    Attributes:
        commands: number of different commands.
        executed: share of them whose event followed within `EXECUTED_S`; NaN without commands.
        end_distance_m: true distance from its slot at the end; NaN without a robot.
        end_heading_rad: true heading error at the end, -pi to pi.
    """

    commands: int
    executed: float
    end_distance_m: float
    end_heading_rad: float


@dataclass(frozen=True, slots=True)
class BodyQuality:
    """How far the dancers stand on their own feet.

    Attributes:
        tether_rms_n: root mean square of the tether's horizontal force, all dancers [N].
        feet_load_share: of the dancer who fares worst, the mean load under the feet over the weight.
        falls: number of falls.
    """

    tether_rms_n: float
    feet_load_share: float
    falls: int


def detector_quality(logged: Sequence[Event], true: Sequence[AgentEvent]) -> DetectorQuality:
    """Compare the events that methods were told of with what really happened; early events do not count."""
    regular = [event for event in logged if not event.early]
    gaps: list[Array] = []
    seen = 0
    for agent, kind in sorted({(event.agent, event.kind) for event in true}):
        really = [event for event in true if (event.agent, event.kind) == (agent, kind)]
        times = np.array([event.t_s for event in regular if (event.person, event.kind) == (agent, kind)])
        rows, columns = matched(times, np.array([event.t_s for event in really]), WITHIN_S)
        gaps.append(times[rows] - np.array([really[column].t_s for column in columns]))
        seen += sum(really[column].visible for column in columns)
    gap = np.concatenate(gaps) if gaps else np.zeros(0)
    visible = sum(event.visible for event in true)
    return DetectorQuality(
        recall=_share(seen, visible),
        precision=_share(len(gap), len(regular)),
        timing_p95_s=_p95(gap),
        timing_bias_s=_mean(gap),
        visible=visible,
        true=len(true),
        logged=len(regular),
    )


def mean_delay_s(network: NetworkConfig) -> float:
    """How long an event takes to the server on average [s]."""
    return network.latency_s + network.jitter_s + network.uplink_asymmetry_s


def sent_times(events: Sequence[Event], device_events: Sequence[tuple[DeviceEvent, float]], delay_s: float) -> Array:
    """(N,) true time at which a client sent what became each event [s]; NaN if it cannot be found.

    It is found by when the event arrived, which no clock has a part in.

    Args:
        events: as the server logged them.
        device_events: with the true time of their stamp, which is that of sending [s].
        delay_s: mean time that an event takes to the server [s].
    """
    found = np.full(len(events), np.nan)
    sources, origins = (
        [_source(event) for event in rows] for rows in (events, [device for device, _ in device_events])
    )
    for source in sorted(set(sources)):
        mine = np.array([row for row, other in enumerate(sources) if other == source])
        sent = np.array([t_s for (_, t_s), other in zip(device_events, origins, strict=True) if other == source])
        arrived = np.array([events[row].t_arrival_s - delay_s for row in mine])
        rows, columns = matched(arrived, sent, ARRIVED_WITHIN_S)
        found[mine[rows]] = sent[columns]
    return found


def _source(event: Event | DeviceEvent) -> tuple[str, str, bool]:
    """Sensor and sort of an event; a sensor that sees a back has forward and backward exchanged by the server."""
    return event.sensor, event.kind.value.partition("_")[0], event.early


def clock_errors(events: Sequence[Event], sent_s: Array) -> dict[str, tuple[Array, Array]]:
    """Clock error of the events, by sensor: true times of stamping (M,) [s] in order, and errors (M,) [s].

    Args:
        events: with the server's estimate of their time.
        sent_s: (N,) from `sent_times`.
    """
    found = {}
    for sensor in sorted({event.sensor for event in events}):
        pairs = [(t_s, event.t_s - t_s) for event, t_s in zip(events, sent_s.tolist(), strict=True)
                 if event.sensor == sensor and np.isfinite(t_s)]  # fmt: skip
        both = np.array(sorted(pairs)).reshape(-1, 2)
        found[sensor] = (both[:, 0], both[:, 1])
    return found


def clock_quality(errors: Mapping[str, tuple[Array, Array]]) -> dict[str, ClockQuality]:
    """Judge every sensor's clock by the errors of its events."""
    return {sensor: ClockQuality(_p95(error), _mean(error), len(error)) for sensor, (_, error) in errors.items()}


def robot_quality(
    commands: Sequence[MoveCommand],
    events: Sequence[AgentEvent],
    odometry: Mapping[str, Array],
    config: SessionConfig,
    timetable: Timetable,
) -> RobotQuality:
    """Judge the robot by its commands, its own events and its true pose at the end."""
    gaps = robot_gaps(commands, events, timetable)
    executed = int(np.isfinite([gap for _, gap in gaps]).sum())
    distance, turned = float("nan"), float("nan")
    if odometry and len(odometry["t_s"]):
        slot = layout(config).robot
        distance = float(np.hypot(odometry["true_x_m"][-1] - slot[0], odometry["true_y_m"][-1] - slot[1]))
        wanted_rad = timetable.heading_rad(timetable.last + 1)
        turned = float(np.remainder(odometry["true_heading_rad"][-1] - wanted_rad + np.pi, 2 * np.pi) - np.pi)
    return RobotQuality(len(gaps), _share(executed, len(gaps)), distance, turned)


def robot_gaps(
    commands: Sequence[MoveCommand], events: Sequence[AgentEvent], timetable: Timetable
) -> list[tuple[Kind, float]]:
    """Of every command its kind and how long after it the robot's event came [s]; NaN if not within `EXECUTED_S`."""
    orders = list({command.number: command for command in reversed(commands)}.values())
    steps = timetable.choreography.steps()
    gaps: list[tuple[Kind, float]] = []
    for kind in Kind:
        wanted = np.array([order.t_start_s for order in orders if _robot_kind(steps[order.ordinal].kind) is kind])
        times = np.array([event.t_s for event in events if event.kind is kind])
        delay = np.full(len(wanted), np.nan)
        rows, columns = matched(wanted + EXECUTED_S / 2, times, EXECUTED_S / 2)
        delay[rows] = times[columns] - wanted[rows]
        gaps += [(kind, gap) for gap in delay.tolist()]
    return gaps


def body_quality(truth: Mapping[str, NDArray[np.generic]]) -> BodyQuality:
    """Judge the dancers' bodies by tether, feet and falls."""
    if not truth or not len(truth["t_s"]):
        return BodyQuality(float("nan"), float("nan"), 0)
    columns = {name: np.asarray(column, dtype=np.float64) for name, column in truth.items()}
    force = columns["tether_x_n"] ** 2 + columns["tether_y_n"] ** 2
    shares, falls = [], 0
    for index in np.unique(columns["dancer"]):
        mine = columns["dancer"] == index
        shares.append(columns["load_n"][mine].sum() / columns["weight_n"][mine].sum())
        falls += int((np.diff(columns["fallen"][mine], prepend=0.0) > 0).sum())
    return BodyQuality(float(np.sqrt(force.mean())), float(min(shares)), falls)


def _robot_kind(kind: Kind) -> Kind:
    return Kind.TURN if kind is Kind.CLAP else kind


def _share(part: int, whole: int) -> float:
    return part / whole if whole else float("nan")


def _mean(values: Array) -> float:
    return float(values.mean()) if len(values) else float("nan")


def _p95(values: Array) -> float:
    return float(np.percentile(np.abs(values), 95)) if len(values) else float("nan")
