"""Published studies that can be reproduced, by name."""

from __future__ import annotations

from pathlib import Path
from typing import Protocol

from ..commands.progress import progress_reporter
from ..core.errors import ConfigError
from .reproduction_options import PAPER, ReproductionOptions

FEWEST_STUDIES = 20
"""Fewest simulated studies; fewer give no interval of 95 %."""

QUARTET = "quartet"
"""Name of the study of a string quartet, whose data its users fetch."""


class Report(Protocol):
    """Result of a reproduction."""

    def print(self, json_only: bool) -> None:
        """Print tables and a summary on stdout, or reproduce.json and nothing else."""
        ...

    def save(self, folder: Path, overwrite: bool) -> None:
        """Write reproduce.json to a folder.

        Raises:
            RecordError: the folder cannot be written.
        """
        ...


def reproduce(study: str, options: ReproductionOptions, data: Path | None = None) -> Report:
    """Reproduce a study, with its progress on stderr.

    Args:
        study: name of the study.
        options: what is simulated.
        data: folder with the onsets of the quartet; None for other studies.

    Raises:
        ConfigError: an option has no effect on the study, or the quartet's folder is not given.
        RecordError: the folder does not hold what is needed.
        SjasimError: the people do not exist, or a session failed.
    """
    if options.studies < FEWEST_STUDIES:
        raise ConfigError("studies", options.studies, f"at least {FEWEST_STUDIES}, for an interval of 95 %")
    if data is not None and study != QUARTET:
        raise ConfigError("data", str(data), f"only with the study {QUARTET}")
    if study == PAPER:
        from .paper_reproduction import reproduce_paper

        return reproduce_paper(options)

    for name in ("humans", "groups", "fidelity", "findings"):
        if getattr(options, name) != getattr(ReproductionOptions(), name):
            raise ConfigError(name, getattr(options, name), f"only with the study {PAPER}")

    with progress_reporter("simulating") as progress:
        if study == QUARTET:
            from .quartet import reproduce_quartet

            if data is None:
                raise ConfigError("data", None, "the folder with the onsets of the quartet")
            return reproduce_quartet(data, options.studies, options.seed, progress.simulating)

        from .tempo_tasks import reproduce_tempo_tasks

        return reproduce_tempo_tasks(options.studies, options.seed, progress.simulating)
