"""Worlds: what stands between the methods' commands and the events they are told of.

`PhysicsWorld` holds people's timing and motion, the stage, the robot's executor and the sensors' clients, and fires
each on its own rate. A world emits messages and takes messages; links and server lie outside.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Sequence
from typing import cast

import numpy as np

from ..assets.names import CARDINALS
from ..choreography.layout import Layout
from ..choreography.timetable import Timetable
from ..config import FaultConfig, SessionConfig
from ..core import (
    ROBOT,
    Cue,
    Kind,
    MoveCommand,
    SkeletonFrame,
    SyncReply,
    WheelCommand,
    dancer_name,
)
from ..core.clock import DeviceClock, Task, stream
from ..core.errors import ConfigError
from ..core.registry import register, resolve
from ..core.session_log import AgentEvent, Notice
from ..humans.body.body_model import body_model
from ..humans.motion.balance_controller import BalanceController
from ..humans.motion.planner import PREVIEW_S, Planner
from ..humans.motion.reference_trajectory import ReferenceTrajectory
from ..humans.timing.ensemble import PREPARATION_S
from ..humans.timing.replay import Replay
from ..sensors.client import ROUNDING_S, SensorClient
from ..sensors.skeleton_source import SkeletonSource
from ..session.session import Session
from ..session.world import DownlinkMessage, UplinkMessage
from .cast import felt_error_s, people, performed_cues, person
from .control_loop import DancerController, RobotController
from .physics import Physics
from .recorder import GroundTruthRecorder

FALLEN_SHARE = 0.65
"""A dancer whose pelvis is below this share of its standing height has fallen."""
REST_S = 0.7
"""Nobody begins the next iteration sooner after the last one's turn: the sway has to settle (assumed) [s]."""
CHECK_S = 0.2
"""How often falls are looked for [s]."""
STATE_HZ = 5
"""How often the robot reports its state to the server."""


