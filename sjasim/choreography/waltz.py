"""The waltz: the paper's moves in three-four time.

The phrasing is assumed.
"""

from __future__ import annotations

import math

from ..core.registry import register
from .phrases import clap_and_turn, forward_and_backward
from .score import Choreography


@register("choreography", "waltz")
def waltz() -> Choreography:
    """Four moves at three beats a bar: 33 beats an iteration, whose window closes at beat 28, after the turn."""
    return Choreography(
        name="waltz",
        moves=forward_and_backward(3.0) + clap_and_turn(24.0),
        iteration_beats=33.0,
        close_beat=28.0,
        turn_rad=math.pi / 2,
    )
