"""The reward: timing of the robot's events relative to the dancers, and costs of errors, collisions and drift."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from gymnasium import error

from sjasim.analysis.group_metrics import group_metrics
from sjasim.anticipation.event_history import nominal_times
from sjasim.anticipation.observation import iteration_at
from sjasim.anticipation.timing_appropriateness import ideal_times
from sjasim.core import Event, Kind
from sjasim.core.session_log import AgentEvent
from sjasim.session.session import Session
from sjasim.simulation.physics import Physics

TERMS = ("timing", "missed", "spurious", "collision", "drift")
"""Terms of the reward; ``info`` has each of them as ``reward_TERM``."""

ZERO_TERMS = dict.fromkeys([f"reward_{term}" for term in TERMS], 0.0)
"""The terms of a step in which nothing happens."""

ARRIVAL_MARGIN_S = 0.5
"""Time after an iteration's window at which the iteration is closed [s]; all its events have arrived by then."""

CHECK_INTERVAL_S = 0.1
"""Time between two checks for collisions and drift [s]. A result applies to the time since the last check."""


@dataclass(frozen=True, slots=True)
class RewardConfig:
    """Weights of the reward.

    Attributes:
        timing: reward of an event exactly at the dancers' mean time; it decreases by as much for every second of error.
        worst_s: error from which on the reward does not decrease further.
        missed: cost of a step that the robot did not dance.
        spurious: cost of an event without a step, or of a second event for a step.
        collision: cost of every second of contact with a dancer.
        drift: cost of every second and metre outside the lane.
        lane_m: half the width of the lane, which extends from the robot's slot over the length of a move.
        worst_m: distance outside the lane from which on the cost does not increase further.
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
    def from_mapping(cls, weights: Mapping[str, float]) -> RewardConfig:
        """Make the configuration from some weights by name; the others have their defaults.

        Raises:
            error.Error: a weight does not exist, or is not a number from 0 to 1000.
        """
        known = [item.name for item in dataclasses.fields(cls)]
        if not isinstance(weights, Mapping):
            raise error.Error(f"reward = {weights!r} is not allowed: weights by name, of {', '.join(known)}")
        for name, value in weights.items():
            if name not in known:
                raise error.Error(f"reward.{name}: no such weight; known are {', '.join(known)}")
            number = isinstance(value, int | float) and not isinstance(value, bool)
            if not number or not 0.0 <= value <= 1000.0:
                raise error.Error(f"reward.{name} = {value!r} is not allowed: a number from 0 to 1000")
        return cls(**weights)


class Scorer:
    """Computes the reward of a session, step by step of the environment.

    The timing of a step of the score is rewarded once the robot and all dancers have danced it, or when its iteration
    is closed. The error is the distance from the mean of the dancers' logged times, as in timing appropriateness. The
    first robot event that is nearest to a step counts for it. Every further one is spurious, and so is every robot
    event of the rehearsal.

    Args:
        session: the session to score.
        physics: its physics.
        config: weights of the reward.

    Attributes:
        terms: terms of the last update, named as in `ZERO_TERMS`.
    """

    def __init__(self, session: Session, physics: Physics, config: RewardConfig) -> None:
        self._session = session
        self._physics = physics
        self._config = config
        self.terms = ZERO_TERMS.copy()

        # Times after beat 0 of the iteration [s], by iteration and step; NaN where nothing has been seen yet.
        context = session.context
        shape = (context.iterations + 1, len(context.steps))
        self._expected_s = np.array([nominal_times(context, iteration) for iteration in range(shape[0])])
        self._dancers_s = np.full((shape[0], len(context.cast), shape[1]), np.nan)
        self._robot_s = np.full(shape, np.nan)
        self._scored = np.zeros(shape, dtype=bool)
        self._ordinals: dict[Kind, list[int]] = {}
        for step in context.steps:
            self._ordinals.setdefault(step.kind, []).append(step.ordinal)

        self._event_count = 0
        self._robot_event_count = 0
        self._open_iteration = 1
        self._close_due_s = context.window_end_s[1] + ARRIVAL_MARGIN_S

        self._slot_x_m = float(session.layout.robot[0])
        self._slot_y_m = float(session.layout.robot[1])
        self._checked_s = session.time_s
        self._lane_direction = (0.0, 1.0)
        self._lane_until_s = -math.inf

    def update(self, now: float) -> dict[str, object]:
        """Compute the terms of the time since the last update.

        Args:
            now: session time [s].

        Returns:
            the figures of an iteration that has been closed meanwhile, see `iteration_figures`; else an empty
            dictionary.
        """
        session = self._session
        self.terms = ZERO_TERMS.copy()
        if len(session.events) > self._event_count:
            for event in session.events[self._event_count :]:
                self._add_dancer_event(event)
            self._event_count = len(session.events)

        robot_events = session.world.robot_events
        if len(robot_events) > self._robot_event_count:
            for robot_event in robot_events[self._robot_event_count :]:
                self._add_robot_event(robot_event)
            self._robot_event_count = len(robot_events)

        if now >= self._checked_s + CHECK_INTERVAL_S - 1e-9:
            self._check_robot(now, now - self._checked_s)
            self._checked_s = now
        return self._close_iteration() if now >= self._close_due_s else {}

    def _nearest_step(self, iteration: int, kind: Kind, after_s: float) -> int | None:
        """The step of a kind that is expected nearest to a time after beat 0 [s]; None if no step has this kind."""
        ordinals = self._ordinals.get(Kind.CLAP if kind is Kind.TURN else kind)
        if not ordinals:
            return None
        return min(ordinals, key=lambda ordinal: abs(self._expected_s[iteration, ordinal] - after_s))

    def _add_dancer_event(self, event: Event) -> None:
        """Assign a regular event of a dancer to a step, and score the step if it is complete."""
        context = self._session.context
        if event.early or event.person not in context.cast or not 1 <= event.iteration <= context.iterations:
            return
        after_s = event.t_s - context.iteration_start_s[event.iteration]
        step = self._nearest_step(event.iteration, event.kind, after_s)
        if step is None:
            return

        # Of several events the one nearest to the expected time counts. NaN, for none so far, compares as False.
        place = (event.iteration, context.cast.index(event.person), step)
        expected_s = self._expected_s[event.iteration, step]
        if not abs(self._dancers_s[place] - expected_s) <= abs(after_s - expected_s):
            self._dancers_s[place] = after_s
        self._score_if_complete(event.iteration, step)

    def _add_robot_event(self, event: AgentEvent) -> None:
        """Assign an event of the robot to a step, or charge it as spurious."""
        context = self._session.context
        iteration = event.iteration
        step = None
        if 1 <= iteration <= context.iterations:
            after_s = event.t_s - context.iteration_start_s[iteration]
            step = self._nearest_step(iteration, event.kind, after_s)

        if step is None or self._scored[iteration, step] or np.isfinite(self._robot_s[iteration, step]):
            self.terms["reward_spurious"] -= self._config.spurious
            return
        self._robot_s[iteration, step] = after_s
        self._score_if_complete(iteration, step)

    def _score_if_complete(self, iteration: int, step: int) -> None:
        """Score a step that the robot and all dancers have danced, unless it has been scored."""
        robot_known = np.isfinite(self._robot_s[iteration, step])
        complete = robot_known and np.isfinite(self._dancers_s[iteration, :, step]).all()
        if complete and not self._scored[iteration, step]:
            self._score(iteration, step)

    def _score(self, iteration: int, step: int) -> None:
        """Reward the robot's timing of a step; a step that no dancer danced has no ideal time and earns nothing."""
        self._scored[iteration, step] = True
        ideal_s = float(ideal_times(self._dancers_s[iteration, :, step : step + 1])[0])
        error_s = abs(float(self._robot_s[iteration, step]) - ideal_s)
        if math.isfinite(error_s):
            self.terms["reward_timing"] += self._config.timing * (1.0 - min(error_s, self._config.worst_s))

    def _close_iteration(self) -> dict[str, object]:
        """Score the remaining steps of the iteration, charge the missed ones, and return its figures."""
        iteration = self._open_iteration
        window_end_s = self._session.context.window_end_s
        self._open_iteration += 1
        last = self._open_iteration >= len(window_end_s)
        self._close_due_s = math.inf if last else window_end_s[self._open_iteration] + ARRIVAL_MARGIN_S

        for step in np.flatnonzero(~self._scored[iteration]).tolist():
            if np.isfinite(self._robot_s[iteration, step]):
                self._score(iteration, step)
            else:
                self._scored[iteration, step] = True
                self.terms["reward_missed"] -= self._config.missed
        return iteration_figures(self._session, iteration)

    def _check_robot(self, now: float, interval_s: float) -> None:
        """Charge contacts with dancers, and the distance from the lane."""
        config = self._config
        if self._physics.contacts.robot_touches_dancer():
            self.terms["reward_collision"] -= config.collision * interval_s
        if now > self._lane_until_s:
            self._update_lane(now)

        robot_x_m, robot_y_m, _ = self._physics.robot_pose()
        x_m = robot_x_m - self._slot_x_m
        y_m = robot_y_m - self._slot_y_m
        cos, sin = self._lane_direction
        along_m = x_m * cos + y_m * sin
        across_m = y_m * cos - x_m * sin
        beyond_m = along_m - min(max(along_m, 0.0), self._session.config.dance.step_m)
        outside_m = min(math.hypot(beyond_m, across_m) - config.lane_m, config.worst_m)
        if outside_m > 0.0:
            self.terms["reward_drift"] -= config.drift * outside_m * interval_s

    def _update_lane(self, now: float) -> None:
        """Turn the lane to the heading of the present iteration."""
        session = self._session
        iteration = iteration_at(session.context, now)
        heading_rad = session.timetable.heading_rad(max(iteration, 1))
        self._lane_direction = (math.cos(heading_rad), math.sin(heading_rad))
        last = iteration >= session.context.iterations
        self._lane_until_s = math.inf if last else session.context.window_end_s[iteration]


