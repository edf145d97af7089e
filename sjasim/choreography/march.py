"""A march: forward and back in even phrases of four beats, four held; nobody claps or turns.

The phrasing is assumed; it keeps the period of the paper's moves, so that both dances can be compared.
"""

from __future__ import annotations

from ..registry import register
from ..types import Move
from .score import Choreography, ScoreMove


@register("choreography", "march")
def march() -> Choreography:
    """Four moves at four beats a bar; 32 beats an iteration, window closing after the last stop at beat 30."""
    bars = ((Move.FORWARD, 0.0), (Move.BACKWARD, 8.0), (Move.FORWARD, 16.0), (Move.BACKWARD, 24.0))
    return Choreography(
        name="march",
        moves=tuple(ScoreMove(move, beat, 4.0) for move, beat in bars),
        iteration_beats=32.0,
        close_beat=30.0,
        turn_rad=0.0,
    )
