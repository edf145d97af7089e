"""Random dancer: the robot follows a dancer that is drawn at random for each iteration; otherwise it is SIA.

This is the control that shows what the choice of the leader is worth: it has the same triggers, windows and fallbacks
as SIA. The published study has no such control.
"""

from __future__ import annotations

import numpy as np

from ..core.method_io import MethodContext
from ..core.registry import register
from .sia import Sia, SiaConfig


@register("anticipation", "random-dancer", config=SiaConfig)
class RandomDancer(Sia):
    """Draws the leader of each iteration, and follows it as SIA follows the most synchronous dancer.

    Args:
        config: options of SIA.
    """

    def reset(self, context: MethodContext, rng: np.random.Generator) -> None:
        """Prepare for a dance, and discard the state of the last one."""
        super().reset(context, rng)
        self._rng = rng

    def _select_leader(self, iteration: int) -> None:
        """Draw the leader of the next iteration."""
        person = self._context.cast[int(self._rng.integers(len(self._context.cast)))]
        self._leaders[iteration] = person
        self._leader_note = f"{person}, drawn at random"
