"""Published studies other than the paper's that can be reproduced, by name."""

from __future__ import annotations

from collections.abc import Callable

from ..core.errors import ConfigError
from .reproduction_report import Reproduction

FEWEST_STUDIES = 20
"""Fewest simulated studies; fewer give no interval of 95 %."""


def reproduce(study: str, studies: int, seed: int, progress: Callable[[float], None]) -> Reproduction:
    """Reproduce a study.

    Args:
        study: its name.
        studies: number of simulated studies.
        seed: seed of all random numbers.
        progress: is called with the share that is done, 0 to 1.

    Raises:
        ConfigError: there are fewer than `FEWEST_STUDIES` simulated studies.
    """
    if studies < FEWEST_STUDIES:
        raise ConfigError("studies", studies, f"at least {FEWEST_STUDIES}")

    from .tempo_tasks import reproduce_tempo_tasks

    return reproduce_tempo_tasks(studies, seed, progress)
