"""The paper's dance: forward, backward, forward, backward, clap, quarter turn; north, west, south, east.

Source: iqbal2016, section V-B. The paper does not say how its moves lie on the music; a bar moving, a bar held,
clap, turn is assumed: it is the phrasing under which the human timing model keeps its order.
"""

from __future__ import annotations

import math

from ..core.registry import register
from .phrases import clap_and_turn, to_and_fro
from .score import Choreography


@register("choreography", "paper")
def paper() -> Choreography:
    """The paper's dance at four beats a bar; 40 beats an iteration, window closing after the turn at beat 36."""
    return Choreography(
        name="paper",
        moves=to_and_fro(4.0) + clap_and_turn(32.0),
        iteration_beats=40.0,
        close_beat=36.0,
        turn_rad=math.pi / 2,
    )
