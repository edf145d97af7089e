"""Published studies that can be reproduced, by name."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from ..commands.progress import progress_reporter
from ..config.checks import one_of, within
from ..core.errors import ConfigError

PAPER = "paper"
"""Name of the study of Iqbal, Rack and Riek."""

FEWEST_STUDIES = 20
"""Fewest simulated studies; fewer give no interval of 95 %."""


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


@dataclass(frozen=True)
class ReproductionOptions:
    """What is simulated. Only ``studies`` and ``seed`` matter to other studies than the paper's.

    Attributes:
        humans: preset or FILE.toml of the people.
        studies: number of simulated studies.
        groups: number of groups in each study (iqbal2016: 9).
        fidelity: ``timing``, or ``physics``, which takes minutes for each study.
        seed: seed of all random numbers. Groups have seeds of evaluation; presets were fitted with seeds of tuning.
        jobs: number of processes on this computer; 0 for one per core.
        findings: whether the findings about methods and people are computed as well.
    """

    humans: str = "paper-entrainment"
    studies: int = 200
    groups: int = 9
    fidelity: str = "timing"
    seed: int = 0
    jobs: int = 0
    findings: bool = True

    def __post_init__(self) -> None:
        within("studies", self.studies, FEWEST_STUDIES, 10**6)
        within("groups", self.groups, 3, 10**4)
        within("seed", self.seed, 0, 2**63 - 1)
        within("jobs", self.jobs, 0, 4096)
        one_of("fidelity", self.fidelity, ("timing", "physics"))


def reproduce(study: str, options: ReproductionOptions) -> Report:
    """Reproduce a study, with its progress on stderr.

    Args:
        study: name of the study.
        options: what is simulated.

    Raises:
        ConfigError: an option has no effect on the study.
        SjasimError: the people do not exist, or a session failed.
    """
    if study == PAPER:
        from .paper_reproduction import reproduce_paper

        return reproduce_paper(options)

    for name in ("humans", "groups", "fidelity", "findings"):
        if getattr(options, name) != getattr(ReproductionOptions(), name):
            raise ConfigError(name, getattr(options, name), f"only with the study {PAPER}")

    from .tempo_tasks import reproduce_tempo_tasks

    with progress_reporter("simulating") as progress:
        return reproduce_tempo_tasks(options.studies, options.seed, progress.simulating)
