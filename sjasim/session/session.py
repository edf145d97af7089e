"""The session loop: connects the world, the server and an anticipation method, and records what passes between them.

A message goes round in a circle:

1. The **world** simulates dancers, robot and sensors. Its devices send messages: events and status reports of the
   sensor clients, answers to clock requests, odometry of the robot.
2. **Uplinks** deliver these messages to the server, with latency, jitter and packet loss.
3. The **server** turns a client's report into an `Event`: session time instead of device time, a dancer's name instead
   of a sensor's identity, each event once.
4. The hooks of the **method** are called for events, for the boundaries of iterations and for its timers. They return
   actions: schedule a command, cancel one, set a timer.
5. The **dispatcher** keeps the schedule and sends each command to the robot when it is due.
6. **Downlinks** deliver commands to the robot, and the server's orders and clock requests to the sensor clients.
7. The **world** hands them to its devices, which act on them at their next control step or frame.

Nothing outside the world runs on a fixed step. Every link, timer and boundary knows when it is due next, and the
session processes them in order of time. The world is reached through its protocol only (`world.World`), so the same
loop runs with simulated physics, with event times alone, or with real devices.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from typing import NoReturn, SupportsIndex, cast

from ..anticipation.checked_method import CheckedMethod
from ..anticipation.method import Method, build_method
from ..choreography.layout import layout
from ..choreography.timetable import timetable
from ..config import HUMANS_ONLY, SessionConfig
from ..config.toml_file import to_plain
from ..core import ROBOT, ClientStatus, DeviceEvent, Event, MoveCommand, RobotState, SyncReply
from ..core.clock import stream
from ..core.registry import resolve
from ..core.session_log import Followed, Handover, SessionLog
from ..server.dispatcher import Dispatcher
from ..server.fusion import Server
from .preparation import SessionLinks, check_fault_targets, iteration_boundaries, method_context
from .world import UplinkMessage, World

_TIME_TOLERANCE_S = 1e-9
"""Tolerance in comparisons of session times, because sums of steps have rounding errors [s]."""

_PACKAGES = ("sjasim", "mujoco", "numpy", "scipy", "numba", "gymnasium", "rerun-sdk", "dm-control", "pyarrow")
"""Packages whose versions are kept with a session's log."""

_NOT_COPIED = (
    "a session in progress cannot be copied or pickled, because its physics runs in compiled arrays: "
    "run another Session with the same configuration, which gives the same session"
)


