"""A dance in three-four time: a bar moving, a bar held, forward and back twice; clap and quarter turn.

The phrasing is assumed.
"""

from __future__ import annotations

import math

from ..core.registry import register
from .phrases import clap_and_turn, to_and_fro
from .score import Choreography


@register("choreography", "waltz")
def waltz() -> Choreography:
    """Four moves at three beats a bar; 33 beats an iteration, window closing after the turn at beat 28."""
    return Choreography(
        name="waltz",
        moves=to_and_fro(3.0) + clap_and_turn(24.0),
        iteration_beats=33.0,
        close_beat=28.0,
        turn_rad=math.pi / 2,
    )
