"""Decides and plans the dancers' motion: the human timing model's cues become rows of the reference trajectory."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence

import numpy as np

from ..choreography.layout import Layout
from ..choreography.timetable import Timetable
from ..config import SessionConfig
from ..core import Cue
from ..core.session_log import AgentEvent, Notice
from ..humans.body.anatomy import Anatomy
from ..humans.motion.planner import PREVIEW_S, Planner
from ..humans.motion.reference_trajectory import ReferenceTrajectory
from ..session.cue_scheduler import CueScheduler


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
        self._scheduler = CueScheduler(config, timetable, robot=robot, given_cues=given_cues)
        self.notices: list[Notice] = self._scheduler.notices
        self.cues: list[Cue] = self._scheduler.cues

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
        self._pending: list[deque[Cue]] = [deque(own) for own in given_cues or [()] * len(anatomies)]
        self.plan_due_s = 0.0

    def update(self, now: float, robot_events: Sequence[AgentEvent], fallen: Sequence[bool]) -> None:
        """Decide and plan what is due.

        Args:
            now: session time [s].
            robot_events: what the robot did so far.
            fallen: for each dancer, whether they have fallen and move no more.
        """
        if now >= self._scheduler.due_s:
            self.decide(now, robot_events, fallen)
        if now >= self.plan_due_s:
            self.plan(now, fallen)

    def decide(self, now: float, robot_events: Sequence[AgentEvent], fallen: Sequence[bool]) -> None:
        """Ask the timing model for the next cues."""
        for pending, cues in zip(self._pending, self._scheduler.decide(now, robot_events, fallen), strict=True):
            pending.extend(cues)
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
