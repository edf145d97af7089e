"""A march: forward and back in even phrases of four beats, four held; nobody claps or turns.

The phrasing is assumed; it keeps the period of the paper's moves, so that both dances can be compared.
"""

from __future__ import annotations

from ..core.registry import register
from .phrases import to_and_fro
from .score import Choreography


@register("choreography", "march")
def march() -> Choreography:
    """Four moves at four beats a bar; 32 beats an iteration, window closing after the last stop at beat 30."""
    return Choreography(
        name="march",
        moves=to_and_fro(4.0),
        iteration_beats=32.0,
        close_beat=30.0,
        turn_rad=0.0,
    )
