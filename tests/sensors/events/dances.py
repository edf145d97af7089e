"""A scripted dance of walks and claps at a dancer's own pace."""

from __future__ import annotations

import math

import numpy as np

from ..scripted import PLACES, Script, Walk


def dance(seed: int, rounds: int, place: tuple[float, float] = PLACES[0], spread: float = 0.05) -> Script:
    """Rounds of a walk forward, a walk backward and a clap, with holds between them.

    Args:
        seed: seed of durations and holds.
        rounds: number of rounds.
        place: place of the dancer [m].
        spread: how much the durations of the walks vary around the dancer's own, which are 0.8 to 3 s.
    """
    rng = np.random.default_rng(seed)
    script = Script(place)
    paces_s = np.exp(rng.uniform(math.log(0.8), math.log(3.0), 2))
    t_s = 2.0
    for _ in range(rounds):
        for sign, pace_s in zip((1.0, -1.0), paces_s, strict=True):
            duration_s = min(max(pace_s * rng.uniform(1 - spread, 1 + spread), 0.8), 3.0)
            script.walks.append(Walk(t_s, duration_s, sign * 0.5))
            t_s += duration_s + rng.uniform(1.6, 2.4)
        script.claps.append(t_s)
        t_s += rng.uniform(2.0, 2.6)
    return script
