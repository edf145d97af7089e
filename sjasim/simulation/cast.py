"""The builds of a session's dancers."""

from __future__ import annotations

from ..config import SessionConfig
from ..core.clock import stream
from ..humans.body.anatomy import Build


def sample_build(config: SessionConfig, dancer: int) -> Build:
    """Draw stature and mass of a dancer. They depend on the seed and the dancer's index, but not on the method."""
    rng = stream(config.seed, "humans", "person", dancer)
    stature_m = float(rng.uniform(*config.body.stature_m))
    mass_kg = float(rng.uniform(*config.body.mass_kg))
    return Build(stature_m, mass_kg)
