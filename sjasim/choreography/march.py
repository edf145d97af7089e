"""The march: forward and backward in even phrases of four beats, without claps and turns.

The phrasing is assumed. It keeps the period of the paper's moves, so that the two dances can be compared.
"""

from __future__ import annotations

from ..core.registry import register
from .phrases import forward_and_backward
from .score import Choreography


@register("choreography", "march")
def march() -> Choreography:
    """Four moves at four beats a bar: 32 beats an iteration, whose window closes at beat 30, after the last stop."""
    return Choreography(
        name="march",
        moves=forward_and_backward(4.0),
        iteration_beats=32.0,
        close_beat=30.0,
        turn_rad=0.0,
    )
