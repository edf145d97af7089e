"""Sequences of moves that several dances share."""

from __future__ import annotations

from ..core import Move
from .score import ScoreMove

TURN_BEATS = 3.5
"""Nominal length of a turn [beats]: it begins half a beat after the clap and ends with the bar of four (assumed)."""


def forward_and_backward(bar_beats: float) -> tuple[ScoreMove, ...]:
    """Forward and backward, twice: each move takes a bar, and a bar of standing follows it; eight bars in all.

    Args:
        bar_beats: beats in a bar.
    """
    directions = (Move.FORWARD, Move.BACKWARD, Move.FORWARD, Move.BACKWARD)
    return tuple(ScoreMove(move, 2 * index * bar_beats, bar_beats) for index, move in enumerate(directions))


def clap_and_turn(beat: float) -> tuple[ScoreMove, ...]:
    """A clap on a beat of the iteration and a turn that begins half a beat later."""
    return ScoreMove(Move.CLAP, beat, 0.0), ScoreMove(Move.TURN, beat + 0.5, TURN_BEATS)
