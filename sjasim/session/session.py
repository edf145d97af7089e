"""The conductor: one dance session, the only place that sees the whole circle.

World -> uplinks -> server -> method -> dispatcher -> downlinks -> world again, each at the instant it is due.
"""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from typing import cast

from ..anticipation.checked_method import CheckedMethod
from ..anticipation.method import HUMANS_ONLY, Method, build_method
from ..choreography.layout import layout
from ..choreography.timetable import timetable
from ..config import FAULTS, SessionConfig
from ..config.toml_file import to_plain
from ..core import ROBOT, ClientStatus, DeviceEvent, Event, MoveCommand, RobotState, SyncReply, dancer_name
from ..core.clock import stream
from ..core.errors import ConfigError
from ..core.link import Link, LinkQuality, Mail
from ..core.method_io import MethodContext
from ..core.registry import resolve
from ..core.session_log import Followed, Handover, SessionLog
from ..server.dispatcher import Dispatcher
from ..server.fusion import Server
from .world import DownlinkMessage, UplinkMessage, World

_PACKAGES = ("sjasim", "mujoco", "numpy", "scipy", "numba", "gymnasium", "rerun-sdk", "dm-control", "pyarrow")


class Session:
    """One dance, ready to run. Whoever steps it decides how far at a time.

    Args:
        config: everything about the session.
        method: used in place of the one that ``config.method`` names, which then is but a name; a driver from
            outside, such as a learning environment's agent, gives one that answers nothing and orders moves of the
            dispatcher itself.

    Raises:
        SjasimError: a name is unknown, an option is not allowed, the layout does not fit the sensors, or a fault
            has nobody to hit.
    """

    def __init__(self, config: SessionConfig, method: Method | None = None) -> None:
        self._started = time.process_time(), time.perf_counter()
        self.config = config
        self.timetable = timetable(config)
        self.layout = layout(config)
        _check_faults(config, [mount.name for mount in self.layout.mounts])
        robot = config.method != HUMANS_ONLY
        self.method: Method | None = None
        if robot:
            self.method = method or build_method(config.method, config.method_options)
        self._hooks = None if self.method is None else CheckedMethod(config.method, self.method)
        self.context = _context(self)
        self.server = Server(self.timetable, self.layout, config)
        self.dispatcher = Dispatcher(
            self.context, self.timetable, self.layout, config.robot, config.network.heartbeat_hz
        )
        world = cast("Callable[..., World]", resolve("world", config.fidelity).factory)
        self.world = world(config, self.timetable, self.layout, robot=robot)
        if self._hooks is not None:
            self._hooks.reset(self.context, stream(config.seed, "anticipation", config.method))
        self._open_links([mount.name for mount in self.layout.mounts])
        self._boundaries = _boundaries(self)
        self._circle = self._ups, self._downs, self.server, self.dispatcher, self._boundaries
        """Who knows when something happens outside the world: an arrival, a timer, a boundary."""
        self.world.active = self.server.active
        self.handovers = [Handover(0.0, self.server.active)]
        self.followed: list[Followed] = []
        self.events: list[Event] = []
        self.commands: list[MoveCommand] = []
        self.device_events: list[tuple[DeviceEvent, float]] = []
        self.end_s = self.world.end_s

    def _open_links(self, sensors: Sequence[str]) -> None:
        network = self.config.network
        down = LinkQuality(network.latency_s, network.jitter_s, network.packet_loss)
        up = LinkQuality(network.latency_s + network.uplink_asymmetry_s, network.jitter_s, network.packet_loss)
        names = (*sensors, ROBOT)
        self._ups, self._downs = Mail[UplinkMessage](), Mail[DownlinkMessage]()
        seed = self.config.seed
        self._up = {name: Link(up, stream(seed, "link", name, "up"), self._ups) for name in names}
        self._down = {name: Link(down, stream(seed, "link", name, "down"), self._downs) for name in names}

    @property
    def time_s(self) -> float:
        """Session time that has been reached [s]."""
        return self.world.time_s

    def advance(self, until_s: float) -> None:
        """Go on until a session time, instant by instant; where a caller pauses changes nothing."""
        world = self.world
        self._catch_up(world.time_s)
        while world.time_s < until_s - 1e-9:
            now = world.time_s
            for output in world.advance(until_s):
                self._send_up(now, output)
            self._catch_up(world.time_s)

    def _catch_up(self, now: float) -> None:
        """Let everything outside the world happen that is due by now, each at its own instant.

        Nothing of it reaches the world but messages to devices, and these act on them at their next turn: so the
        physics need not stop for it.
        """
        ups, downs, server, dispatcher, boundaries = self._circle
        while True:
            due_s = min(
                ups.next_arrival_s, downs.next_arrival_s, server.next_due_s, dispatcher.next_due_s, boundaries[0][0]
            )
            if due_s > now:
                return
            self._happen(self.world.next_instant_s(due_s))

    def _happen(self, now: float) -> None:
        """Let happen what is due at one instant: arrivals, then timers, then what the devices are told."""
        if self._ups.next_arrival_s <= now:
            for t_arrival_s, message in self._ups.receive(now):
                if isinstance(message, RobotState):
                    self.dispatcher.update_robot_state(t_arrival_s, message)
                else:
                    self._tell(t_arrival_s, message)
        self._conduct(now)
        if self.server.active != self.handovers[-1].sensor:
            self.handovers.append(Handover(now, self.server.active))
            self.world.active = self.server.active
        if self._downs.next_arrival_s <= now:
            for t_arrival_s, order in self._downs.receive(now):
                reply = self.world.deliver(now, t_arrival_s, order)
                if reply is not None:
                    self._send_up(now, reply)

    def _send_up(self, now: float, output: UplinkMessage) -> None:
        if isinstance(output, DeviceEvent):
            self.device_events.append((output, now))
        sender = ROBOT if isinstance(output, RobotState) else output.sensor
        self._up[sender].send(now, output)

    def _tell(self, t_arrival_s: float, message: DeviceEvent | ClientStatus | SyncReply) -> None:
        for event in self.server.receive(t_arrival_s, message):
            self.events.append(event)
            self._ask(t_arrival_s, "on_event", t_arrival_s, event)

    def _ask(self, now: float, hook: str, told_s: float, *given: object) -> None:
        """Tell the method of something, and the dispatcher its answers; ``told_s`` is when it says that it happened."""
        if self._hooks is not None and (answers := self._hooks.call(hook, told_s, given)):
            self.dispatcher.handle(now, answers)

    def _conduct(self, now: float) -> None:
        """Boundaries, timers and everything the server has to send."""
        while self._boundaries[0][0] <= now:
            t_s, iteration, starts = self._boundaries.popleft()
            self._ask(now, "on_iteration_start" if starts else "on_iteration_end", t_s, iteration, t_s)
            if starts and self._hooks is not None:
                persons = self._hooks.follows(iteration, t_s)
                self.followed += [Followed(iteration, name) for name in _or_nobody(persons)]
        if self.server.next_due_s <= now:
            if self._hooks is not None:
                self.dispatcher.check_robot_alive(now)
            for order in self.server.due_messages(now):
                self._down[order.sensor].send(now, order)
        if self._hooks is not None and self.dispatcher.next_due_s <= now:
            for wake_s in self.dispatcher.due_timers(now):
                self._ask(now, "on_timer", wake_s, wake_s)
            for command in self.dispatcher.due_commands(now):
                if not self.commands or command.number != self.commands[-1].number:
                    self.commands.append(command)
                self._down[ROBOT].send(now, command)

    def log(self) -> SessionLog:
        """Everything that has happened so far."""
        cpu, wall = self._started
        world = self.world
        noticed = [*world.notices, *self.server.notices, *self.dispatcher.notices]
        notices = sorted(noticed, key=lambda notice: notice.t_s)
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
            cost={
                "sim_s": self.time_s,
                "cpu_s": time.process_time() - cpu,
                "wall_s": time.perf_counter() - wall,
            },
        )


