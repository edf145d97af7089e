"""What the simulated study says about the published one: findings, each with an interval over groups.

Every finding compares two sets of sessions of the same groups, in fidelity ``timing``.
"""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ..analysis.paired_intervals import Interval, mean_interval
from ..analysis.study_tables import StudyTables
from ..analysis.study_values import group_values, iteration_values
from ..core import Array
from ..humans.timing.parameters import TimingParameters, parameters_toml, preset, preset_names, read_parameters
from .study_design import StudyDesign
from .study_execution import run_study

GROUPS = 360
"""Number of groups of each comparison."""

FOLLOWED_FROM = 2
"""First iteration in which SIA follows a dancer, by default."""

TAPPING = "musicians"
"""Preset with the timing noise of trained musicians who tap."""

PUBLISHED_GSI_ECA = 0.4108
"""Mean index under ECA. Source: iqbal2016, table I."""

PUBLISHED_TA_ECA_S = 0.70
"""Mean timing appropriateness under ECA [s]. Source: iqbal2016, section VI-B."""


def findings(humans: str, seed: int, jobs: int = 0) -> list[dict[str, Any]]:
    """Compute all findings.

    Args:
        humans: preset or file of the people. For other models than the ensemble's, only the first two are computed.
        seed: seed of the groups.
        jobs: number of processes on this computer; 0 for one per core.
    """
    rng = np.random.default_rng(seed)
    common = StudyDesign(groups=GROUPS, humans=(humans,), humans_only=False, events=False, seed=seed, order="fixed")
    found = [_random_dancer(common, rng, jobs), _tapping(common, rng, jobs)]

    parameters = _ensemble_parameters(humans)
    if parameters is None:
        return found
    with tempfile.TemporaryDirectory() as folder:
        without_shift = _written(replace(parameters, common_s=0.0), Path(folder) / "no-common-shift.toml")
        found.append(_common_shift(replace(common, humans=(without_shift,)), rng, jobs))
        if parameters.entrainment > 0.0:
            steady = _written(replace(parameters, entrainment=0.0), Path(folder) / "no-entrainment.toml")
            found.append(_entrainment(common, steady, rng, jobs))
    return found


def _ensemble_parameters(humans: str) -> TimingParameters | None:
    """Parameters of the ensemble model; None for people of another model."""
    if humans.endswith(".toml"):
        return read_parameters(Path(humans))
    return preset(humans) if humans in preset_names() else None


def _written(parameters: TimingParameters, path: Path) -> str:
    """Write parameters to a file that ``--humans`` reads, and return its name."""
    path.write_text(parameters_toml(parameters), encoding="utf-8")
    return str(path)


def _random_dancer(design: StudyDesign, rng: np.random.Generator, jobs: int) -> dict[str, Any]:
    """Whether the most synchronous dancer is a better leader than one drawn at random."""
    tables = run_study(replace(design, methods=("random-dancer", "sia"), performance="same"), jobs=jobs)
    paired = iteration_values(tables, "gsi_full_edges", ("random-dancer", "sia"))
    followed = paired.units[:, 2] >= FOLLOWED_FROM
    differences = (paired.column("sia") - paired.column("random-dancer"))[followed]
    per_group = differences.reshape(design.groups, -1).mean(axis=1)
    return _finding(
        "A dancer drawn at random is as good a leader as the most synchronous one",
        "GSI under all edges, SIA minus random dancer, iterations in which a dancer is followed, same performances:",
        mean_interval(per_group, rng),
    )


def _tapping(design: StudyDesign, rng: np.random.Generator, jobs: int) -> dict[str, Any]:
    """Whether people as steady as musicians who tap would give the published index."""
    tables = run_study(replace(design, methods=("eca",), humans=(TAPPING,)), jobs=jobs)
    gsi = group_values(tables, "gsi", ("eca",)).column("eca")
    return _finding(
        "The timing noise of tapping does not give the published index",
        f"GSI under ECA with the people of {TAPPING}, where the paper has {PUBLISHED_GSI_ECA:.3f}:",
        mean_interval(gsi, rng),
    )


def _common_shift(design: StudyDesign, rng: np.random.Generator, jobs: int) -> dict[str, Any]:
    """Whether the published error of ECA needs a shift that all dancers share."""
    tables = run_study(replace(design, methods=("eca",)), jobs=jobs)
    ta_s = group_values(tables, "ta_mean_s", ("eca",)).column("eca")
    return _finding(
        "The published error of ECA needs a shift that the whole group shares",
        f"TA [s] under ECA with the same people but without the shift, where the paper has {PUBLISHED_TA_ECA_S:.2f}:",
        mean_interval(ta_s, rng),
    )


def _entrainment(design: StudyDesign, steady: str, rng: np.random.Generator, jobs: int) -> dict[str, Any]:
    """How much of SIA's gain over ECA is due to people who become steadier with a well-timed robot.

    Args:
        design: groups, people and seed.
        steady: file of the same people without entrainment.
        rng: draws the bootstrap samples.
        jobs: number of processes.
    """
    both = replace(design, methods=("eca", "sia"))
    with_entrainment = _gain(run_study(both, jobs=jobs))
    without = _gain(run_study(replace(both, humans=(steady,)), jobs=jobs))
    return _finding(
        "Part of SIA's gain over ECA is the entrainment of the people",
        "GSI, SIA minus ECA, with entrainment minus without:",
        mean_interval(with_entrainment - without, rng),
    )


def _gain(tables: StudyTables) -> Array:
    """(G,) index of each group under SIA minus that under ECA."""
    paired = group_values(tables, "gsi", ("eca", "sia"))
    return np.asarray(paired.column("sia") - paired.column("eca"))


def _finding(title: str, text: str, interval: Interval) -> dict[str, Any]:
    return {"title": title, "text": text, "mean": interval.value, "low": interval.low, "high": interval.high}
