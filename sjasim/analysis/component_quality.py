"""Quality of single components in one session: detectors, clock synchronisation, robot, bodies."""

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
from .event_matching import match_times

MATCH_WITHIN_S = 0.4
"""Largest distance between a logged event and the true event that it reports [s]."""

ARRIVAL_WITHIN_S = 0.5
"""Largest difference between an event's arrival and a device event's expected arrival, if both are the same event [s].

Arrivals are on the server's clock alone, so that clock errors play no part in the matching.
"""

EXECUTION_WITHIN_S = 1.0
"""Time in which the robot's event must follow a command for the command to count as executed [s]."""


@dataclass(frozen=True, slots=True)
class DetectorQuality:
    """Logged against true events, matched one to one within `MATCH_WITHIN_S`.

    Attributes:
        recall: share of the visible true events that were logged, ``detected_visible`` / ``visible``; NaN without any.
            A stop is visible only if its start was, see `ground_truth_events.dancer_events`.
        recall_all: share of all true events that were logged, ``detected`` / ``true``; NaN without any.
        precision: share of the logged events that are true, ``detected`` / ``logged``; NaN without any.
        timing_p95_s: 95th percentile of |logged - true time| [s].
        timing_bias_s: mean of logged - true time [s].
        detected_visible: number of visible true events that were logged.
        visible: number of visible true events.
        detected: number of true events that were logged.
        true: number of true events.
        logged: number of logged regular events.
    """

    recall: float
    recall_all: float
    precision: float
    timing_p95_s: float
    timing_bias_s: float
    detected_visible: int
    visible: int
    detected: int
    true: int
    logged: int


@dataclass(frozen=True, slots=True)
class ClockQuality:
    """Errors of one sensor's events in session time: the server's time of an event minus the true time of sending.

    Attributes:
        p95_s: 95th percentile of the absolute error [s].
        bias_s: mean error [s]; a delay that differs between the two directions of the link causes one.
        n: number of events.
    """

    p95_s: float
    bias_s: float
    n: int


@dataclass(frozen=True, slots=True)
class RobotQuality:
    """How the robot executed its commands.

    Attributes:
        commands: number of different commands.
        executed: share of them whose event followed within `EXECUTION_WITHIN_S`; NaN without commands.
        end_distance_m: true distance from its slot at the end [m]; NaN without a robot.
        end_heading_rad: true heading error at the end, -pi to pi [rad]; NaN without a robot.
    """

    commands: int
    executed: float
    end_distance_m: float
    end_heading_rad: float


@dataclass(frozen=True, slots=True)
class BodyQuality:
    """How far dancers stand on their own feet rather than by their balance support.

    Attributes:
        tether_rms_n: root mean square of the balance support's horizontal force, over all dancers [N].
        feet_load_share: mean load under the feet over the weight, of the dancer with the lowest one.
        falls: number of falls.
    """

    tether_rms_n: float
    feet_load_share: float
    falls: int


def detector_quality(logged: Sequence[Event], true: Sequence[AgentEvent]) -> DetectorQuality:
    """Compare the dancers' logged events with the true ones; early events do not count.

    Args:
        logged: events as methods received them.
        true: from `ground_truth_events.dancer_events`.
    """
    regular = [event for event in logged if not event.early]
    errors: list[Array] = []
    detected_visible = 0

    # An event matches only one of the same dancer and kind.
    for agent, kind in sorted({(event.agent, event.kind) for event in true}):
        true_events = [event for event in true if (event.agent, event.kind) == (agent, kind)]
        logged_s = np.array([event.t_s for event in regular if (event.person, event.kind) == (agent, kind)])
        rows, columns = match_times(logged_s, np.array([event.t_s for event in true_events]), MATCH_WITHIN_S)
        errors.append(logged_s[rows] - np.array([true_events[column].t_s for column in columns]))
        detected_visible += sum(true_events[column].visible for column in columns)

    error = np.concatenate(errors) if errors else np.zeros(0)
    visible = sum(event.visible for event in true)
    return DetectorQuality(
        recall=_share(detected_visible, visible),
        recall_all=_share(len(error), len(true)),
        precision=_share(len(error), len(regular)),
        timing_p95_s=_p95(error),
        timing_bias_s=_mean(error),
        detected_visible=detected_visible,
        visible=visible,
        detected=len(error),
        true=len(true),
        logged=len(regular),
    )


def mean_delay_s(network: NetworkConfig) -> float:
    """Mean time from sending an event to its arrival at the server [s]."""
    return network.latency_s + network.jitter_s + network.uplink_asymmetry_s


def sent_times(events: Sequence[Event], device_events: Sequence[tuple[DeviceEvent, float]], delay_s: float) -> Array:
    """(N,) true time at which a client sent each event [s]; NaN if no device event matches.

    Events are matched by their arrivals, which do not depend on the clients' clocks.

    Args:
        events: as the server logged them.
        device_events: device events, each with the true time at which it was sent [s].
        delay_s: mean time from sending to arrival [s].
    """
    found = np.full(len(events), np.nan)
    event_sources = [_source(event) for event in events]
    device_sources = [_source(device) for device, _ in device_events]

    for source in sorted(set(event_sources)):
        of_source = np.array([row for row, other in enumerate(event_sources) if other == source])
        sent_s = np.array(
            [t_s for (_, t_s), other in zip(device_events, device_sources, strict=True) if other == source]
        )
        expected_sent_s = np.array([events[row].t_arrival_s - delay_s for row in of_source])
        rows, columns = match_times(expected_sent_s, sent_s, ARRIVAL_WITHIN_S)
        found[of_source[rows]] = sent_s[columns]
    return found