def run_session(
    config: SessionConfig,
    progress: Callable[[float], None] | None = None,
    prepare: Callable[[Session], None] | None = None,
) -> SessionLog:
    """Dance one session from beginning to end.

    Args:
        config: everything about the session.
        progress: called with the share that is done, 0 to 1, about once per simulated second.
        prepare: called with the session before it begins, for those who want to watch it (``world.watchers``).

    Returns:
        what was planned, seen, decided and done.
    """
    session = Session(config)
    if prepare is not None:
        prepare(session)
    while session.time_s < session.end_s - 1e-9:
        session.advance(min(session.time_s + 1.0, session.end_s))
        if progress is not None:
            progress(min(session.time_s / session.end_s, 1.0))
    return session.log()


@cache
def package_versions() -> Mapping[str, str]:
    """Versions of the packages that a session's outcome depends on; those not installed are left out."""
    found: dict[str, str] = {}
    for name in _PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    return found


def _or_nobody(persons: Sequence[str] | None) -> Sequence[str]:
    """What is logged of whom a method follows: nothing for everyone."""
    return () if persons is None else persons or ("",)


def _context(session: Session) -> MethodContext:
    table, config = session.timetable, session.config
    iterations = range(config.iterations + 1)
    return MethodContext(
        cast=tuple(dancer_name(index) for index in range(config.dancers)),
        steps=table.choreography.steps(),
        iterations=config.iterations,
        beat_s=60.0 / config.dance.bpm,
        iteration_start_s=tuple(table.start_s(iteration) for iteration in iterations),
        window_end_s=tuple(table.close_s(iteration) for iteration in iterations),
        tempo=table.tempo.shifted(table.lead_in_s),
        tau_s=config.synchrony.tau_s,
    )


def _check_faults(config: SessionConfig, sensors: Sequence[str]) -> None:
    """Refuse a fault that would hit nobody."""
    dancers = [dancer_name(index) for index in range(config.dancers)]
    for index, fault in enumerate(config.faults):
        allowed = {"dancer": dancers, "robot": [ROBOT]}.get(FAULTS[fault.kind], sensors)
        if fault.target not in allowed:
            raise ConfigError(f"faults[{index}].target", fault.target, f"for {fault.kind} one of {', '.join(allowed)}")


def _boundaries(session: Session) -> deque[tuple[float, int, bool]]:
    """(time, iteration, whether it starts) of every iteration's beat 0 and window's end, and an end that never comes.

    They are in order of time.
    """
    table = session.timetable
    iterations = range(table.first, table.last + 1)
    marks = [(table.start_s(k), k, True) for k in iterations] + [(table.close_s(k), k, False) for k in iterations]
    return deque([*sorted(marks), (math.inf, table.last + 1, False)])
