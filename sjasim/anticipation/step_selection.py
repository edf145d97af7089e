"""Conversion of the moves that a policy chooses to steps of the dance."""

from __future__ import annotations

from ..core.method_io import ROBOT_MOVES, MethodContext
from .observation import MOVES, iteration_at

MAX_EARLY_BEATS = 3.0
"""Longest time before its beat at which a step can be selected; dancers are rarely earlier (assumed)."""


class StepSelector:
    """Maps a chosen move to the step of that move whose beat is nearest; each step is selected once and in order.

    An agent in the environment can command any move at any time; a method can only trigger steps. There is no limit on
    the lateness of a step, so that a move that has begun can always be stopped. No step is selected earlier than
    `MAX_EARLY_BEATS` before its beat, or in the rehearsal.

    Args:
        context: the dance.

    Attributes:
        move: the move in force, as an index into `observation.MOVES`.
    """

    def __init__(self, context: MethodContext) -> None:
        self._context = context
        self._last_selected = (0, -1)
        self._beats = [
            [(step.beat, step.ordinal) for step in context.steps if ROBOT_MOVES[step.kind] is move] for move in MOVES
        ]
        """For each move the beats and ordinals of its steps."""
        self.move = 0

    def select(self, t_s: float, move: int) -> tuple[int, int] | None:
        """Select the step that a move stands for.

        Args:
            t_s: session time [s].
            move: a move as an index into `observation.MOVES`.

        Returns:
            iteration and ordinal of the step; None if the move is in force already or stands for no step now.
        """
        iteration = iteration_at(self._context, t_s)
        if iteration == 0 or move == self.move:
            return None

        # Late steps stay candidates, early ones do not.
        now_beat = self._context.beat(iteration, t_s)
        candidates = [
            (abs(beat - now_beat), ordinal)
            for beat, ordinal in self._beats[move]
            if beat <= now_beat + MAX_EARLY_BEATS and (iteration, ordinal) > self._last_selected
        ]
        if not candidates:
            return None

        self._last_selected = (iteration, min(candidates)[1])
        self.move = move
        return self._last_selected
