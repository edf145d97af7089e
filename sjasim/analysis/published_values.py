"""The values of the published study, each with the function that computes it from simulated studies.

To add a value: add a row to `PUBLISHED`, and its function below if none computes it yet.

Source: iqbal2016, sections VI-A and VI-B, and table I.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Literal

import numpy as np

from ..assets import published_study as published
from ..core import Array
from .paired_tests import signed_rank
from .study_tables import StudyTables
from .study_values import iteration_values, step_values

METHODS = ("eca", "sia")
"""The two methods of the published study, in the order of the arrays' columns."""

DECIMALS = 2
"""Decimals of table I, with which iterations are compared."""

DISCARDED_SHARE = 12 / 648
"""Share of the robot's steps of both methods that the paper discards.

Source: iqbal2016, section VI-B: 3.7 %, read as 12 of the 324 steps of one method; the percentages of table II and the
sample size that the effect size implies agree with 12 missing steps of 648.
"""


@dataclass(frozen=True, slots=True)
class StudyArrays:
    """Values of S studies of G groups, I iterations and K steps under the two methods.

    Attributes:
        gsi: (S, G, I, 2) group synchronisation index under the paper's edges.
        ta_s: (S, G, I, K, 2) timing appropriateness [s]; NaN where the robot missed a step.
    """

    gsi: Array
    ta_s: Array


@dataclass(frozen=True, slots=True)
class PublishedValue:
    """A value that the paper reports, or that follows from its table I.

    Attributes:
        name: name of the value.
        method: the method that it belongs to; "" for both.
        value: what the paper reports.
        role: ``fitted`` if the people of the presets were fitted to it, else ``held out``.
        compute: function that returns the (S,) values of S studies.
        meaning: what the value is, with its unit.
    """

    name: str
    method: str
    value: float
    role: Literal["fitted", "held out"]
    compute: Callable[[StudyArrays], Array]
    meaning: str


def study_arrays(tables: StudyTables, methods: tuple[str, str] = METHODS) -> StudyArrays:
    """Arrange the tables of studies of equal size as arrays.

    Args:
        tables: the studies.
        methods: names of the two conditions, for the last axis.
    """
    iterations = iteration_values(tables, "gsi", methods)
    studies, groups, counts = (len(np.unique(column)) for column in iterations.units.T)
    steps = step_values(tables, methods)
    return StudyArrays(
        gsi=iterations.values.reshape(studies, groups, counts, 2),
        ta_s=steps.values.reshape(studies, groups, counts, -1, 2),
    )


def _mean_gsi(studies: StudyArrays, method: int) -> Array:
    return np.asarray(studies.gsi[..., method].mean(axis=(1, 2)))


def _iteration_gsi(studies: StudyArrays, method: int, index: int) -> Array:
    return np.asarray(studies.gsi[:, :, index, method].mean(axis=1))


def _rise(studies: StudyArrays, method: int) -> Array:
    """Mean of the second half of the iterations minus that of the first half."""
    half = studies.gsi.shape[2] // 2
    gsi = studies.gsi[..., method]
    return np.asarray(gsi[:, :, half:].mean(axis=(1, 2)) - gsi[:, :, :half].mean(axis=(1, 2)))


def _within_groups_sd(studies: StudyArrays, method: int) -> Array:
    return np.asarray(np.sqrt(studies.gsi[..., method].var(axis=2, ddof=1).mean(axis=1)))


def _group_means_sd(studies: StudyArrays, method: int) -> Array:
    return np.asarray(studies.gsi[..., method].mean(axis=2).std(axis=1, ddof=1))


def _lowest(studies: StudyArrays, method: int) -> Array:
    return np.asarray(studies.gsi[..., method].min(axis=(1, 2)))


def _highest(studies: StudyArrays, method: int) -> Array:
    return np.asarray(studies.gsi[..., method].max(axis=(1, 2)))


def _iterations_won(studies: StudyArrays) -> Array:
    """Number of iterations in which the second method has the higher index, as printed."""
    printed = np.round(studies.gsi, DECIMALS)
    return np.asarray((printed[..., 1] > printed[..., 0]).sum(axis=(1, 2)), dtype=np.float64)


def _groups_won(studies: StudyArrays) -> Array:
    means = studies.gsi.mean(axis=2)
    return np.asarray((means[..., 1] > means[..., 0]).sum(axis=1), dtype=np.float64)


def _group_correlation(studies: StudyArrays) -> Array:
    means = studies.gsi.mean(axis=2)
    return np.array([np.corrcoef(of_study.T)[0, 1] for of_study in means])


def _ta_mean(studies: StudyArrays, method: int) -> Array:
    return np.asarray(np.nanmean(studies.ta_s[..., method], axis=(1, 2, 3)))


def _ta_sd(studies: StudyArrays, method: int) -> Array:
    return np.asarray(np.nanstd(studies.ta_s[..., method], axis=(1, 2, 3)))


