"""The reward: how well each of the robot's events fell together with the dancers', and what it did besides."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from gymnasium import error

from sjasim.analysis.group_metrics import group_metrics
from sjasim.anticipation.event_history import nominal_times
from sjasim.anticipation.observation import iteration_at
from sjasim.anticipation.timing_appropriateness import ideal_times
from sjasim.core import Array, Event, Kind
from sjasim.core.session_log import AgentEvent
from sjasim.session.session import Session
from sjasim.simulation.physics import Physics

NOTHING = dict.fromkeys([f"reward_{term}" for term in ("timing", "missed", "spurious", "collision", "drift")], 0.0)
"""What a step earns in which nothing happens, by the names that ``info`` uses."""

SETTLED_S = 0.5
"""How long after a window's end an iteration is settled: by then every event of it has arrived."""

LOOK_S = 0.1
"""How often it is looked where the robot is and whom it touches; each look stands for the time since the last."""


@dataclass(frozen=True, slots=True)
class RewardConfig:
    """Weights of the reward.

    Attributes:
        timing: of an event exactly at the dancers' mean; it falls by as much for every second beside it.
        worst_s: error beyond which an event is not worth less.
        missed: cost of a step that the robot did not dance.
        spurious: cost of an event that belongs to no step, or to one that is done.
        collision: cost of every second in touch with a dancer.
        drift: cost of every second and metre outside its lane.
        lane_m: half the width of the lane, which is the way of a move ahead of the robot's slot.
        worst_m: distance outside it beyond which a place does not cost more.
    """

    timing: float = 1.0
    worst_s: float = 2.0
    missed: float = 1.0
    spurious: float = 0.5
    collision: float = 1.0
    drift: float = 0.2
    lane_m: float = 0.15
    worst_m: float = 1.0

    @classmethod
    def of(cls, given: Mapping[str, float]) -> RewardConfig:
        """Weights from plain numbers.

        Raises:
            error.Error: a weight that does not exist, or one that is not a number from 0 to 1000.
        """
        known = [item.name for item in dataclasses.fields(cls)]
        if not isinstance(given, Mapping):
            raise error.Error(f"reward = {given!r} is not allowed: weights by name, of {', '.join(known)}")
        for name, value in given.items():
            if name not in known:
                raise error.Error(f"reward.{name}: no such weight; known are {', '.join(known)}")
            number = isinstance(value, int | float) and not isinstance(value, bool)
            if not number or not 0.0 <= value <= 1000.0:
                raise error.Error(f"reward.{name} = {value!r} is not allowed: a number from 0 to 1000")
        return cls(**given)