class Session:
    """One session, ready to run: `advance` it as far as you like, then take its `log`.

    `run_session` does both at once. How a session is divided into calls of `advance` does not change its outcome. A
    session cannot be copied or pickled: another one with the same configuration gives the same outcome.

    Args:
        config: everything about the session.
        method: used instead of the method that ``config.method`` names; the name then only labels it. A program that
            drives the robot itself, such as a reinforcement learning environment, passes a method without actions and
            commands moves with `Dispatcher.command_move`.

    Raises:
        SjasimError: a name is unknown, an option is not allowed, the layout does not fit the sensors, or a fault
            names a target that does not exist.

    Attributes:
        config: as given.
        timetable: when iterations and beats fall.
        layout: where dancers, robot and sensors stand.
        method: the anticipation method; None in a session without a robot.
        context: what the method was told before the dance.
        server: clocks, identities and the choice of the active sensor.
        dispatcher: schedule and commands of the robot.
        world: dancers, robot and sensors.
        end_s: session time at which the dance is over [s].
        events: every event so far, in order of arrival.
        commands: every new command to the robot so far, without repetitions.
        device_events: every event that a client sent, with the session time of sending [s].
        handovers: which sensor was active from when on.
        followed: whom the method followed in each iteration.
    """

    def __init__(self, config: SessionConfig, method: Method | None = None) -> None:
        self._cpu_start_s = time.process_time()
        self._wall_start_s = time.perf_counter()

        self.config = config
        self.timetable = timetable(config)
        self.layout = layout(config)
        sensors = [mount.name for mount in self.layout.mounts]
        check_fault_targets(config, sensors)

        has_robot = config.method != HUMANS_ONLY
        self.method: Method | None = None
        self._checked_method: CheckedMethod | None = None
        if has_robot:
            self.method = method or build_method(config.method, config.method_options)
            self._checked_method = CheckedMethod(config.method, self.method)

        self.context = method_context(config, self.timetable)
        world_factory = cast("Callable[..., World]", resolve("world", config.fidelity).factory)
        self.world = world_factory(config, self.timetable, self.layout, robot=has_robot)
        continuous = self.world.continuous
        self.server = Server(self.timetable, self.layout, config, continuous=continuous)
        heartbeat_hz = config.network.heartbeat_hz if continuous else 0.0
        self.dispatcher = Dispatcher(self.context, self.timetable, self.layout, config.robot, heartbeat_hz)
        # A stream of its own: a method's random draws change neither the dancers nor the noise of the sensors.
        if self._checked_method is not None:
            self._checked_method.reset(self.context, stream(config.seed, "anticipation", config.method))

        self._links = SessionLinks(config, sensors)
        self._boundaries = iteration_boundaries(self.timetable)
        # One attribute instead of five: `_process_due` reads it at every control step.
        self._due_sources = self._links.uplink, self._links.downlink, self.server, self.dispatcher, self._boundaries

        self.world.active = self.server.active
        self.end_s = self.world.end_s
        self.handovers = [Handover(0.0, self.server.active)]
        self.followed: list[Followed] = []
        self.events: list[Event] = []
        self.commands: list[MoveCommand] = []
        self.device_events: list[tuple[DeviceEvent, float]] = []

    def __reduce_ex__(self, protocol: SupportsIndex) -> NoReturn:
        """Refuse `copy.copy`, `copy.deepcopy` and `pickle` before anything is shared between two sessions.

        Raises:
            TypeError: always.
        """
        raise TypeError(_NOT_COPIED)

    @property
    def time_s(self) -> float:
        """Session time that has been reached [s]."""
        return self.world.time_s

    def advance(self, until_s: float) -> None:
        """Run the session until a session time [s]; a time that has passed changes nothing."""
        world = self.world
        self._process_due(world.time_s)

        while world.time_s < until_s - _TIME_TOLERANCE_S:
            sent_s = world.time_s
            for message in world.advance(until_s):
                self._send_up(sent_s, message)
            self._process_due(world.time_s)

    def log(self) -> SessionLog:
        """Everything that has happened so far."""
        world = self.world
        notices = [*world.notices, *self.server.notices, *self.dispatcher.notices]
        notices.sort(key=lambda notice: notice.t_s)
        cost = {
            "sim_s": self.time_s,
            "cpu_s": time.process_time() - self._cpu_start_s,
            "wall_s": time.perf_counter() - self._wall_start_s,
        }

        return SessionLog(
            config=to_plain(self.config),
            versions=package_versions(),
            cues=tuple(world.cues),
            device_events=tuple(self.device_events),
            events=tuple(self.events),
            commands=tuple(self.commands),
            decisions=tuple(self.dispatcher.decisions),
            robot_events=tuple(world.robot_events),
            notices=tuple(notices),
            handovers=tuple(self.handovers),
            followed=tuple(self.followed),
            odometry=world.recorder.odometry(),
            truth=world.recorder.truth(),
            joints=world.recorder.joints(),
            skeletons=world.recorder.skeletons(),
            cost=cost,
        )

    def _process_due(self, now: float) -> None:
        """Process everything outside the world that is due by session time ``now``, in order of time.

        The world may be ahead of a message that is processed here. This is correct because messages reach the world
        through its devices only, and these act at their next control step or frame.
        """
        uplink, downlink, server, dispatcher, boundaries = self._due_sources

        while True:
            due_s = min(
                uplink.next_arrival_s,
                downlink.next_arrival_s,
                server.next_due_s,
                dispatcher.next_due_s,
                boundaries[0].t_s,
            )
            if due_s > now:
                return
            self._process_instant(self.world.next_instant_s(due_s))

    def _process_instant(self, now: float) -> None:
        """Process what is due at one instant: arrivals at the server, then timers, then arrivals at the devices."""
        # Arrivals come first: a timer of the same instant may act on them.
        if self._links.uplink.next_arrival_s <= now:
            for t_arrival_s, message in self._links.uplink.receive(now):
                if isinstance(message, RobotState):
                    self.dispatcher.update_robot_state(t_arrival_s, message)
                else:
                    self._receive_from_client(t_arrival_s, message)

        # Most instants are those of an arrival, at which nothing of this is due.
        _, _, server, dispatcher, boundaries = self._due_sources
        if boundaries[0].t_s <= now:
            self._process_boundaries(now)
        if server.next_due_s <= now:
            self._send_server_messages(now)
        if dispatcher.next_due_s <= now and self._checked_method is not None:
            self._process_method_timers(now)

        if self.server.active != self.handovers[-1].sensor:
            self.handovers.append(Handover(now, self.server.active))
            self.world.active = self.server.active

        # Downlinks come last: on a link without delay, what was sent above arrives at this instant.
        if self._links.downlink.next_arrival_s <= now:
            for t_arrival_s, order in self._links.downlink.receive(now):
                reply = self.world.deliver(now, t_arrival_s, order)
                if reply is not None:
                    self._send_up(now, reply)

    def _send_up(self, t_s: float, message: UplinkMessage) -> None:
        """Send a device's message to the server, and record it if it is an event."""
        if isinstance(message, DeviceEvent):
            self.device_events.append((message, t_s))
        self._links.send_up(t_s, message)

    def _receive_from_client(self, t_arrival_s: float, message: DeviceEvent | ClientStatus | SyncReply) -> None:
        """Pass a client's message to the server, and the events that follow from it to the method."""
        for event in self.server.receive(t_arrival_s, message):
            self.events.append(event)
            self._call_method(t_arrival_s, "on_event", t_arrival_s, event)

    def _call_method(self, now: float, hook: str, event_time_s: float, *arguments: object) -> None:
        """Call one of the method's hooks and hand its actions to the dispatcher.

        Args:
            now: session time of the call [s].
            hook: name of the hook.
            event_time_s: session time of what the method is told [s]; a timer must lie after it.
            arguments: the hook's arguments.
        """
        if self._checked_method is None:
            return
        actions = self._checked_method.call(hook, event_time_s, arguments)
        if actions:
            self.dispatcher.handle(now, actions)

    def _process_boundaries(self, now: float) -> None:
        """Tell the method of iterations that have begun or ended, and record whom it follows in a new one."""
        while self._boundaries[0].t_s <= now:
            boundary = self._boundaries.popleft()
            hook = "on_iteration_start" if boundary.starts else "on_iteration_end"
            self._call_method(now, hook, boundary.t_s, boundary.iteration, boundary.t_s)

            if boundary.starts and self._checked_method is not None:
                persons = self._checked_method.follows(boundary.iteration, boundary.t_s)
                self.followed += _followed_rows(boundary.iteration, persons)

    def _send_server_messages(self, now: float) -> None:
        """Send the server's orders and clock requests that are due, and check that the robot still reports."""
        # The server sends something several times a second, which is often enough for this check.
        if self._checked_method is not None and self.world.continuous:
            self.dispatcher.check_robot_alive(now)
        for message in self.server.due_messages(now):
            self._links.send_down(now, message.sensor, message)

    def _process_method_timers(self, now: float) -> None:
        """Call the method's timers that are due, then send the commands that are due to the robot."""
        for timer_s in self.dispatcher.due_timers(now):
            self._call_method(now, "on_timer", timer_s, timer_s)

        for command in self.dispatcher.due_commands(now):
            # A repetition carries the number of the command that it repeats.
            if not self.commands or command.number != self.commands[-1].number:
                self.commands.append(command)
            self._links.send_down(now, ROBOT, command)


