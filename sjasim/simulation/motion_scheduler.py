"""Decides and plans the dancers' motion: the human timing model's cues become rows of the reference trajectory."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence

import numpy as np

from ..choreography.layout import Layout
from ..choreography.timetable import Timetable
from ..config import SessionConfig
from ..core import Cue, Kind
from ..core.session_log import AgentEvent, Notice
from ..humans.body.anatomy import Anatomy
from ..humans.motion.planner import PREVIEW_S, Planner
from ..humans.motion.reference_trajectory import ReferenceTrajectory
from ..humans.timing.ensemble import PREPARATION_S
from ..humans.timing.replay import Replay
from ..session.dancers import cues_with_faults, make_human_timing, perceived_timing_error_s

REST_S = 0.7
"""Minimum rest between a dancer's last move of an iteration and the next iteration [s]; assumed: the sway of the turn
has to decay."""


class MotionScheduler:
    """Asks the human timing model for cues when they are due, and plans each move shortly before it begins.

    A move is planned as late as possible, so that it begins where the dancer then stands.

    Args:
        config: the session.
        timetable: the dance on the session's clock.
        layout: places of the dancers.
        anatomies: one for each dancer.
        reference: the trajectory that the plans are written to.
        robot: whether the dancers observe a robot.
        given_cues: cues of each dancer, in place of those that the timing model decides.

    Attributes:
        cues: all cues so far, in order of iteration and time.
        notices: notices of the timing model about its data.
        omega: (D,) pendulum rates of the dancers [1/s].
    """

    def __init__(
        self,
        config: SessionConfig,
        timetable: Timetable,
        layout: Layout,
        anatomies: Sequence[Anatomy],
        reference: ReferenceTrajectory,
        *,
        robot: bool,
        given_cues: Sequence[Sequence[Cue]] | None = None,
    ) -> None:
        self._timetable = timetable
        self._faults = config.faults
        self._robot = robot
        self._timing = make_human_timing(config, timetable)
        self.notices: list[Notice] = list(self._timing.notices) if isinstance(self._timing, Replay) else []

        heading_rad = timetable.heading_rad(timetable.first)
        self._planners = [
            Planner(
                anatomy,
                layout.dancers[index],
                heading_rad,
                config.dance.step_m,
                timetable.choreography.turn_rad,
                config.physics.control_hz,
                reference.for_dancer(index),
            )
            for index, anatomy in enumerate(anatomies)
        ]
        self.omega = np.array([planner.omega for planner in self._planners])

        self.cues: list[Cue] = []
        self._pending: list[deque[Cue]] = [deque() for _ in anatomies]
        self._busy_until_s = np.zeros(len(anatomies))
        self._next_iteration = timetable.first
        self._begin_s = 0.0
        self.decide_due_s = 0.0
        self.plan_due_s = 0.0
        if given_cues is not None:
            self._take_given(given_cues)

    def _take_given(self, given_cues: Sequence[Sequence[Cue]]) -> None:
        """Let everything be decided from the beginning."""
        for pending, cues in zip(self._pending, given_cues, strict=True):
            pending.extend(cues)
            self.cues.extend(cues)
        self.decide_due_s = math.inf

    def update(self, now: float, robot_events: Sequence[AgentEvent], fallen: Sequence[bool]) -> None:
        """Decide and plan what is due.

        Args:
            now: session time [s].
            robot_events: what the robot did so far.
            fallen: for each dancer, whether they have fallen and move no more.
        """
        if now >= self.decide_due_s:
            self.decide(now, robot_events, fallen)
        if now >= self.plan_due_s:
            self.plan(now, fallen)

    def decide(self, now: float, robot_events: Sequence[AgentEvent], fallen: Sequence[bool]) -> None:
        """Ask the timing model for the next cues; people decide some beats ahead."""
        if now >= self._begin_s and self._timing.next_due_s == math.inf:
            self._begin_iteration(now, robot_events)

        decided = self._timing.decide(now, self._observed_robot_events(robot_events))
        for index, cues in enumerate(decided):
            if fallen[index] or not cues:
                continue
            performed = cues_with_faults(cues, self._faults)
            self._pending[index].extend(performed)
            self.cues.extend(performed)
            if performed:
                self._busy_until_s[index] = max(cue.t_s + cue.duration_s for cue in performed) + REST_S
        self.cues.sort(key=lambda cue: (cue.iteration, cue.t_s))

        due_s = self._timing.next_due_s
        self.decide_due_s = due_s if due_s < math.inf else self._begin_s
        self.plan_due_s = now

    def plan(self, now: float, fallen: Sequence[bool]) -> None:
        """Plan every move that begins within the planner's preview."""
        ahead_s = now + PREVIEW_S
        for planner, pending, has_fallen in zip(self._planners, self._pending, fallen, strict=True):
            while pending and pending[0].t_s <= ahead_s:
                cue = pending.popleft()
                if not has_fallen:
                    planner.extend([cue], now)
        self.plan_due_s = min((pending[0].t_s for pending in self._pending if pending), default=math.inf) - PREVIEW_S

    def _begin_iteration(self, now: float, robot_events: Sequence[AgentEvent]) -> None:
        """Begin the next iteration; the one after it begins when this one's window has closed."""
        iteration = self._next_iteration
        self._next_iteration += 1
        self._begin_s = self._timetable.close_s(iteration) if iteration < self._timetable.last else math.inf
        not_before_s = np.maximum(self._busy_until_s, now + PREPARATION_S)
        self._timing.begin(iteration, self._appropriateness_s(iteration - 1, robot_events), not_before_s)

    def _observed_robot_events(self, robot_events: Sequence[AgentEvent]) -> list[tuple[Kind, float]]:
        """What the robot has done in the iteration that is being decided, as the dancers see it."""
        iteration = self._next_iteration - 1
        return [(event.kind, event.t_s) for event in robot_events if event.iteration == iteration]

    def _appropriateness_s(self, iteration: int, robot_events: Sequence[AgentEvent]) -> float | None:
        """Mean timing error of the robot as the dancers perceive it [s]; None where it did not dance."""
        if not self._robot or iteration < 1:
            return None
        return perceived_timing_error_s(
            [cue for cue in self.cues if cue.iteration == iteration],
            [event for event in robot_events if event.iteration == iteration],
        )
