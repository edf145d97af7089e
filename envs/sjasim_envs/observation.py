"""What the agent sees: everything the server knows, and the skeletons its active client saw; never the truth."""

from __future__ import annotations

import math

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from sjasim.anticipation.features import LATEST_S, OLDEST_S, PERIODS, Features
from sjasim.config import SessionConfig
from sjasim.session import Session
from sjasim.types import SYNCHRONY_KINDS, Move, MoveCommand, SkeletonFrame

Row = NDArray[np.float32]

REACH_M = 20.0
"""Bound of every position [m]: no sensor reaches farther."""

EARLIEST = -2.0
"""Least beat over 40 that is told, long before the music."""

_JOINTS = 25


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
        "beat": ((1 + 2 * len(PERIODS),), EARLIEST, -EARLIEST),
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
    """Keeps one flat row of numbers up to date; its named parts are views of it, and whoever asks gets copies.

    Args:
        config: any session with the shapes that are to be observed.
        steps: events that the dance wants of the robot in an iteration.
        clients: names of the sensors.
    """

    def __init__(self, config: SessionConfig, steps: int, clients: tuple[str, ...]) -> None:
        self._parts = parts(config, steps, len(clients))
        self._place = {name: index for index, name in enumerate(clients)}
        self._limits = 2.0 * config.robot.max_speed_m_s, 2.0 * config.robot.max_yaw_rate_rad_s
        ends = np.cumsum([math.prod(shape) for shape, _, _ in self._parts.values()]).tolist()
        self._row: Row = np.zeros(ends[-1], dtype=np.float32)
        self._views: dict[str, Row] = {
            name: self._row[end - math.prod(shape) : end].reshape(shape)
            for (name, (shape, _, _)), end in zip(self._parts.items(), ends, strict=True)
        }
        self._lost = np.zeros(self._parts["joints"][0], dtype=np.bool_)

    @property
    def flat_space(self) -> spaces.Box:
        """Space of whole rows."""
        low = np.concatenate([low.ravel() for _, low, _ in self._parts.values()])
        high = np.concatenate([high.ravel() for _, _, high in self._parts.values()])
        return spaces.Box(low, high, dtype=np.float32)

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

    def flat(self) -> Row:
        """A fresh (N,) row of what is known now."""
        self._look()
        return self._row.copy()

    def named(self) -> dict[str, Row]:
        """The same by name."""
        self._look()
        return {name: view.copy() for name, view in self._views.items()}

    def _look(self) -> None:
        session, views, features = self._session, self._views, self._features
        now = session.time_s
        for event in session.events[self._told :]:
            features.add(event)
        self._told = len(session.events)
        iteration = features.iteration(now)
        beat = features.beat(now)
        views["beat"][:] = beat if beat[0] >= EARLIEST else (EARLIEST, *beat[1:])
        views["event_age"][:] = features.event_age(now)
        views["iteration"][0] = iteration
        views["last_iteration"][:] = features.last_iteration(now)
        views["command"][:] = _command(now, session.dispatcher.current)
        views["robot"][:] = self._robot(now, iteration)
        active = session.server.active
        views["client"][:] = 0.0
        views["client"][self._place[active]] = 1.0
        self._see_dancers(session.world.latest(active))

    def _robot(self, now: float, iteration: int) -> tuple[float, ...]:
        """Odometry from its slot, along the heading that the iteration has before its turn."""
        session = self._session
        state = session.dispatcher.state
        if state is None:
            return 0.0, 0.0, 0.0, 0.0, 0.0, OLDEST_S
        heading = session.timetable.heading_rad(max(iteration, 1))
        x, y = state.x_m - float(session.layout.robot[0]), state.y_m - float(session.layout.robot[1])
        cos, sin = math.cos(heading), math.sin(heading)
        fastest, quickest = self._limits
        return (
            _bounded(x * cos + y * sin, REACH_M),
            _bounded(y * cos - x * sin, REACH_M),
            math.remainder(state.heading_rad - heading, math.tau),
            _bounded(state.step_m * session.config.robot.odometry_hz, fastest),
            _bounded(state.yaw_rate_rad_s, quickest),
            min(now - state.t_s, OLDEST_S),
        )

    def _see_dancers(self, frame: SkeletonFrame | None) -> None:
        """Skeletons in the sensor's own axes, in the order of the cast; zeros for whom or what it does not see."""
        if frame is self._frame:
            return
        self._frame = frame
        joints, tracked = self._views["joints"], self._views["tracked"]
        if frame is None:
            joints[:] = 0.0
            tracked[:] = 0.0
            return
        seen, state = frame.skeletons.joints, frame.skeletons.state
        name = self._session.server.name
        names = [name(frame.sensor, person) for person in frame.skeletons.persons.tolist()]
        cast = self._session.brief.cast
        if tuple(names) != cast:
            known = [(row, cast.index(name)) for row, name in enumerate(names) if name is not None]
            rows, places = [row for row, _ in known], [place for _, place in known]
            joints[:] = 0.0
            tracked[:] = 0.0
            joints[places] = seen[rows]
            tracked[places] = 0.5 * state[rows]
        else:
            joints[:] = seen
            np.multiply(state, 0.5, out=tracked, casting="same_kind")
        np.isnan(joints, out=self._lost)
        np.copyto(joints, 0.0, where=self._lost)


def _command(now: float, command: MoveCommand | None) -> tuple[float, ...]:
    """The move in force, one of four, the seconds since it was sent, its speed and its yaw rate."""
    if command is None:
        return 1.0, 0.0, 0.0, 0.0, OLDEST_S, 0.0, 0.0
    move = command.move
    chosen = (float(move is Move.STOP), float(move is Move.FORWARD), float(move is Move.BACKWARD),
              float(move is Move.TURN))  # fmt: skip
    speed = -command.speed_m_s if move is Move.BACKWARD else command.speed_m_s
    return *chosen, min(now - command.t_start_s, OLDEST_S), speed, command.yaw_rate_rad_s


def _bounded(value: float, limit: float) -> float:
    return min(max(value, -limit), limit)