def run_session(
    config: SessionConfig,
    progress: Callable[[float], None] | None = None,
    prepare: Callable[[Session], None] | None = None,
) -> SessionLog:
    """Run one session from beginning to end.

    Args:
        config: everything about the session.
        progress: called about once per simulated second with the share of the session that is done, 0 to 1.
        prepare: called with the session before it begins, for instance to add observers to ``world.watchers``.

    Returns:
        what was planned, detected, decided and done.

    Raises:
        SjasimError: as `Session` raises it, or a method's own code failed.
    """
    session = Session(config)
    if prepare is not None:
        prepare(session)

    while session.time_s < session.end_s - _TIME_TOLERANCE_S:
        session.advance(min(session.time_s + 1.0, session.end_s))
        if progress is not None:
            progress(min(session.time_s / session.end_s, 1.0))

    return session.log()


@cache
def package_versions() -> Mapping[str, str]:
    """Versions of the packages that a session's outcome depends on; packages that are not installed are left out."""
    found: dict[str, str] = {}
    for name in _PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    return found


def _followed_rows(iteration: int, persons: Sequence[str] | None) -> list[Followed]:
    """Rows of the log for the answer of `CheckedMethod.follows`.

    A method that uses all dancers (None) leaves no row; one that follows nobody leaves a row with the name "".
    """
    if persons is None:
        return []
    return [Followed(iteration, name) for name in persons or ("",)]
