"""Asks the human timing model for the dancers' cues when they are due."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ..choreography.timetable import Timetable
from ..config import SessionConfig
from ..core import Cue, Kind
from ..core.session_log import AgentEvent, Notice
from ..humans.timing.ensemble import PREPARATION_S
from ..humans.timing.replay import Replay
from .dancers import cues_with_faults, make_human_timing, perceived_timing_error_s

REST_S = 0.7
"""Minimum rest between a dancer's last move of an iteration and the next iteration [s]; assumed: the sway of the turn
has to decay."""


class CueScheduler:
    """Calls the human timing model of a session, and collects the cues that the dancers perform.

    An iteration begins for the dancers when the window of the one before it has closed.

    Args:
        config: the session.
        timetable: the dance on the session's clock.
        robot: whether the dancers observe a robot.
        given_cues: cues of each dancer, in place of those that the timing model decides.

    Attributes:
        cues: all cues so far, in order of iteration and time.
        notices: notices of the timing model about its data.
        due_s: session time at which `decide` is to be called next [s]; infinite after the last iteration.
    """

    def __init__(
        self,
        config: SessionConfig,
        timetable: Timetable,
        *,
        robot: bool,
        given_cues: Sequence[Sequence[Cue]] | None = None,
    ) -> None:
        self._timetable = timetable
        self._faults = config.faults
        self._robot = robot
        self._timing = make_human_timing(config, timetable)
        self._busy_until_s = np.zeros(config.dancers)
        self._next_iteration = timetable.first
        self._begin_s = 0.0

        self.notices: list[Notice] = list(self._timing.notices) if isinstance(self._timing, Replay) else []
        self.cues: list[Cue] = [cue for own in given_cues or () for cue in own]
        self.due_s = 0.0 if given_cues is None else math.inf

    def decide(
        self, now: float, robot_events: Sequence[AgentEvent], fallen: Sequence[bool] | None = None
    ) -> list[tuple[Cue, ...]]:
        """Ask the timing model for the next cues; people decide some beats ahead.

        Args:
            now: session time [s].
            robot_events: what the robot did so far.
            fallen: for each dancer, whether they have fallen and move no more; None if nobody can fall.

        Returns:
            the new cues of each dancer, with the faults of the session.
        """
        if now >= self._begin_s and self._timing.next_due_s == math.inf:
            self._begin_iteration(now, robot_events)

        performed: list[tuple[Cue, ...]] = []
        for index, decided in enumerate(self._timing.decide(now, self._observed_robot_events(robot_events))):
            is_able = fallen is None or not fallen[index]
            cues = cues_with_faults(decided, self._faults) if is_able else ()
            if cues:
                self._busy_until_s[index] = max(cue.t_s + cue.duration_s for cue in cues) + REST_S
            performed.append(cues)
            self.cues.extend(cues)
        self.cues.sort(key=_iteration_and_time)

        due_s = self._timing.next_due_s
        self.due_s = due_s if due_s < math.inf else self._begin_s
        return performed

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


def _iteration_and_time(cue: Cue) -> tuple[int, float]:
    """Sorting key of cues."""
    return cue.iteration, cue.t_s
