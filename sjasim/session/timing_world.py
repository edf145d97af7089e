"""The event-level world: dancers, sensors and robot as events in time, without bodies, images or wheels.

A session in this world takes milliseconds, so that studies of thousands of groups are possible. The dancers' cues come
from the same human timing models as in physics. What sensors and robot make of them is drawn from distributions that
were measured in physics, see `timing_statistics`. Everything else of a session is the same code: links, server,
methods, dispatcher, measures.

Not simulated: positions, occlusion as it follows from them, falls, clock errors, and what depends on the robot's pose.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..assets.names import CARDINALS
from ..choreography.layout import Layout, Mount
from ..choreography.timetable import Timetable
from ..config import RobotConfig, SessionConfig
from ..core import (
    ROBOT,
    Array,
    ClientStatus,
    Cue,
    DeviceEvent,
    Kind,
    Move,
    MoveCommand,
    PersonStatus,
    SkeletonFrame,
    SyncReply,
)
from ..core.clock import stream
from ..core.errors import ConfigError
from ..core.registry import register
from ..core.session_log import AgentEvent, Notice
from .cue_scheduler import CueScheduler
from .timing_statistics import DelayStatistics, timing_statistics
from .world import DownlinkMessage, UplinkMessage

SIMULATED_FAULTS = ("dancer_late", "dancer_stops", "dead_robot", "robot_blocked")
"""Kinds of faults that have an effect without bodies and sensors."""

Statistics = Mapping[Kind, DelayStatistics]
"""Statistics of every kind of event."""

WITHOUT_EFFECT = {
    name: getattr(SessionConfig(), name)
    for name in ("body", "physics", "sensors", "joint_noise", "detectors", "clocks")
}
"""Table of the configuration that only bodies and sensors read -> its default."""

STARTS = {Kind.STOP_FORWARD: Kind.START_FORWARD, Kind.STOP_BACKWARD: Kind.START_BACKWARD}
"""Stop of a move -> its start."""

ROBOT_EVENTS = {Move.FORWARD: Kind.START_FORWARD, Move.BACKWARD: Kind.START_BACKWARD, Move.TURN: Kind.TURN}
"""Move that a command starts -> the robot's event."""

ROBOT_STOPS = {Kind.START_FORWARD: Kind.STOP_FORWARD, Kind.START_BACKWARD: Kind.STOP_BACKWARD}
"""Start of the robot's present move -> the event with which it ends."""

MIN_ROBOT_INTERVAL_S = 0.1
"""Shortest time between two events of the robot [s]; the odometry confirms each with several samples (assumed)."""


