"""The world that is simulated in MuJoCo: dancers, robot and sensors, each updated at its own rate."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import cast

from ..assets.names import CARDINALS
from ..choreography.layout import Layout, Mount
from ..choreography.timetable import Timetable
from ..config import FaultConfig, SessionConfig
from ..core import ROBOT, Cue, MoveCommand, SkeletonFrame, SyncReply, dancer_name
from ..core.clock import DeviceClock, Task, stream
from ..core.errors import ConfigError
from ..core.registry import register, resolve
from ..core.session_log import AgentEvent, Notice
from ..humans.body.body_model import body_model
from ..humans.motion.balance_controller import BalanceController
from ..humans.motion.reference_trajectory import ReferenceTrajectory
from ..sensors.sensor_client import ROUNDING_S, SensorClient
from ..sensors.skeleton_source import SkeletonSource
from ..session.session import Session
from ..session.world import DownlinkMessage, UplinkMessage
from .cast import sample_build
from .control_loop import STOPPED, DancerController, RobotController
from .ground_truth_recorder import GroundTruthRecorder
from .motion_scheduler import MotionScheduler
from .physics import Physics

FALLEN_SHARE = 0.65
"""A dancer has fallen when the pelvis is below this share of its standing height."""

CHECK_INTERVAL_S = 0.2
"""Time between two checks for falls and for instability [s]."""

STATE_HZ = 5
"""Rate at which the robot reports its state to the server [Hz]."""


@register("world", "physics")
class PhysicsWorld:
    """Dancers, robot and sensors in MuJoCo; implements the protocol `World`.

    Args:
        config: the session.
        timetable: the dance on the session's clock.
        layout: places of dancers, robot and sensors.
        robot: whether there is a robot.
        given_cues: cues of each dancer, in place of those that the human timing model decides.

    Attributes:
        continuous: True; see `World`.
        physics: the simulation.
        anatomies: one for each dancer.
        reference: planned motion of the dancers.
        scheduler: decides and plans the dancers' motion.
        recorder: ground truth of the session.
        dancers: control steps of the dancers.
        robot: control steps of the robot.
        sensing: source of skeletons of each sensor, by the sensor's name.
        active: name of the sensor whose skeletons and view are recorded; the session sets it.
        end_s: session time at which the dance is over [s].
        watchers: functions that are called with the session time at every frame. They observe and change nothing.
        notices: what went wrong so far.
        cues: what the dancers planned so far.
        robot_events: what the robot did so far.
    """

    continuous = True

    def __init__(
        self,
        config: SessionConfig,
        timetable: Timetable,
        layout: Layout,
        *,
        robot: bool,
        given_cues: Sequence[Sequence[Cue]] | None = None,
    ) -> None:
        self._config = config
        self._timetable = timetable
        self._has_robot = robot
        self.end_s = timetable.end_s() + config.dance.tail_s
        self.active = CARDINALS[0]
        self.watchers: list[Callable[[float], None]] = []
        self.robot_events: list[AgentEvent] = []
        self._outbox: list[UplinkMessage] = []

        self._make_dancers(layout, given_cues)
        self._make_sensors(layout)
        if robot:
            self._make_robot(layout)
        self._prepare_faults()
        self._prepare_tasks()
        self.scheduler.update(0.0, self.robot_events, self._fallen)

    def _make_dancers(self, layout: Layout, given_cues: Sequence[Sequence[Cue]] | None) -> None:
        config = self._config
        timetable = self._timetable
        builds = [sample_build(config, index) for index in range(config.dancers)]
        self.anatomies = [body_model(config.body.model).anatomy(build) for build in builds]

        rows = math.ceil((self.end_s + 1.0) * config.physics.control_hz) + 1
        self.reference = ReferenceTrajectory.empty(config.dancers, rows)
        self.scheduler = MotionScheduler(
            config,
            timetable,
            layout,
            self.anatomies,
            self.reference,
            robot=self._has_robot,
            given_cues=given_cues,
        )
        self.notices: list[Notice] = self.scheduler.notices
        self.cues: list[Cue] = self.scheduler.cues

        self.physics = Physics(
            self.anatomies,
            layout,
            (timetable.heading_rad(timetable.first), timetable.heading_rad(1)),
            self.reference.joints[:, 0],
            self.reference.pelvis[:, 0],
            config.physics,
            config.body,
            config.robot if self._has_robot else None,
        )
        balance = BalanceController(
            self.reference, self.scheduler.omega, config.physics.control_hz, self.physics.servos
        )
        every = max(1, config.physics.control_hz // config.physics.ground_truth_hz)
        self.recorder = GroundTruthRecorder(self.physics.servos.weight, every, rows // every)
        self.dancers = DancerController(self.physics, balance, self.recorder)

        self._fallen = [False] * config.dancers
        self._fallen_height_m = [FALLEN_SHARE * anatomy.standing_m for anatomy in self.anatomies]

    def _make_sensors(self, layout: Layout) -> None:
        self.sensing: dict[str, SkeletonSource] = {}
        self._mounts = {mount.name: mount for mount in layout.mounts}
        self._clients = {mount.name: self._make_client(mount) for mount in layout.mounts}

    def _make_client(self, mount: Mount) -> SensorClient:
        config = self._config
        faults = {fault.kind: fault for fault in config.faults if fault.target == mount.name}
        jump = faults.get("clock_jump", FaultConfig("clock_jump", mount.name, 1e5))
        clock_rng = stream(config.seed, "clock", mount.name)
        clock = DeviceClock(
            offset_s=clock_rng.uniform(-1, 1) * config.clocks.max_offset_s,
            drift=clock_rng.uniform(-1, 1) * config.clocks.max_skew,
            jump_at_s=jump.t_s,
            jump_s=jump.value,
        )

        factory = cast("Callable[..., SkeletonSource]", resolve("sensing", config.sensing).factory)
        source = factory(mount, config, stream(config.seed, "sensors", config.sensing, mount.name))
        self.sensing[mount.name] = source
        dead_from_s = faults["dead_sensor"].t_s if "dead_sensor" in faults else math.inf
        return SensorClient(mount, source, config.detectors, config.sensors, clock, dead_from_s=dead_from_s)

    def _make_robot(self, layout: Layout) -> None:
        pose = (float(layout.robot[0]), float(layout.robot[1]), self._timetable.heading_rad(1))
        gyro_rng = stream(self._config.seed, "robot", "gyro")
        self.robot = RobotController(self.physics, self._config.robot, pose, gyro_rng, self.recorder)

    def _prepare_faults(self) -> None:
        self._wheels_blocked_from_s = _first_s(self._config.faults, "robot_blocked")
        self._robot_dead_from_s = _first_s(self._config.faults, "dead_robot")
        self._blocked = False

    def _prepare_tasks(self) -> None:
        config = self._config
        ticks = self.physics.ticks
        self._control_hz = config.physics.control_hz
        self._control_task = Task(ticks, self._control_hz)
        self._frame_task = Task(ticks, config.sensors.rate_hz)
        self._robot_task = Task(ticks, config.robot.odometry_hz)
        self._state_task = Task(ticks, STATE_HZ)
        self._check_due_s = 0.0

    @property
    def time_s(self) -> float:
        """Session time that has been reached [s]."""
        return self.physics.time_s

    def next_instant_s(self, t_s: float) -> float:
        """First physics tick that is not before a time [s]; see `World`."""
        return self.physics.ticks.first_s(t_s)

    def deliver(self, now_s: float, t_arrival_s: float, message: DownlinkMessage) -> SyncReply | None:
        """Hand a message to the device that it is for; see `World`."""
        if not isinstance(message, MoveCommand):
            return self._clients[message.sensor].handle_message(t_arrival_s, message, now_s)
        if now_s < self._robot_dead_from_s:
            self.robot.receive(now_s, message)
        return None

    def latest_frame(self, sensor: str) -> SkeletonFrame | None:
        """The last frame that a sensor's client has processed; see `World`."""
        return self._clients[sensor].latest_frame

    def advance(self, until_s: float) -> list[UplinkMessage]:
        """Update the devices that are due, then go on to the next update of any; see `World`.

        A time between two ticks counts as the later one.
        """
        physics = self.physics
        now = physics.time_s
        if until_s <= now:
            return []

        if now >= self._check_due_s:
            self._check(now)
        self._outbox = []
        self._run_due_tasks(physics.tick, now)

        tick = min(self._control_task.due, self._frame_task.due, self._robot_task.due)
        if tick / physics.ticks.rate_hz > until_s:
            # At least one tick passes, whatever rounding makes of the time that was asked for.
            tick = min(tick, max(physics.ticks.at_or_after(until_s), physics.tick + 1))
        physics.step_to(tick)
        return self._outbox

    def _run_due_tasks(self, tick: int, now: float) -> None:
        """Run everything that is due at this tick, before the physics goes on."""
        if tick == self._robot_task.due:
            self.update_robot(now)
            self._robot_task.advance()
        if tick == self._frame_task.due:
            self.update_sensors(now)
            self._frame_task.advance()
        if tick == self._control_task.due:
            self.update_dancers(now)
            self._control_task.advance()

    def update_robot(self, now: float) -> None:
        """Run a control step of the robot: odometry, events, wheel speeds."""
        if not self._has_robot:
            return
        if now >= self._robot_dead_from_s:
            self.physics.drive(STOPPED)
            return

        event = self.robot.step(now, wheels_blocked=now >= self._wheels_blocked_from_s)
        if event is not None:
            kind, t_s = event
            self.robot_events.append(AgentEvent(self._timetable.iteration_at(t_s), ROBOT, kind, t_s))

        blocked = self.robot.blocked
        if blocked and not self._blocked:
            self.notices.append(Notice(now, ROBOT, "blocked: it is commanded to move but its wheels stand still"))
        self._blocked = blocked

        if self.physics.tick >= self._state_task.due:
            self._state_task.advance()
            self._outbox.append(self.robot.state)

    def update_sensors(self, now: float) -> None:
        """Run a frame: the clients capture and send what is ready; the load on the dancers' feet is measured."""
        self.physics.measure_load()
        soon = now + ROUNDING_S
        for name, client in self._clients.items():
            if client.next_capture_s <= soon:
                skeletons = client.capture_frame(now, self.physics)
                if name == self.active and skeletons is not None:
                    self.recorder.add_skeletons(skeletons, self.sensing[name].dancers, self._mounts[name])
            if client.next_output_s <= soon:
                self._outbox.extend(client.pop_messages(now))

        source = self.sensing[self.active]
        detecting = self._clients[self.active].is_detecting(now)
        self.recorder.add_frame(self.physics.joints_m, source.visible if detecting else None, source.dancers)
        for watcher in self.watchers:
            watcher(now)

    def update_dancers(self, now: float) -> None:
        """Run a control step of the dancers: decide and plan what is due, then balance."""
        self.scheduler.update(now, self.robot_events, self._fallen)
        self.dancers.step(round(now * self._control_hz), now)

    def _check(self, now: float) -> None:
        """Check that the physics is stable, and who has fallen."""
        self._check_due_s = now + CHECK_INTERVAL_S
        self.physics.check()
        for index, limit_m in enumerate(self._fallen_height_m):
            if self.physics.height_m(index) < limit_m and not self._fallen[index]:
                self._fallen[index] = True
                self.physics.make_limp(index)
                self.recorder.mark_fallen(now, index)
                self.notices.append(Notice(now, dancer_name(index), "fell and dances no more"))


def _first_s(faults: Sequence[FaultConfig], kind: str) -> float:
    """Time from which the first fault of a kind acts [s]; infinite without one."""
    return min((fault.t_s for fault in faults if fault.kind == kind), default=math.inf)


def physics_of(session: Session) -> PhysicsWorld:
    """The world of a session that is simulated in MuJoCo.

    Raises:
        ConfigError: the session has another world, which has no bodies to show or measure.
    """
    if not isinstance(session.world, PhysicsWorld):
        raise ConfigError("fidelity", session.config.fidelity, "physics, for whatever shows or measures bodies")
    return session.world
