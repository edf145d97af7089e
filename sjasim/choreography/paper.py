"""The paper's dance: forward, backward, forward, backward, clap, quarter turn; north, west, south, east.

Source: iqbal2016, section V-B. The paper does not say how its moves lie on the music; a bar moving, a bar held,
clap, turn is assumed: it is the phrasing under which the human timing model keeps its order.
"""

from __future__ import annotations

import math

from ..registry import register
from ..types import Move
from .score import Choreography, ScoreMove


@register("choreography", "paper")
def paper() -> Choreography:
    """The paper's dance at four beats a bar; 40 beats an iteration, window closing after the turn at beat 36."""
    bars = ((Move.FORWARD, 0.0), (Move.BACKWARD, 8.0), (Move.FORWARD, 16.0), (Move.BACKWARD, 24.0))
    moves = tuple(ScoreMove(move, beat, 4.0) for move, beat in bars)
    return Choreography(
        name="paper",
        moves=(*moves, ScoreMove(Move.CLAP, 32.0, 0.0), ScoreMove(Move.TURN, 32.5, 3.5)),
        iteration_beats=40.0,
        close_beat=36.0,
        turn_rad=math.pi / 2,
    )