def iteration_figures(session: Session, iteration: int) -> dict[str, object]:
    """Figures of a completed iteration for ``info``, equal to those of session.json.

    Args:
        session: the session so far.
        iteration: number of the iteration, from 1.

    Returns:
        ``iteration_done``, ``gsi``, ``gsi_full_edges``, ``ta_mean_s`` (NaN if there is no value), ``event_errors_s``
        (signed errors of the robot's steps, NaN for a missed one), and ``robot_missed``.
    """
    logged = [
        AgentEvent(event.iteration, event.person, event.kind, event.t_s)
        for event in session.events
        if not event.early and event.iteration <= iteration
    ]
    events = [*logged, *session.world.robot_events]
    row = group_metrics(events, session.config, session.timetable, session.followed, iteration)[-1]

    # The robot is the last agent.
    robot_s = row.steps_s[-1]
    dancers_s = row.steps_s[:-1]
    finite = row.ta_s[np.isfinite(row.ta_s)]
    return {
        "iteration_done": iteration,
        "gsi": row.gsi,
        "gsi_full_edges": row.gsi_full_edges,
        "ta_mean_s": float(finite.mean()) if len(finite) else math.nan,
        "event_errors_s": robot_s - ideal_times(dancers_s),
        "robot_missed": int(np.isnan(robot_s).sum()),
    }
