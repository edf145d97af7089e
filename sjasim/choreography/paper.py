"""The paper's dance: forward, backward, forward, backward, clap, quarter turn.

The dancers face north, west, south and east in iterations 1 to 4.

Source: iqbal2016, section V-B. The paper does not say how the moves lie on the music. Assumed: each move takes a bar,
and a bar of standing follows it. Under this phrasing the human timing model keeps the events in order.
"""

from __future__ import annotations

import math

from ..core.registry import register
from .phrases import clap_and_turn, forward_and_backward
from .score import Choreography


@register("choreography", "paper")
def paper() -> Choreography:
    """The paper's dance at four beats a bar: 40 beats an iteration, whose window closes at beat 36, after the turn."""
    return Choreography(
        name="paper",
        moves=forward_and_backward(4.0) + clap_and_turn(32.0),
        iteration_beats=40.0,
        close_beat=36.0,
        turn_rad=math.pi / 2,
    )