@register("world", "timing")
class TimingWorld:
    """Dancers, sensors and robot as events in time; implements the protocol `World`.

    Args:
        config: the session.
        timetable: the dance on the session's clock.
        layout: places of the dancers, which sensors report.
        robot: whether there is a robot.

    Raises:
        ConfigError: a fault or an option has no effect without bodies and sensors, or the statistics cannot be read.

    Attributes:
        continuous: False; see `World`.
        active: name of the sensor that reports the events; the session sets it.
        end_s: session time at which the dance is over [s].
        cues: what the dancers planned so far.
        notices: what went wrong so far.
        watchers: not called, because there are no frames.
    """

    continuous = False

    def __init__(self, config: SessionConfig, timetable: Timetable, layout: Layout, *, robot: bool) -> None:
        check_supported(config)
        self._timetable = timetable
        self._layout = layout
        self.end_s = timetable.end_s() + config.dance.tail_s
        self.active = CARDINALS[0]
        self.watchers: list[Callable[[float], None]] = []
        self._robot_events: list[AgentEvent] = []
        """What the robot does, some of it in the future: an event follows its command by a known delay."""
        self.recorder = NoGroundTruth(config.dancers)
        self.time_s = 0.0

        statistics = timing_statistics(config.timing.statistics, config.sensing, config.layout)
        self._events = EventSampler(statistics.regular, statistics.early, stream(config.seed, "timing", "sensors"))
        self._robot = TimedRobot(statistics.robot, config, stream(config.seed, "timing", "robot"))

        self._scheduler = CueScheduler(config, timetable, robot=robot)
        self.cues: list[Cue] = self._scheduler.cues
        self.notices: list[Notice] = self._scheduler.notices

        self._queue: list[tuple[float, int, Callable[..., UplinkMessage | None], tuple[object, ...]]] = []
        """What happens next: session time [s], sequence number, function and its arguments."""
        self._sequence = 0
        self._add(0.0, self._decide)
        self._add_status_reports()
        self._add_false_events(config.dancers)

    @property
    def robot_events(self) -> list[AgentEvent]:
        """What the robot has done so far."""
        return [event for event in self._robot_events if event.t_s <= self.time_s]

    def next_instant_s(self, t_s: float) -> float:
        """Return ``t_s``: this world has no ticks; see `World`."""
        return t_s

    def deliver(self, now_s: float, t_arrival_s: float, message: DownlinkMessage) -> SyncReply | None:
        """Hand a message to the device that it is for; sensor clients ignore orders and requests; see `World`."""
        if isinstance(message, MoveCommand):
            for t_s, kind in self._robot.receive(t_arrival_s, message):
                self._robot_events.append(AgentEvent(self._timetable.iteration_at(t_s), ROBOT, kind, t_s))
        return None

    def latest_frame(self, sensor: str) -> SkeletonFrame | None:
        """Return None: there are no frames; see `World`."""
        return None

    def advance(self, until_s: float) -> list[UplinkMessage]:
        """Let happen what is due now, then go on to the next time at which something is; see `World`."""
        now = self.time_s
        if until_s <= now:
            return []

        outbox: list[UplinkMessage] = []
        while self._queue and self._queue[0][0] <= now:
            _, _, function, arguments = heapq.heappop(self._queue)
            message = function(*arguments)
            if message is not None:
                outbox.append(message)

        next_s = self._queue[0][0] if self._queue else math.inf
        self.time_s = min(next_s, until_s)
        return outbox

    def _add(self, t_s: float, function: Callable[..., UplinkMessage | None], *arguments: object) -> None:
        """Let a function be called at a session time; what it returns is sent to the server."""
        heapq.heappush(self._queue, (t_s, self._sequence, function, arguments))
        self._sequence += 1

    def _add_status_reports(self) -> None:
        """Add one report of the sensor that each iteration faces, which tells the server who stands where."""
        table = self._timetable
        for iteration in range(table.first, table.last + 1):
            heading_rad = table.heading_rad(iteration)
            persons = tuple(
                PersonStatus(index, float(x_m), float(y_m), heading_rad, 1.0, 1.0)
                for index, (x_m, y_m) in enumerate(self._layout.dancers)
            )
            sensor = _faced_sensor(self._layout, heading_rad)
            t_s = 0.0 if iteration == table.first else table.start_s(iteration)
            self._add(t_s, self._report_status, ClientStatus(sensor, t_s, persons))

    @staticmethod
    def _report_status(status: ClientStatus) -> UplinkMessage:
        return status

    def _add_false_events(self, dancers: int) -> None:
        """Add the events that detectors report without a cause."""
        for dancer in range(dancers):
            for t_s, kind, early in self._events.false_events(self._timetable.end_s()):
                self._add(t_s, self._detect, t_s, dancer, kind, early)

    def _decide(self) -> None:
        """Ask the dancers for their next cues, and add the events that the sensors detect of them."""
        for dancer, cues in enumerate(self._scheduler.decide(self.time_s, self.robot_events)):
            for t_s, kind, early in self._events.detected(dancer, cues):
                self._add(t_s, self._detect, t_s, dancer, kind, early)
        if self._scheduler.due_s < math.inf:
            self._add(self._scheduler.due_s, self._decide)

    def _detect(self, t_s: float, dancer: int, kind: Kind, early: bool) -> UplinkMessage:
        """The report of the sensor that is active now."""
        return DeviceEvent(self.active, dancer, kind, t_s, early)


def check_supported(config: SessionConfig) -> None:
    """Check that everything in a configuration has an effect without bodies and sensors.

    Raises:
        ConfigError: an option or a fault has none.
    """
    for name, default in WITHOUT_EFFECT.items():
        if getattr(config, name) != default:
            allowed = f"the default with fidelity timing, in which {name} has no effect; or fidelity physics"
            raise ConfigError(name, getattr(config, name), allowed)
    if replace(config.robot, command_latency_s=RobotConfig().command_latency_s) != RobotConfig():
        allowed = "the default with fidelity timing, but for robot.command_latency_s; or fidelity physics"
        raise ConfigError("robot", config.robot, allowed)

    for index, fault in enumerate(config.faults):
        if fault.kind not in SIMULATED_FAULTS:
            allowed = f"with fidelity timing one of {', '.join(SIMULATED_FAULTS)}; others need fidelity physics"
            raise ConfigError(f"faults[{index}].kind", fault.kind, allowed)