def clock_errors(events: Sequence[Event], sent_s: Array) -> dict[str, tuple[Array, Array]]:
    """Sensor -> (M,) true times of sending in order, and (M,) clock errors of its events [s].

    Args:
        events: with the server's estimate of their time.
        sent_s: (N,) from `sent_times`; events without one are left out.
    """
    found = {}
    for sensor in sorted({event.sensor for event in events}):
        pairs = [
            (t_s, event.t_s - t_s)
            for event, t_s in zip(events, sent_s.tolist(), strict=True)
            if event.sensor == sensor and np.isfinite(t_s)
        ]
        table = np.array(sorted(pairs)).reshape(-1, 2)
        found[sensor] = (table[:, 0], table[:, 1])
    return found


def clock_quality(errors: Mapping[str, tuple[Array, Array]]) -> dict[str, ClockQuality]:
    """Summarise the clock errors of every sensor, from `clock_errors`."""
    return {sensor: ClockQuality(_p95(error), _mean(error), len(error)) for sensor, (_, error) in errors.items()}


def robot_quality(
    commands: Sequence[MoveCommand],
    events: Sequence[AgentEvent],
    odometry: Mapping[str, Array],
    config: SessionConfig,
    timetable: Timetable,
) -> RobotQuality:
    """Compare the robot's commands with its events, and its true pose at the end with its slot.

    Args:
        commands: commands to the robot.
        events: the robot's logged events.
        odometry: columns of the odometry table; empty without a robot.
        config: configuration of the session.
        timetable: headings of the iterations.
    """
    delays = execution_delays(commands, events, timetable)
    executed = int(np.isfinite([delay_s for _, delay_s in delays]).sum())

    distance_m = float("nan")
    heading_error_rad = float("nan")
    if odometry and len(odometry["t_s"]):
        slot = layout(config).robot
        distance_m = float(np.hypot(odometry["true_x_m"][-1] - slot[0], odometry["true_y_m"][-1] - slot[1]))
        # After the last iteration's turn, the group faces the heading of an iteration more.
        wanted_rad = timetable.heading_rad(timetable.last + 1)
        turned_rad = odometry["true_heading_rad"][-1] - wanted_rad
        heading_error_rad = float(np.remainder(turned_rad + np.pi, 2 * np.pi) - np.pi)

    return RobotQuality(len(delays), _share(executed, len(delays)), distance_m, heading_error_rad)


def execution_delays(
    commands: Sequence[MoveCommand], events: Sequence[AgentEvent], timetable: Timetable
) -> list[tuple[Kind, float]]:
    """Kind and delay of the robot's event after each command [s]; NaN if it did not follow in `EXECUTION_WITHIN_S`.

    A repeated command counts once, at its first transmission.

    Args:
        commands: commands to the robot.
        events: the robot's logged events.
        timetable: gives the steps that the commands are for.
    """
    # In reverse, so that the first transmission of a number replaces its repetitions.
    first_sent = list({command.number: command for command in reversed(commands)}.values())
    steps = timetable.choreography.steps()

    delays: list[tuple[Kind, float]] = []
    for kind in Kind:
        sent_s = np.array([item.t_start_s for item in first_sent if _robot_kind(steps[item.ordinal].kind) is kind])
        event_s = np.array([event.t_s for event in events if event.kind is kind])

        # Events up to the limit after the command match: half of it to either side of a time halfway.
        rows, columns = match_times(sent_s + EXECUTION_WITHIN_S / 2, event_s, EXECUTION_WITHIN_S / 2)
        delay_s = np.full(len(sent_s), np.nan)
        delay_s[rows] = event_s[columns] - sent_s[rows]
        delays += [(kind, value) for value in delay_s.tolist()]
    return delays


def body_quality(truth: Mapping[str, NDArray[np.generic]]) -> BodyQuality:
    """Summarise the dancers' balance support, load and falls; NaN and no falls without ground truth.

    Args:
        truth: columns of the ground-truth table.
    """
    if not truth or not len(truth["t_s"]):
        return BodyQuality(float("nan"), float("nan"), 0)

    columns = {name: np.asarray(column, dtype=np.float64) for name, column in truth.items()}
    squared_force = columns["tether_x_n"] ** 2 + columns["tether_y_n"] ** 2

    load_shares = []
    falls = 0
    for index in np.unique(columns["dancer"]):
        of_dancer = columns["dancer"] == index
        load_shares.append(columns["load_n"][of_dancer].sum() / columns["weight_n"][of_dancer].sum())
        # The column is 1 from a fall on; each rise of it is one fall.
        falls += int((np.diff(columns["fallen"][of_dancer], prepend=0.0) > 0).sum())

    return BodyQuality(float(np.sqrt(squared_force.mean())), float(min(load_shares)), falls)


def _source(event: Event | DeviceEvent) -> tuple[str, str, bool]:
    """Sensor, start/stop/clap/turn, and whether the event is early.

    The direction is left out: for a sensor that sees dancers from behind, the server exchanges forward and backward.
    """
    return event.sensor, event.kind.value.partition("_")[0], event.early


def _robot_kind(kind: Kind) -> Kind:
    """The robot's kind for a step of the dancers: it turns where they clap."""
    return Kind.TURN if kind is Kind.CLAP else kind


def _share(part: int, whole: int) -> float:
    """A share; NaN of nothing."""
    return part / whole if whole else float("nan")


def _mean(values: Array) -> float:
    """Mean; NaN without values."""
    return float(values.mean()) if len(values) else float("nan")


def _p95(values: Array) -> float:
    """95th percentile of the absolute values; NaN without values."""
    return float(np.percentile(np.abs(values), 95)) if len(values) else float("nan")