@dataclass(slots=True)
class Scorer:
    """Adds up the terms of one session, step by step.

    A step's timing is paid once the robot and all dancers have done it, else when its iteration is settled: the
    distance from the mean of the dancers' logged times, as timing appropriateness has it. The first robot event that
    is nearest to a step counts for it; every further one is spurious, and so is every one in the rehearsal.

    Attributes:
        session: what is judged.
        physics: its bodies.
        config: the weights.
        terms: what the last step earned, named as in `NOTHING`.
    """

    session: Session
    physics: Physics
    config: RewardConfig
    terms: dict[str, float] = field(default_factory=NOTHING.copy)
    _told: int = 0
    _danced: int = 0
    _iteration: int = 1
    _looked_s: float = field(init=False)
    _settled_s: float = field(init=False)
    _until_s: float = -math.inf
    _ahead: tuple[float, float] = (0.0, 1.0)
    _slot: tuple[float, float] = field(init=False)
    _expected: Array = field(init=False)
    _dancers: Array = field(init=False)
    _robot: Array = field(init=False)
    _paid: Array = field(init=False)
    _ordinals: dict[Kind, list[int]] = field(init=False)

    def __post_init__(self) -> None:
        context = self.session.context
        self._expected = np.array([nominal_times(context, iteration) for iteration in range(context.iterations + 1)])
        count = context.iterations + 1, len(context.steps)
        self._dancers = np.full((count[0], len(context.cast), count[1]), np.nan)
        self._robot = np.full(count, np.nan)
        self._paid = np.zeros(count, dtype=bool)
        self._ordinals = {}
        for step in context.steps:
            self._ordinals.setdefault(step.kind, []).append(step.ordinal)
        self._settled_s = context.window_end_s[1] + SETTLED_S
        self._slot = float(self.session.layout.robot[0]), float(self.session.layout.robot[1])
        self._looked_s = self.session.time_s

    def update(self, now: float) -> dict[str, object]:
        """Judge everything since the last time until now, a session time; `terms` holds what it earned.

        Returns:
            the figures of an iteration that has been settled meanwhile, else nothing.
        """
        session = self.session
        self.terms = NOTHING.copy()
        if len(session.events) > self._told:
            for event in session.events[self._told :]:
                self._hear(event)
            self._told = len(session.events)
        danced = session.world.robot_events
        if len(danced) > self._danced:
            for own in danced[self._danced :]:
                self._see(own)
            self._danced = len(danced)
        if now >= self._looked_s + LOOK_S - 1e-9:
            self._look(now, now - self._looked_s)
            self._looked_s = now
        return self._settle() if now >= self._settled_s else {}

    def _step(self, iteration: int, kind: Kind, after_s: float) -> int | None:
        """The step of this kind that is expected nearest to a time after an iteration's beat 0."""
        ordinals = self._ordinals.get(Kind.CLAP if kind is Kind.TURN else kind)
        return min(ordinals, key=lambda k: abs(self._expected[iteration, k] - after_s)) if ordinals else None

    def _hear(self, event: Event) -> None:
        context = self.session.context
        if event.early or event.person not in context.cast or not 1 <= event.iteration <= context.iterations:
            return
        after = event.t_s - context.iteration_start_s[event.iteration]
        step = self._step(event.iteration, event.kind, after)
        if step is None:
            return
        place = event.iteration, context.cast.index(event.person), step
        expected = self._expected[event.iteration, step]
        if not abs(self._dancers[place] - expected) <= abs(after - expected):
            self._dancers[place] = after
        self._pay_if_known(event.iteration, step)

    def _see(self, own: AgentEvent) -> None:
        context = self.session.context
        step = None
        if 1 <= own.iteration <= context.iterations:
            after = own.t_s - context.iteration_start_s[own.iteration]
            step = self._step(own.iteration, own.kind, after)
        if step is None or self._paid[own.iteration, step] or np.isfinite(self._robot[own.iteration, step]):
            self.terms["reward_spurious"] -= self.config.spurious
            return
        self._robot[own.iteration, step] = after
        self._pay_if_known(own.iteration, step)

    def _pay_if_known(self, iteration: int, step: int) -> None:
        known = np.isfinite(self._robot[iteration, step]) and np.isfinite(self._dancers[iteration, :, step]).all()
        if known and not self._paid[iteration, step]:
            self._pay(iteration, step)

    def _pay(self, iteration: int, step: int) -> None:
        self._paid[iteration, step] = True
        ideal = float(ideal_times(self._dancers[iteration, :, step : step + 1])[0])
        off = abs(float(self._robot[iteration, step]) - ideal)
        if math.isfinite(off):
            self.terms["reward_timing"] += self.config.timing * (1.0 - min(off, self.config.worst_s))

    def _settle(self) -> dict[str, object]:
        """Close the books of the iteration whose time has come."""
        iteration, ends_s = self._iteration, self.session.context.window_end_s
        self._iteration += 1
        self._settled_s = ends_s[self._iteration] + SETTLED_S if self._iteration < len(ends_s) else math.inf
        for step in np.flatnonzero(~self._paid[iteration]).tolist():
            if np.isfinite(self._robot[iteration, step]):
                self._pay(iteration, step)
            else:
                self._paid[iteration, step] = True
                self.terms["reward_missed"] -= self.config.missed
        return figures(self.session, iteration)

    def _look(self, now: float, interval_s: float) -> None:
        """Judge where the robot is, and whom it touches."""
        config, physics = self.config, self.physics
        if physics.contacts.robot_touches_dancer():
            self.terms["reward_collision"] -= config.collision * interval_s
        if now > self._until_s:
            self._face(now)
        x, y, _ = physics.robot_pose()
        x, y = x - self._slot[0], y - self._slot[1]
        cos, sin = self._ahead
        ahead, aside = x * cos + y * sin, y * cos - x * sin
        beyond = ahead - min(max(ahead, 0.0), self.session.config.dance.step_m)
        outside = min(math.hypot(beyond, aside) - config.lane_m, config.worst_m)
        if outside > 0.0:
            self.terms["reward_drift"] -= config.drift * outside * interval_s

    def _face(self, now: float) -> None:
        """The lane runs along the heading of the iteration whose window is open."""
        session, iteration = self.session, iteration_at(self.session.context, now)
        heading = session.timetable.heading_rad(max(iteration, 1))
        self._ahead = math.cos(heading), math.sin(heading)
        self._until_s = session.context.window_end_s[iteration] if iteration < session.context.iterations else math.inf


def figures(session: Session, iteration: int) -> dict[str, object]:
    """What ``info`` holds of an iteration that is over; the same figures that session.json has.

    Args:
        session: the dance so far.
        iteration: which, from 1.
    """
    logged = [
        AgentEvent(event.iteration, event.person, event.kind, event.t_s)
        for event in session.events
        if not event.early and event.iteration <= iteration
    ]
    events = [*logged, *session.world.robot_events]
    rows = group_metrics(events, session.config, session.timetable, session.followed, iteration)
    row = rows[-1]
    robot, dancers = row.steps_s[-1], row.steps_s[:-1]
    finite = row.ta_s[np.isfinite(row.ta_s)]
    return {
        "iteration_done": iteration,
        "gsi": row.gsi,
        "gsi_full_edges": row.gsi_full_edges,
        "ta_mean_s": float(finite.mean()) if len(finite) else math.nan,
        "event_errors_s": robot - ideal_times(dancers),
        "robot_missed": int(np.isnan(robot).sum()),
    }
