"""Gymnasium environments in which an agent commands the robot; importing this package registers their ids."""

from __future__ import annotations

from gymnasium.envs.registration import register, registry

ENVIRONMENTS = {
    "sjasim/Dance-v0": "sjasim_envs.dance:DanceEnv",
    "sjasim/DanceFlat-v0": "sjasim_envs.dance:DanceFlatEnv",
    "sjasim/DanceContinuous-v0": "sjasim_envs.dance:DanceContinuousEnv",
}
"""Id -> its class, as text, so that only Gymnasium is imported until an environment is made."""


def register_envs() -> None:
    """Register the ids with Gymnasium; a repeated call has no effect."""
    for name, entry_point in ENVIRONMENTS.items():
        if name not in registry:
            register(id=name, entry_point=entry_point)


register_envs()
