"""Observations of the environments: what the server knows and the active sensor's skeletons, never the ground truth."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from sjasim.anticipation.observation import (
    MAX_AGE_S,
    MAX_DEVIATION_S,
    MIN_SCALED_BEAT,
    MOVES,
    PERIODS,
    EventFeatures,
    Row,
    write_time_features,
)
from sjasim.assets.names import JOINTS
from sjasim.config import SessionConfig
from sjasim.core import SYNCHRONY_KINDS, Array, IntArray, Move, MoveCommand, RobotState, Skeletons
from sjasim.core.compiled import compiled_entry
from sjasim.session.session import Session

MAX_POSITION_M = 20.0
"""Bound of every coordinate of a position [m]; beyond the range of any sensor."""

BUFFER_ROWS = 32
"""Observations that are allocated at a time."""

JOINT_COUNT = len(JOINTS)

COMMAND_WIDTH = 7
"""Numbers of the part ``command``: one of four moves, age, speed, yaw rate."""

COMMAND_AGE = 4
"""Place of the age in the part ``command``."""

ROBOT_WIDTH = 6
"""Numbers of the part ``robot``: x, y, heading, speed, yaw rate, age."""

ROBOT_AGE = 5
"""Place of the age in the part ``robot``."""

NO_SKELETONS = Skeletons(
    np.empty(0, dtype=np.int64), np.empty((0, JOINT_COUNT, 3)), np.empty((0, JOINT_COUNT), dtype=np.int8)
)
"""Skeletons of a sensor that has not sent any."""

for _array in NO_SKELETONS:
    # The arrays of a frame are read-only too. Another type would make numba compile `_write` once more.
    _array.flags.writeable = False


class Part(NamedTuple):
    """Shape and bounds of one part of an observation.

    Attributes:
        shape: shape of the part.
        low: lower bounds, of this shape.
        high: upper bounds, of this shape.
    """

    shape: tuple[int, ...]
    low: Row
    high: Row


def observation_parts(config: SessionConfig, steps: int, sensors: int) -> dict[str, Part]:
    """Shapes and bounds of the parts of an observation, in alphabetical order.

    Args:
        config: the session, of which the number of dancers and the robot's limits matter.
        steps: number of events that the dance expects of the robot in an iteration.
        sensors: number of sensors.
    """
    speed_m_s = config.robot.max_speed_m_s
    yaw_rate_rad_s = config.robot.max_yaw_rate_rad_s
    dancers = config.dancers

    # Odometry overshoots the limits while the base ramps its speed.
    robot = [MAX_POSITION_M, MAX_POSITION_M, math.pi, 2 * speed_m_s, 2 * yaw_rate_rad_s, MAX_AGE_S]
    robot_low = [*(-bound for bound in robot[:ROBOT_AGE]), 0.0]
    command_low = [0.0, 0.0, 0.0, 0.0, 0.0, -speed_m_s, -yaw_rate_rad_s]
    command_high = [1.0, 1.0, 1.0, 1.0, MAX_AGE_S, speed_m_s, yaw_rate_rad_s]
    return {
        "beat": _part((1 + 2 * len(PERIODS),), MIN_SCALED_BEAT, -MIN_SCALED_BEAT),
        "client": _part((sensors,), 0.0, 1.0),
        "command": _part((COMMAND_WIDTH,), command_low, command_high),
        "event_age": _part((dancers, len(SYNCHRONY_KINDS), 2), 0.0, MAX_AGE_S),
        "iteration": _part((1,), 0.0, float(config.iterations)),
        "joints": _part((dancers, JOINT_COUNT, 3), -MAX_POSITION_M, MAX_POSITION_M),
        "last_iteration": _part((dancers, steps), -MAX_DEVIATION_S, MAX_DEVIATION_S),
        "robot": _part((ROBOT_WIDTH,), robot_low, robot),
        "tracked": _part((dancers, JOINT_COUNT), 0.0, 1.0),
    }


def _part(shape: tuple[int, ...], low: float | list[float], high: float | list[float]) -> Part:
    return Part(shape, np.broadcast_to(np.float32(low), shape), np.broadcast_to(np.float32(high), shape))  # type: ignore[arg-type]


@compiled_entry
def _write(
    t_s: float,
    line: tuple[float, float],
    last_s: Array,
    sent_s: float,
    reported_s: float,
    joints: Array,
    state: NDArray[np.int8],
    dancers: IntArray,
    starts: tuple[int, int, int, int, int, int],
    row: Row,
) -> None:
    """Write the numbers that differ at every instant.

    Args:
        t_s: session time.
        line: see `write_time_features`.
        last_s: see `write_time_features`.
        sent_s: time at which the command in force was sent.
        reported_s: time of the robot's last report.
        joints: (P, 25, 3) skeletons [m].
        state: (P, 25) their tracking states.
        dancers: (P,) index of each person in the cast; -1 for somebody unknown.
        starts: places in the row at which beat, event_age, joints and tracked start, and of the ages in command and
            robot.
        row: (N,) output.
    """
    beats, ages, joints_start, tracked_start, command_age, robot_age = starts
    write_time_features(t_s, line, last_s, row[beats:], row[ages:])
    row[command_age] = min(t_s - sent_s, MAX_AGE_S)
    row[robot_age] = min(t_s - reported_s, MAX_AGE_S)

    # Dancers without a skeleton have zeros.
    dancer_count = len(last_s)
    row[joints_start : joints_start + dancer_count * JOINT_COUNT * 3] = 0.0
    row[tracked_start : tracked_start + dancer_count * JOINT_COUNT] = 0.0
    for person, dancer in enumerate(dancers):
        if dancer < 0:
            continue
        for k in range(JOINT_COUNT):
            place = dancer * JOINT_COUNT + k
            row[tracked_start + place] = 0.5 * state[person, k]
            for axis in range(3):
                value_m = joints[person, k, axis]
                row[joints_start + 3 * place + axis] = 0.0 if math.isnan(value_m) else value_m


class Observer:
    """Keeps the observation of a session up to date, as one row of numbers of which the named parts are views.

    One compiled call writes the numbers that differ at every instant; the others are written when they change.

    Args:
        config: a session of the observed kind.
        steps: number of events that the dance expects of the robot in an iteration.
        sensors: names of the sensors.
    """

    def __init__(self, config: SessionConfig, steps: int, sensors: tuple[str, ...]) -> None:
        self._parts = observation_parts(config, steps, len(sensors))
        self._sensor_index = {name: index for index, name in enumerate(sensors)}
        self._max_speed_m_s = 2.0 * config.robot.max_speed_m_s
        self._max_yaw_rate_rad_s = 2.0 * config.robot.max_yaw_rate_rad_s

        ends = np.cumsum([math.prod(part.shape) for part in self._parts.values()]).tolist()
        self._begins = [0, *ends[:-1]]
        self._row: Row = np.zeros(ends[-1], dtype=np.float32)
        self._views: dict[str, Row] = {
            name: self._row[begin:end].reshape(part.shape)
            for (name, part), begin, end in zip(self._parts.items(), self._begins, ends, strict=True)
        }

        starts = dict(zip(self._parts, self._begins, strict=True))
        self._starts = (
            starts["beat"],
            starts["event_age"],
            starts["joints"],
            starts["tracked"],
            starts["command"] + COMMAND_AGE,
            starts["robot"] + ROBOT_AGE,
        )
        self._buffers: list[tuple[Row, dict[str, Row]]] = []

    @property
    def flat_space(self) -> spaces.Box:
        """Space of `flat_observation`."""
        low = np.concatenate([part.low.ravel() for part in self._parts.values()])
        high = np.concatenate([part.high.ravel() for part in self._parts.values()])
        return spaces.Box(low, high, dtype=np.float32)

    @property
    def space(self) -> spaces.Dict:
        """Space of `named_observation`."""
        boxes = [(name, spaces.Box(part.low, part.high, dtype=np.float32)) for name, part in self._parts.items()]
        return spaces.Dict(boxes)

    def reset(self, session: Session) -> None:
        """Start to observe a session."""
        self._session = session
        self._features = EventFeatures(session.context)
        self._event_count = 0
        self._row[:] = 0.0
        self._write_command(None)
        self._write_robot(None)
        self._sensor = ""
        self._cast_indices: Mapping[int, int] = {}
        self._persons = NO_SKELETONS.persons
        self._dancers = self._persons

    def flat_observation(self, now: float) -> Row:
        """A new (N,) row, observed at a session time [s]."""
        self._update(now)
        return self._row.copy()

    def named_observation(self, now: float) -> dict[str, Row]:
        """A new dictionary of parts, observed at a session time [s]."""
        self._update(now)
        if not self._buffers:
            self._allocate_buffers()
        row, named = self._buffers.pop()
        row[:] = self._row
        return named

    def _allocate_buffers(self) -> None:
        """Allocate observations, each in a row of its own; many at a time take a third of the time for each."""
        rows = np.empty((BUFFER_ROWS, len(self._row)), dtype=np.float32)
        columns = [
            rows[:, begin : begin + view.size].reshape(BUFFER_ROWS, *view.shape)
            for begin, view in zip(self._begins, self._views.values(), strict=True)
        ]
        named = [dict(zip(self._views, views, strict=True)) for views in zip(*columns, strict=True)]
        self._buffers = list(zip(rows, named, strict=True))

    def _update(self, now: float) -> None:
        """Write what has changed until a session time [s]."""
        session = self._session
        features = self._features
        if len(session.events) > self._event_count:
            self._add_events()
        new_iteration = features.advance_to(now)
        if new_iteration:
            self._views["iteration"][0] = features.iteration
            self._views["last_iteration"][:] = features.last_iteration

        dispatcher = session.dispatcher
        if dispatcher.current is not self._command:
            self._write_command(dispatcher.current)
        if new_iteration or dispatcher.state is not self._robot_state:
            self._write_robot(dispatcher.state)

        if session.server.active != self._sensor:
            self._write_active_sensor(session.server.active)
        frame = session.world.latest_frame(self._sensor)
        skeletons = NO_SKELETONS if frame is None else frame.skeletons
        self._match_dancers(skeletons)
        _write(
            now,
            features.line,
            features.last_s,
            self._sent_s,
            self._reported_s,
            skeletons.joints,
            skeletons.state,
            self._dancers,
            self._starts,
            self._row,
        )

    def _add_events(self) -> None:
        """Add the events since the last update to the features."""
        for event in self._session.events[self._event_count :]:
            self._features.add(event)
        self._event_count = len(self._session.events)

    def _match_dancers(self, skeletons: Skeletons) -> None:
        """Find the dancers of skeletons, unless neither persons nor their identities have changed."""
        indices = self._session.server.cast_indices(self._sensor)
        if indices is not self._cast_indices or skeletons.persons is not self._persons:
            self._cast_indices = indices
            self._persons = skeletons.persons
            found = [indices.get(person, -1) for person in skeletons.persons.tolist()]
            self._dancers = np.array(found, dtype=np.int64)

    def _write_command(self, command: MoveCommand | None) -> None:
        """Write move, speed and yaw rate of the command in force; before the first one the robot stands."""
        self._command = command
        move = Move.STOP
        speed_m_s = 0.0
        yaw_rate_rad_s = 0.0
        self._sent_s = -math.inf
        if command is not None:
            self._sent_s = command.t_start_s
            move = command.move
            speed_m_s = -command.speed_m_s if move is Move.BACKWARD else command.speed_m_s
            yaw_rate_rad_s = command.yaw_rate_rad_s

        view = self._views["command"]
        view[: len(MOVES)] = [move is known for known in MOVES]
        view[COMMAND_AGE + 1 :] = (speed_m_s, yaw_rate_rad_s)

    def _write_robot(self, state: RobotState | None) -> None:
        """Write the odometry estimate relative to the robot's slot and the heading before the iteration's turn."""
        self._robot_state = state
        if state is None:
            self._reported_s = -math.inf
            return

        session = self._session
        self._reported_s = state.t_s
        heading_rad = session.timetable.heading_rad(max(self._features.iteration, 1))
        x_m = state.x_m - float(session.layout.robot[0])
        y_m = state.y_m - float(session.layout.robot[1])
        cos = math.cos(heading_rad)
        sin = math.sin(heading_rad)
        self._views["robot"][:ROBOT_AGE] = (
            _clip(x_m * cos + y_m * sin, MAX_POSITION_M),
            _clip(y_m * cos - x_m * sin, MAX_POSITION_M),
            math.remainder(state.heading_rad - heading_rad, math.tau),
            _clip(state.step_m * session.config.robot.odometry_hz, self._max_speed_m_s),
            _clip(state.yaw_rate_rad_s, self._max_yaw_rate_rad_s),
        )

    def _write_active_sensor(self, sensor: str) -> None:
        self._sensor = sensor
        self._views["client"][:] = 0.0
        self._views["client"][self._sensor_index[sensor]] = 1.0


def _clip(value: float, limit: float) -> float:
    """The value within -limit and limit; `numpy.clip` takes longer for one number."""
    return min(max(value, -limit), limit)
