"""Gymnasium environments over sjasim's dance sessions; importing this package registers their ids."""

from __future__ import annotations

from gymnasium.envs.registration import register, registry

ENVIRONMENTS = {
    "sjasim/Dance-v0": "sjasim_envs.dance:DanceEnv",
    "sjasim/DanceFlat-v0": "sjasim_envs.dance:DanceFlatEnv",
    "sjasim/DanceContinuous-v0": "sjasim_envs.dance:DanceContinuousEnv",
}
"""Id -> where its class is, as text: nothing but Gymnasium is loaded until one is made."""


def register_envs() -> None:
    """Make the ids known to Gymnasium; once more does no harm."""
    for name, place in ENVIRONMENTS.items():
        if name not in registry:
            register(id=name, entry_point=place)


register_envs()
