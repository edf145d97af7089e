"""What the agent sees: everything the server knows, and the skeletons its active client saw; never the truth."""

from __future__ import annotations

import math

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from sjasim.anticipation.features import LATEST_S, MOVES, OLDEST_S, PERIODS, Features
from sjasim.config import SessionConfig
from sjasim.session import Session
from sjasim.types import SYNCHRONY_KINDS, Move, MoveCommand, SkeletonFrame

Row = NDArray[np.float32]

REACH_M = 10.0
"""Bound of every position [m]."""

_JOINTS = 25
_CODE = np.array([0.0, 0.5, 1.0], dtype=np.float32)
_PLACE = {move: index for index, move in enumerate(MOVES)}


def parts(config: SessionConfig, steps: int, clients: int) -> dict[str, tuple[tuple[int, ...], Row, Row]]:
    """Name -> (shape, lowest, highest) of every part of an observation, in alphabetical order.

    Args:
        config: the session; dancers and the robot's limits count.
        steps: events that the dance wants of the robot in an iteration.
        clients: sensors.
    """
    speed, yaw = config.robot.max_speed_m_s, config.robot.max_yaw_rate_rad_s
    command = [1.0, 1.0, 1.0, 1.0, OLDEST_S, speed, yaw]
    robot = [REACH_M, REACH_M, math.pi, 2 * speed, 2 * yaw, OLDEST_S]
    dancers = config.group
    bounds: dict[str, tuple[tuple[int, ...], object, object]] = {
        "beat": ((1 + 2 * len(PERIODS),), -2.0, 2.0),
        "client": ((clients,), 0.0, 1.0),
        "command": ((7,), [0.0, 0.0, 0.0, 0.0, 0.0, -speed, -yaw], command),
        "event_age": ((dancers, len(SYNCHRONY_KINDS), 2), 0.0, OLDEST_S),
        "iteration": ((1,), 0.0, float(config.iterations)),
        "joints": ((dancers, _JOINTS, 3), -REACH_M, REACH_M),
        "last_iteration": ((dancers, steps), -LATEST_S, LATEST_S),
        "robot": ((6,), [*(-value for value in robot[:5]), 0.0], robot),
        "tracked": ((dancers, _JOINTS), 0.0, 1.0),
    }
    return {
        name: (shape, np.broadcast_to(np.float32(low), shape), np.broadcast_to(np.float32(high), shape))  # type: ignore[arg-type]
        for name, (shape, low, high) in bounds.items()
    }


class Observer:
    """Fills one flat row per step; its named parts are slices of it.

    Args:
        config: any session with the shapes that are to be observed.
        steps: events that the dance wants of the robot in an iteration.
        clients: names of the sensors.
    """

    def __init__(self, config: SessionConfig, steps: int, clients: tuple[str, ...]) -> None:
        self._parts = parts(config, steps, len(clients))
        self._clients = clients
        sizes = [math.prod(shape) for shape, _, _ in self._parts.values()]
        ends = np.cumsum(sizes).tolist()
        self._slices = {name: slice(end - size, end) for name, size, end in zip(self._parts, sizes, ends, strict=True)}
        self._low = np.concatenate([low.ravel() for _, low, _ in self._parts.values()])
        self._high = np.concatenate([high.ravel() for _, _, high in self._parts.values()])
        self._row = np.zeros(ends[-1], dtype=np.float32)
        self._views = {name: self._row[self._slices[name]].reshape(self._parts[name][0]) for name in self._parts}

    @property
    def flat_space(self) -> spaces.Box:
        """Space of whole rows."""
        return spaces.Box(self._low, self._high, dtype=np.float32)

    @property
    def space(self) -> spaces.Dict:
        """Space of the named parts."""
        return spaces.Dict([(name, spaces.Box(low, high, dtype=np.float32))
                            for name, (_, low, high) in self._parts.items()])  # fmt: skip

    def reset(self, session: Session) -> None:
        """Begin to watch a session."""
        self._session = session
        self._features = Features(session.brief)
        self._told = 0
        self._frame: SkeletonFrame | None = None
        self._row[:] = 0.0

    def named(self, row: Row) -> dict[str, Row]:
        """The parts of a row, as views of it."""
        return {name: row[self._slices[name]].reshape(shape) for name, (shape, _, _) in self._parts.items()}

    def row(self) -> Row:
        """A fresh (N,) row of what is known now."""
        session, views, features = self._session, self._views, self._features
        now = session.time_s
        for event in session.events[self._told :]:
            features.add(event)
        self._told = len(session.events)
        views["beat"][:] = features.beat(now)
        views["event_age"][:] = features.event_age(now)
        views["iteration"][:] = features.iteration(now)
        views["last_iteration"][:] = features.last_iteration(now)
        views["command"][:] = _command(now, session.dispatcher.current)
        self._see_robot(now, features.iteration(now))
        active = session.server.active
        views["client"][:] = 0.0
        views["client"][self._clients.index(active)] = 1.0
        self._see_dancers(session.world.latest(active))
        row: Row = np.maximum(self._row, self._low)
        np.minimum(row, self._high, out=row)
        return row

    def _see_robot(self, now: float, iteration: int) -> None:
        """Odometry from its slot, along the heading that the iteration has before its turn."""
        session = self._session
        state = session.dispatcher.state
        if state is None:
            self._views["robot"][:] = (0.0, 0.0, 0.0, 0.0, 0.0, OLDEST_S)
            return
        heading = session.timetable.heading_rad(max(iteration, 1))
        x, y = state.x_m - session.layout.robot[0], state.y_m - session.layout.robot[1]
        cos, sin = math.cos(heading), math.sin(heading)
        self._views["robot"][:] = (
            x * cos + y * sin,
            y * cos - x * sin,
            math.remainder(state.heading_rad - heading, math.tau),
            state.step_m * session.config.robot.odometry_hz,
            state.yaw_rate_rad_s,
            now - state.t_s,
        )

    def _see_dancers(self, frame: SkeletonFrame | None) -> None:
        """Skeletons in the sensor's own axes, in the order of the cast; zeros for whom or what it does not see."""
        if frame is self._frame:
            return
        self._frame = frame
        joints, tracked = self._views["joints"], self._views["tracked"]
        joints[:] = 0.0
        tracked[:] = 0.0
        if frame is None:
            return
        names = [self._session.server.name(frame.sensor, int(person)) for person in frame.skeletons.persons]
        cast = self._session.brief.cast
        known = [(row, cast.index(name)) for row, name in enumerate(names) if name is not None]
        rows, places = [row for row, _ in known], [place for _, place in known]
        seen = frame.skeletons.joints[rows]
        joints[places] = np.where(np.isnan(seen), 0.0, seen)
        tracked[places] = _CODE[frame.skeletons.state[rows]]


def _command(now: float, command: MoveCommand | None) -> tuple[float, ...]:
    """The move in force, one of four, the seconds since it was sent, its speed and its yaw rate."""
    if command is None:
        return 1.0, 0.0, 0.0, 0.0, OLDEST_S, 0.0, 0.0
    chosen = [0.0] * len(MOVES)
    if command.move in _PLACE:
        chosen[_PLACE[command.move]] = 1.0
    sign = -1.0 if command.move is Move.BACKWARD else 1.0
    return *chosen, now - command.t_start_s, sign * command.speed_m_s, command.yaw_rate_rad_s
