"""What the agent sees: everything the server knows, and the skeletons its active client saw; never the truth."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from gymnasium import spaces
from numba import njit
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
from sjasim.config import SessionConfig
from sjasim.core import SYNCHRONY_KINDS, Array, IntArray, Move, MoveCommand, RobotState, Skeletons
from sjasim.session.session import Session

REACH_M = 20.0
"""Bound of every position [m]: no sensor reaches farther."""

BLANK = 32
"""Observations that are prepared at once."""

_JOINTS = 25
_NOBODY = Skeletons(np.empty(0, dtype=np.int64), np.empty((0, _JOINTS, 3)), np.empty((0, _JOINTS), dtype=np.int8))
for _part in _NOBODY:
    _part.flags.writeable = False  # as real ones: the compiled code is the same

_AGE, _REPORTED = 4, 5
"""Where command and robot tell how old they are."""


def parts(config: SessionConfig, steps: int, clients: int) -> dict[str, tuple[tuple[int, ...], Row, Row]]:
    """Name -> (shape, lowest, highest) of every part of an observation, in alphabetical order.

    Args:
        config: the session; dancers and the robot's limits count.
        steps: events that the dance wants of the robot in an iteration.
        clients: sensors.
    """
    speed, yaw = config.robot.max_speed_m_s, config.robot.max_yaw_rate_rad_s
    command = [1.0, 1.0, 1.0, 1.0, MAX_AGE_S, speed, yaw]
    robot = [REACH_M, REACH_M, math.pi, 2 * speed, 2 * yaw, MAX_AGE_S]
    dancers = config.dancers
    bounds: dict[str, tuple[tuple[int, ...], object, object]] = {
        "beat": ((1 + 2 * len(PERIODS),), MIN_SCALED_BEAT, -MIN_SCALED_BEAT),
        "client": ((clients,), 0.0, 1.0),
        "command": ((7,), [0.0, 0.0, 0.0, 0.0, 0.0, -speed, -yaw], command),
        "event_age": ((dancers, len(SYNCHRONY_KINDS), 2), 0.0, MAX_AGE_S),
        "iteration": ((1,), 0.0, float(config.iterations)),
        "joints": ((dancers, _JOINTS, 3), -REACH_M, REACH_M),
        "last_iteration": ((dancers, steps), -MAX_DEVIATION_S, MAX_DEVIATION_S),
        "robot": ((6,), [*(-value for value in robot[:5]), 0.0], robot),
        "tracked": ((dancers, _JOINTS), 0.0, 1.0),
    }
    return {
        name: (shape, np.broadcast_to(np.float32(low), shape), np.broadcast_to(np.float32(high), shape))  # type: ignore[arg-type]
        for name, (shape, low, high) in bounds.items()
    }


@njit(cache=True)
def _write(
    t_s: float, line: tuple[float, float], last_s: Array, sent_s: float, reported_s: float, joints: Array,
    state: NDArray[np.int8], order: IntArray, starts: tuple[int, int, int, int, int, int], row: Row,
) -> None:  # fmt: skip
    """Write what is another at every instant.

    Args:
        t_s: session time.
        line: as in `tell`.
        last_s: the same.
        sent_s: when the command in force was sent.
        reported_s: when the robot reported last.
        joints: (P, 25, 3) as in `Skeletons` [m].
        state: (P, 25) the same.
        order: (P,) place of each person in the cast; -1 for somebody unknown.
        starts: where in the row beat, event_age, joints and tracked begin, and where command and robot have an age.
        row: (N,) to write.
    """
    beats, ages, seen_m, tracked, sent, reported = starts
    write_time_features(t_s, line, last_s, row[beats:], row[ages:])
    row[sent] = min(t_s - sent_s, MAX_AGE_S)
    row[reported] = min(t_s - reported_s, MAX_AGE_S)
    dancers = len(last_s)
    row[seen_m : seen_m + dancers * _JOINTS * 3] = 0.0
    row[tracked : tracked + dancers * _JOINTS] = 0.0
    for person, dancer in enumerate(order):
        if dancer < 0:
            continue
        for k in range(_JOINTS):
            place = dancer * _JOINTS + k
            row[tracked + place] = 0.5 * state[person, k]
            for axis in range(3):
                at_m = joints[person, k, axis]
                row[seen_m + 3 * place + axis] = 0.0 if math.isnan(at_m) else at_m


class Observer:
    """Keeps one flat row of numbers up to date; its named parts are views of it, and whoever asks gets copies.

    What is another at every instant is written by one compiled call; the rest when it changes.

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
        self._begins = [0, *ends[:-1]]
        starts = dict(zip(self._parts, self._begins, strict=True))
        self._views: dict[str, Row] = {
            name: self._row[starts[name] : end].reshape(shape)
            for (name, (shape, _, _)), end in zip(self._parts.items(), ends, strict=True)
        }
        whole = tuple(starts[name] for name in ("beat", "event_age", "joints", "tracked"))
        self._starts = *whole, starts["command"] + _AGE, starts["robot"] + _REPORTED
        self._blank: list[tuple[Row, dict[str, Row]]] = []

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
        self._features = EventFeatures(session.context)
        self._told = 0
        self._row[:] = 0.0
        self._follow(None)
        self._locate(None)
        self._active = ""
        self._known: Mapping[int, int] = {}
        self._persons = _NOBODY.persons
        self._order = self._persons

    def flat(self, now: float) -> Row:
        """A fresh (N,) row of what is known at this session time."""
        self._look(now)
        return self._row.copy()

    def named(self, now: float) -> dict[str, Row]:
        """The same by name."""
        self._look(now)
        if not self._blank:
            self._cut()
        row, named = self._blank.pop()
        row[:] = self._row
        return named

    def _cut(self) -> None:
        """Prepare empty observations, each in a row of its own; many at once take a third of the time."""
        sheet = np.empty((BLANK, len(self._row)), dtype=np.float32)
        columns = [
            sheet[:, begin : begin + view.size].reshape(BLANK, *view.shape)
            for begin, view in zip(self._begins, self._views.values(), strict=True)
        ]
        parts = [dict(zip(self._views, own, strict=True)) for own in zip(*columns, strict=True)]
        self._blank = list(zip(sheet, parts, strict=True))

    def _look(self, now: float) -> None:
        session, features = self._session, self._features
        if len(session.events) > self._told:
            self._hear()
        begun = features.advance_to(now)
        if begun:
            self._views["iteration"][0] = features.iteration
            self._views["last_iteration"][:] = features.last_iteration
        dispatcher, server = session.dispatcher, session.server
        if dispatcher.current is not self._command:
            self._follow(dispatcher.current)
        if begun or dispatcher.state is not self._state:
            self._locate(dispatcher.state)
        if server.active != self._active:
            self._turn_to(server.active)
        frame = session.world.latest_frame(self._active)
        seen = _NOBODY if frame is None else frame.skeletons
        known = server.cast_indices(self._active)
        if known is not self._known or seen.persons is not self._persons:
            self._known, self._persons = known, seen.persons
            self._order = np.array([known.get(person, -1) for person in seen.persons.tolist()], dtype=np.int64)
        _write(
            now, features.line, features.last_s, self._sent_s, self._reported_s, seen.joints, seen.state,
            self._order, self._starts, self._row,
        )  # fmt: skip

    def _hear(self) -> None:
        """Take in the events that have come since the last time."""
        for event in self._session.events[self._told :]:
            self._features.add(event)
        self._told = len(self._session.events)

    def _follow(self, command: MoveCommand | None) -> None:
        """The move in force, one of four, its speed and its yaw rate; before the first command the robot stands."""
        self._command = command
        if command is None:
            self._sent_s, chosen = -math.inf, (Move.STOP, 0.0, 0.0)
        else:
            speed = -command.speed_m_s if command.move is Move.BACKWARD else command.speed_m_s
            self._sent_s, chosen = command.t_start_s, (command.move, speed, command.yaw_rate_rad_s)
        view = self._views["command"]
        view[: len(MOVES)] = [chosen[0] is move for move in MOVES]
        view[_AGE + 1 :] = chosen[1:]

    def _locate(self, state: RobotState | None) -> None:
        """Odometry from the robot's slot, along the heading that the iteration has before its turn."""
        self._state = state
        if state is None:
            self._reported_s = -math.inf
            return
        session = self._session
        self._reported_s = state.t_s
        heading = session.timetable.heading_rad(max(self._features.iteration, 1))
        x, y = state.x_m - float(session.layout.robot[0]), state.y_m - float(session.layout.robot[1])
        cos, sin = math.cos(heading), math.sin(heading)
        fastest, quickest = self._limits
        self._views["robot"][:_REPORTED] = (
            _bounded(x * cos + y * sin, REACH_M),
            _bounded(y * cos - x * sin, REACH_M),
            math.remainder(state.heading_rad - heading, math.tau),
            _bounded(state.step_m * session.config.robot.odometry_hz, fastest),
            _bounded(state.yaw_rate_rad_s, quickest),
        )

    def _turn_to(self, sensor: str) -> None:
        """Another client is active."""
        self._active = sensor
        self._views["client"][:] = 0.0
        self._views["client"][self._place[sensor]] = 1.0


def _bounded(value: float, limit: float) -> float:
    return min(max(value, -limit), limit)
