"""What the dances have in common: a bar moving, a bar held, forward and back twice; then a clap and a turn."""

from __future__ import annotations

from ..core import Move
from .score import ScoreMove

TURN_BEATS = 3.5


def to_and_fro(bar_beats: float) -> tuple[ScoreMove, ...]:
    """Forward and backward twice, each for a bar, each followed by a bar held; eight bars in all."""
    ways = (Move.FORWARD, Move.BACKWARD, Move.FORWARD, Move.BACKWARD)
    return tuple(ScoreMove(way, 2 * index * bar_beats, bar_beats) for index, way in enumerate(ways))


def clap_and_turn(beat: float) -> tuple[ScoreMove, ...]:
    """A clap on a beat and, half a beat later, a turn that ends with the bar."""
    return ScoreMove(Move.CLAP, beat, 0.0), ScoreMove(Move.TURN, beat + 0.5, TURN_BEATS)