def _ta_within(studies: StudyArrays, method: int, limit_s: float) -> Array:
    """Share of the executed steps whose timing appropriateness is at most a limit."""
    ta_s = studies.ta_s[..., method]
    return np.asarray((ta_s <= limit_s).sum(axis=(1, 2, 3)) / np.isfinite(ta_s).sum(axis=(1, 2, 3)))


def _not_executed(studies: StudyArrays) -> Array:
    return np.asarray(np.isnan(studies.ta_s).mean(axis=(1, 2, 3, 4)))


def _signed_rank(studies: StudyArrays, name: str) -> Array:
    """Statistic or effect size of the signed-rank test on pairs of the same group, iteration and step."""
    values = []
    for ta_s in studies.ta_s.reshape(len(studies.ta_s), -1, 2):
        pairs = ta_s[np.isfinite(ta_s).all(axis=1)]
        values.append(getattr(signed_rank(pairs[:, 0], pairs[:, 1]), name))
    return np.array(values)


def _printed_rise(method: str) -> float:
    gsi = np.array(published.GSI[method])
    return float(gsi[:, 2:].mean() - gsi[:, :2].mean())


def _of_method(index: int, method: str) -> list[PublishedValue]:
    """All values that belong to one method."""
    gsi = np.array(published.GSI[method])
    per_method = partial(PublishedValue, method=method)

    # The roles are those of scripts/fit_presets.py: a held-out value must not enter its cost.
    rows = [
        per_method("gsi_mean", value=float(gsi.mean()), role="fitted", compute=partial(_mean_gsi, method=index),
                   meaning="mean group synchronisation index"),
        per_method("gsi_rise", value=_printed_rise(method), role="fitted", compute=partial(_rise, method=index),
                   meaning="mean index of iterations 3 and 4 minus that of 1 and 2"),
        per_method("gsi_sd_within_groups", value=float(np.sqrt(gsi.var(axis=1, ddof=1).mean())), role="fitted",
                   compute=partial(_within_groups_sd, method=index), meaning="s.d. of the index within groups"),
        per_method("gsi_sd_group_means", value=float(gsi.mean(axis=1).std(ddof=1)), role="fitted",
                   compute=partial(_group_means_sd, method=index), meaning="s.d. of the groups' mean indices"),
        per_method("gsi_lowest", value=float(gsi.min()), role="held out", compute=partial(_lowest, method=index),
                   meaning="lowest index of an iteration"),
        per_method("gsi_highest", value=float(gsi.max()), role="held out", compute=partial(_highest, method=index),
                   meaning="highest index of an iteration"),
        per_method("ta_mean_s", value=published.TA_MEAN_S[method], role="fitted",
                   compute=partial(_ta_mean, method=index), meaning="mean timing appropriateness [s]"),
        per_method("ta_sd_s", value=published.TA_SD_S[method], role="held out", compute=partial(_ta_sd, method=index),
                   meaning="s.d. of timing appropriateness [s]"),
    ]  # fmt: skip

    for number, value in enumerate(gsi.mean(axis=0), start=1):
        compute = partial(_iteration_gsi, method=index, index=number - 1)
        meaning = f"mean index of iteration {number}"
        rows.append(PublishedValue(f"gsi_iteration_{number}", method, float(value), "held out", compute, meaning))

    for limit_s, share in published.TA_SHARE_WITHIN[method].items():
        compute = partial(_ta_within, method=index, limit_s=limit_s)
        meaning = f"share of the robot's events within {limit_s:g} s of the ideal time"
        rows.append(PublishedValue(f"ta_within_{limit_s:g}_s", method, share, "fitted", compute, meaning))

    return rows


def _of_both() -> list[PublishedValue]:
    """All values that compare the two methods, or count over both."""
    means = np.array([published.GSI[method] for method in METHODS]).mean(axis=2)
    held_out = partial(PublishedValue, method="", role="held out")
    return [
        held_out("iterations_won", value=float(published.ITERATIONS_WON[0]), compute=_iterations_won,
                 meaning="iterations of 36 in which SIA has the higher index"),
        held_out("groups_won", value=float(published.GROUPS_WON[0]), compute=_groups_won,
                 meaning="groups of 9 in which SIA has the higher mean index"),
        held_out("group_correlation", value=float(np.corrcoef(means)[0, 1]), compute=_group_correlation,
                 meaning="correlation of the groups' mean indices under the two methods"),
        held_out("wilcoxon_z", value=published.WILCOXON_Z, compute=partial(_signed_rank, name="z"),
                 meaning="signed-rank statistic of timing appropriateness, SIA against ECA"),
        held_out("wilcoxon_r", value=published.WILCOXON_R, compute=partial(_signed_rank, name="r"),
                 meaning="its effect size"),
        held_out("not_executed", value=DISCARDED_SHARE, compute=_not_executed,
                 meaning="share of the robot's steps that are missing"),
    ]  # fmt: skip


PUBLISHED: tuple[PublishedValue, ...] = (*_of_method(0, "eca"), *_of_method(1, "sia"), *_of_both())
"""All values, first those of ECA, then those of SIA, then those of both."""