@register("world", "physics")
class PhysicsWorld:
    """Dancers, robot and sensors in MuJoCo.

    Args:
        config: the session.
        timetable: the dance on the session's clock.
        layout: where everyone stands.
        robot: whether there is one.

    Attributes:
        reference: what the dancers plan to do.
        active: the sensor whose skeletons and view are recorded; whoever knows which client counts says so.
        sensing: what sees for each sensor, by its name.
        watchers: called with the session time at every frame tick; they look and change nothing.
    """

    def __init__(self, config: SessionConfig, timetable: Timetable, layout: Layout, *, robot: bool) -> None:
        self._config = config
        self._timetable = timetable
        self.end_s = timetable.end_s() + config.dance.tail_s
        self.active = CARDINALS[0]
        self.watchers: list[Callable[[float], None]] = []
        self.notices: list[Notice] = []
        self.cues: list[Cue] = []
        self.robot_events: list[AgentEvent] = []
        self._faults = config.faults
        self._dance(config, timetable, layout, robot)
        every = max(1, config.physics.control_hz // config.physics.ground_truth_hz)
        self.recorder = GroundTruthRecorder(self.physics.servos.weight, every, self.reference.rows.shape[1] // every)
        self.dancers = DancerController(self.physics, self.balance, self.recorder)
        self._equip(config, layout, robot)
        self._outbox: list[UplinkMessage] = []
        self._check_s = 0.0
        self._next_iteration = timetable.first
        self._begin_s = 0.0
        self.plan()

    def _dance(self, config: SessionConfig, timetable: Timetable, layout: Layout, robot: bool) -> None:
        heading = timetable.heading_rad(timetable.first)
        rate = config.physics.control_hz
        builds = [person(config, index) for index in range(config.dancers)]
        self._anatomies = [body_model(config.body.model).anatomy(build) for build in builds]
        self.reference = reference = ReferenceTrajectory.empty(config.dancers, math.ceil((self.end_s + 1.0) * rate) + 1)
        turn = timetable.choreography.turn_rad
        self._planners = [
            Planner(body, layout.dancers[index], heading, config.dance.step_m, turn, rate, reference.for_dancer(index))
            for index, body in enumerate(self._anatomies)
        ]
        self.physics = Physics(
            self._anatomies, layout, (heading, timetable.heading_rad(1)), reference.joints[:, 0],
            reference.pelvis[:, 0], config.physics, config.body, config.robot if robot else None,
        )  # fmt: skip
        omega = np.array([planner.omega for planner in self._planners])
        self.balance = BalanceController(reference, omega, rate, self.physics.servos)
        self._timing = people(config, timetable)
        if isinstance(self._timing, Replay):
            self.notices.extend(self._timing.notices)
        self._busy_s = np.zeros(config.dancers)
        self._decided: list[deque[Cue]] = [deque() for _ in range(config.dancers)]
        self._set_out_s = 0.0
        self._fallen = [False] * config.dancers
        self._fall_m = [FALLEN_SHARE * body.standing_m for body in self._anatomies]

    def _equip(self, config: SessionConfig, layout: Layout, robot: bool) -> None:
        ticks = self.physics.ticks
        self.sensing: dict[str, SkeletonSource] = {}
        self._mounts = {mount.name: mount for mount in layout.mounts}
        self._clients = {mount.name: self._client(config, layout, index) for index, mount in enumerate(layout.mounts)}
        self._balance_hz = config.physics.control_hz
        self._balance_task = Task(ticks, self._balance_hz)
        self._frame_task = Task(ticks, config.sensors.rate_hz)
        self._robot_task = Task(ticks, config.robot.odometry_hz)
        self._state_task = Task(ticks, STATE_HZ)
        self._has_robot = robot
        self._blocked_from_s = _first_s(config.faults, "robot_blocked")
        self._dead_from_s = _first_s(config.faults, "dead_robot")
        self._blocked = False
        if robot:
            pose = (float(layout.robot[0]), float(layout.robot[1]), self._timetable.heading_rad(1))
            self.robot = RobotController(
                self.physics, config.robot, pose, stream(config.seed, "robot", "gyro"), self.recorder
            )

    def _client(self, config: SessionConfig, layout: Layout, index: int) -> SensorClient:
        mount = layout.mounts[index]
        rng = stream(config.seed, "clock", mount.name)
        faults = {fault.kind: fault for fault in config.faults if fault.target == mount.name}
        jump = faults.get("clock_jump", FaultConfig("clock_jump", mount.name, 1e5))
        clock = DeviceClock(
            offset_s=rng.uniform(-1, 1) * config.clocks.max_offset_s,
            drift=rng.uniform(-1, 1) * config.clocks.max_skew,
            jump_at_s=jump.t_s,
            jump_s=jump.value,
        )
        factory = cast("Callable[..., SkeletonSource]", resolve("sensing", config.sensing).factory)
        rng = stream(config.seed, "sensors", config.sensing, mount.name)
        sensing = self.sensing[mount.name] = factory(mount, config, rng)
        dead_from_s = faults["dead_sensor"].t_s if "dead_sensor" in faults else math.inf
        return SensorClient(mount, sensing, config.detectors, config.sensors, clock, dead_from_s=dead_from_s)

    @property
    def time_s(self) -> float:
        """Session time that has been reached [s]."""
        return self.physics.time_s

    def next_instant_s(self, t_s: float) -> float:
        """See `World`: a tick of the physics."""
        return self.physics.ticks.first_s(t_s)

    def deliver(self, now_s: float, t_arrival_s: float, message: DownlinkMessage) -> SyncReply | None:
        """See `World`."""
        if not isinstance(message, MoveCommand):
            return self._clients[message.sensor].handle_message(t_arrival_s, message, now_s)
        if now_s < self._dead_from_s:
            self.robot.receive(now_s, message)
        return None

    def advance(self, until_s: float) -> list[UplinkMessage]:
        """See `World`; instants between two ticks count as the later one."""
        physics = self.physics
        now = physics.time_s
        if until_s <= now:
            return []
        if now >= self._check_s:
            self._check(now)
        self._outbox = []
        self._fire(physics.tick, now)
        turn = min(self._balance_task.due, self._frame_task.due, self._robot_task.due)
        if turn / physics.ticks.rate_hz > until_s:  # whatever rounding says, time goes on
            turn = min(turn, max(physics.ticks.at_or_after(until_s), physics.tick + 1))
        physics.step_to(turn)
        return self._outbox

    def latest_frame(self, sensor: str) -> SkeletonFrame | None:
        """The last frame that a sensor's client has processed."""
        return self._clients[sensor].latest_frame

    def _fire(self, tick: int, now: float) -> None:
        """Do everything that is due at this tick, before the physics goes on."""
        if tick == self._robot_task.due:
            self.drive(now)
            self._robot_task.advance()
        if tick == self._frame_task.due:
            self.look(now)
            self._frame_task.advance()
        if tick == self._balance_task.due:
            self._move(now)
            self._balance_task.advance()

    def drive(self, now: float) -> None:
        """A tick of the robot: odometry, events, wheel command."""
        if not self._has_robot:
            return
        if now >= self._dead_from_s:
            self.physics.drive(WheelCommand(0.0, 0.0))
            return
        event = self.robot.step(now, wheels_blocked=now >= self._blocked_from_s)
        if event is not None:
            iteration = self._timetable.iteration_at(event[1])
            self.robot_events.append(AgentEvent(iteration, ROBOT, event[0], event[1]))
        blocked = self.robot.blocked
        if blocked and not self._blocked:
            self.notices.append(Notice(now, ROBOT, "blocked: it is commanded to move but its wheels stand still"))
        self._blocked = blocked
        if self.physics.tick >= self._state_task.due:
            self._state_task.advance()
            self._outbox.append(self.robot.state)

    def look(self, now: float) -> None:
        """A frame tick: the clients take their frames and send what is ready; the floor's force is felt."""
        self.physics.measure_load()
        soon = now + ROUNDING_S
        for name, client in self._clients.items():
            if client.next_capture_s <= soon:
                skeletons = client.capture_frame(now, self.physics)
                if name == self.active and skeletons is not None:
                    self.recorder.add_skeletons(skeletons, self.sensing[name].dancers, self._mounts[name])
            if client.next_output_s <= soon:
                self._outbox.extend(client.pop_messages(now))
        sensing, watches = self.sensing[self.active], self._clients[self.active].is_detecting(now)
        self.recorder.add_frame(self.physics.joints_m, sensing.visible if watches else None, sensing.dancers)
        for watch in self.watchers:
            watch(now)

    def _move(self, now: float) -> None:
        if now >= self._plan_s:
            self.plan()
        if now >= self._set_out_s:
            self.set_out(now)
        self.dancers.step(round(now * self._balance_hz), now)

    def _check(self, now: float) -> None:
        """Now and then: is the physics sound, has anybody fallen?"""
        self._check_s = now + CHECK_S
        self.physics.check()
        for index, limit_m in enumerate(self._fall_m):
            if self.physics.height_m(index) < limit_m and not self._fallen[index]:
                self._fallen[index] = True
                self.physics.make_limp(index)
                self.recorder.mark_fallen(now, index)
                self.notices.append(Notice(now, dancer_name(index), "fell and dances no more"))

    def plan(self) -> None:
        """Ask everybody what they decide to do next, and plan their motion; people know it some beats ahead."""
        now = self.time_s
        if now >= self._begin_s and self._timing.next_due_s == math.inf:
            self._begin(now)
        drawn = self._timing.decide(now, self._seen())
        for index, cues in enumerate(drawn):
            if self._fallen[index] or not cues:
                continue
            performed = performed_cues(cues, self._faults)
            self._decided[index].extend(performed)
            self.cues.extend(performed)
            if performed:
                self._busy_s[index] = max(cue.t_s + cue.duration_s for cue in performed) + REST_S
        self.cues.sort(key=lambda cue: (cue.iteration, cue.t_s))
        due_s = self._timing.next_due_s
        self._plan_s = due_s if due_s < math.inf else self._begin_s
        self._set_out_s = now

    def set_out(self, now: float) -> None:
        """Plan everybody's next move as late as it may be planned, and so from where they stand by then."""
        ahead_s = now + PREVIEW_S
        for planner, decided, fallen in zip(self._planners, self._decided, self._fallen, strict=True):
            while decided and decided[0].t_s <= ahead_s:
                cue = decided.popleft()
                if not fallen:
                    planner.extend([cue], now)
        self._set_out_s = min((decided[0].t_s for decided in self._decided if decided), default=math.inf) - PREVIEW_S

    def _begin(self, now: float) -> None:
        """Begin the next iteration; the one after it begins when this one's window has closed."""
        iteration = self._next_iteration
        self._next_iteration += 1
        self._begin_s = self._timetable.close_s(iteration) if iteration < self._timetable.last else math.inf
        earliest = np.maximum(self._busy_s, now + PREPARATION_S)
        self._timing.begin(iteration, self._appropriateness(iteration - 1), earliest)

    def _seen(self) -> list[tuple[Kind, float]]:
        """What the robot has been seen to do in the iteration that is being decided."""
        iteration = self._next_iteration - 1
        return [(event.kind, event.t_s) for event in self.robot_events if event.iteration == iteration]

    def _appropriateness(self, iteration: int) -> float | None:
        """The robot's mean timing error as the dancers feel it; None where it did not dance."""
        if not self._has_robot or iteration < 1:
            return None
        return felt_error_s(
            [cue for cue in self.cues if cue.iteration == iteration],
            [event for event in self.robot_events if event.iteration == iteration],
        )


def _first_s(faults: Sequence[FaultConfig], kind: str) -> float:
    """When the first fault of a kind begins; infinite without one."""
    return min((fault.t_s for fault in faults if fault.kind == kind), default=math.inf)


def physics_of(session: Session) -> PhysicsWorld:
    """The world of a session that is simulated in MuJoCo.

    Raises:
        ConfigError: the session has another world, which shows no bodies.
    """
    if not isinstance(session.world, PhysicsWorld):
        raise ConfigError("fidelity", session.config.fidelity, "physics, for whatever shows or measures bodies")
    return session.world
