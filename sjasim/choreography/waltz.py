"""A dance in three-four time: a bar moving, a bar held, forward and back twice; clap and quarter turn.

The phrasing is assumed.
"""

from __future__ import annotations

import math

from ..registry import register
from ..types import Move
from .score import Choreography, ScoreMove


@register("choreography", "waltz")
def waltz() -> Choreography:
    """Four moves at three beats a bar; 33 beats an iteration, window closing after the turn at beat 28."""
    bars = ((Move.FORWARD, 0.0), (Move.BACKWARD, 6.0), (Move.FORWARD, 12.0), (Move.BACKWARD, 18.0))
    moves = tuple(ScoreMove(move, beat, 3.0) for move, beat in bars)
    return Choreography(
        name="waltz",
        moves=(*moves, ScoreMove(Move.CLAP, 24.0, 0.0), ScoreMove(Move.TURN, 24.5, 3.5)),
        iteration_beats=33.0,
        close_beat=28.0,
        turn_rad=math.pi / 2,
    )