class EventSampler:
    """Draws what the sensors detect of the dancers' cues.

    Args:
        regular: kind -> statistics of regular events.
        early: kind -> statistics of early events.
        rng: random stream of the sensors.
    """

    def __init__(self, regular: Statistics, early: Statistics, rng: np.random.Generator) -> None:
        self._regular = regular
        self._early = early
        self._rng = rng
        self._known_moves: set[tuple[int, Kind]] = set()
        """(dancer, stop) of the moves that were detected in full."""

    def detected(self, dancer: int, cues: Sequence[Cue]) -> list[tuple[float, Kind, bool]]:
        """Session time, kind and earliness of the events that are detected of one dancer's cues.

        As in the detectors, a stop whose start was missed is missed as well, and an early stop needs an earlier move of
        the same direction that was detected in full.
        """
        planned = [(kind, t_s) for cue in cues for kind, t_s in cue.events()]
        # Drawn together, and also for what is missed, so that one miss leaves the other draws as they are.
        draws = self._rng.random((len(planned), 4)).tolist()

        found: list[tuple[float, Kind, bool]] = []
        start_missed = False
        for (kind, t_s), (miss, share, early_miss, early_share) in zip(planned, draws, strict=True):
            regular = self._regular[kind]
            is_stop = kind in STARTS
            missed_start = is_stop and start_missed
            missed = miss < regular.missed or missed_start
            start_missed = not is_stop and missed
            if not missed:
                found.append((t_s + regular.delay_at(share), kind, False))

            announced = self._early.get(kind)
            is_possible = not is_stop or (not missed_start and (dancer, kind) in self._known_moves)
            if announced is not None and is_possible and early_miss >= announced.missed:
                found.append((t_s + announced.delay_at(early_share), kind, True))
            if is_stop and not missed:
                self._known_moves.add((dancer, kind))
        return found

    def false_events(self, until_s: float) -> list[tuple[float, Kind, bool]]:
        """Session time, kind and earliness of the false events of one dancer in a session."""
        found: list[tuple[float, Kind, bool]] = []
        for early, table in ((False, self._regular), (True, self._early)):
            for kind, statistics in table.items():
                count = self._rng.poisson(statistics.false_per_minute * until_s / 60.0)
                found += [(float(t_s), kind, early) for t_s in self._rng.uniform(0.0, until_s, count)]
        return found


class TimedRobot:
    """Draws when the robot's events follow its commands.

    Args:
        statistics: kind -> statistics of execution.
        config: the session, of which the faults and the robot's latency are used.
        rng: random stream of the robot.
    """

    def __init__(self, statistics: Statistics, config: SessionConfig, rng: np.random.Generator) -> None:
        self._statistics = statistics
        self._rng = rng
        # The delays were measured with the default latency.
        self._added_latency_s = config.robot.command_latency_s - RobotConfig().command_latency_s
        faults = [fault.t_s for fault in config.faults if fault.kind in ("dead_robot", "robot_blocked")]
        self._fails_from_s = min(faults, default=math.inf)

        self._last_number = 0
        self._moving: Kind | None = None
        """Start of the present move; None at rest."""
        self._last_event_s = -math.inf

    def receive(self, t_s: float, command: MoveCommand) -> list[tuple[float, Kind]]:
        """Session times and kinds of the robot's events that follow from a command.

        Args:
            t_s: session time at which the command arrives [s].
            command: the command; a repetition of one that has arrived changes nothing.
        """
        if command.number <= self._last_number or t_s >= self._fails_from_s:
            return []
        self._last_number = command.number

        start = ROBOT_EVENTS.get(command.move)
        ended = ROBOT_STOPS.get(self._moving) if self._moving is not None and start is not self._moving else None
        events: list[tuple[float, Kind]] = []
        if ended is not None:
            events += self._execute(t_s, ended)
        if start is not None and start is not self._moving:
            events += self._execute(t_s, start)
        self._moving = start if start in ROBOT_STOPS else (None if ended or start else self._moving)
        return events

    def _execute(self, t_s: float, kind: Kind) -> list[tuple[float, Kind]]:
        """The event of a kind after a command, or none if it is not executed."""
        statistics = self._statistics[kind]
        miss, share = self._rng.random(2).tolist()
        if miss < statistics.missed:
            return []

        # The robot's events keep their order, however close their commands are.
        event_s = max(
            t_s + self._added_latency_s + statistics.delay_at(share), self._last_event_s + MIN_ROBOT_INTERVAL_S
        )
        self._last_event_s = event_s
        return [(event_s, kind)]


class NoGroundTruth:
    """A recorder without ground truth, because there are no bodies; implements the protocol `Recorder`.

    Args:
        dancers: number of dancers.
    """

    def __init__(self, dancers: int) -> None:
        self._dancers = dancers

    def truth(self) -> dict[str, NDArray[np.generic]]:
        """Return no columns."""
        return {}

    def odometry(self) -> dict[str, Array]:
        """Return no columns."""
        return {}

    def joints(self) -> NDArray[np.float32]:
        """(0, D, 25, 3) no frames."""
        return np.zeros((0, self._dancers, 25, 3), dtype=np.float32)

    def skeletons(self) -> NDArray[np.float32]:
        """(0, D, 25, 4) no frames."""
        return np.zeros((0, self._dancers, 25, 4), dtype=np.float32)


def _faced_sensor(layout: Layout, heading_rad: float) -> str:
    """Name of the sensor towards which dancers with a heading look."""

    def towards(mount: Mount) -> float:
        return float(mount.position[0] * math.cos(heading_rad) + mount.position[1] * math.sin(heading_rad))

    return max(layout.mounts, key=towards).name
