"""Options of the reproduction of a published study."""

from __future__ import annotations

from dataclasses import dataclass

from ..config.checks import one_of, within

PAPER = "paper"
"""Name of the study of Iqbal, Rack and Riek."""


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
        within("studies", self.studies, 1, 10**6)
        within("groups", self.groups, 3, 10**4)
        within("seed", self.seed, 0, 2**63 - 1)
        within("jobs", self.jobs, 0, 4096)
        one_of("fidelity", self.fidelity, ("timing", "physics"))
