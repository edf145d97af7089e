"""Studies without a difference: two sessions of every group under one method, taken as two methods.

Both sessions have the same persons and fresh performances, so that iterations and events are nested in groups as in a
real study, while the two methods have the same distribution.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..config import SessionConfig
from ..core import Array

PERFORMANCES = ("first", "second")
"""Names of the two performances of a group."""


class NullStudies(NamedTuple):
    """Measures of studies without a difference.

    Attributes:
        gsi: (S, G, 2, I, 1) group synchronisation index of S studies, G groups, two sessions and I iterations.
        ta_s: (S, G, 2, I, K) timing appropriateness of the K steps of an iteration [s]; NaN for a missed step.
    """

    gsi: Array
    ta_s: Array


def null_studies(config: SessionConfig, studies: int, groups: int) -> NullStudies:
    """Simulate studies without a difference.

    Args:
        config: session of every group; its seed is the first group's, and the others follow.
        studies: number of studies.
        groups: number of groups in each.
    """
    seeds = range(config.seed, config.seed + studies * groups)
    found = [_group(replace(config, seed=seed)) for seed in seeds]
    gsi = np.array([group[0] for group in found])
    ta_s = np.array([group[1] for group in found])
    return NullStudies(
        gsi.reshape(studies, groups, *gsi.shape[1:])[..., None], ta_s.reshape(studies, groups, *ta_s.shape[1:])
    )


def _group(config: SessionConfig) -> tuple[Array, Array]:
    """(2, I) indices and (2, I, K) timing appropriateness of both sessions of a group."""
    from ..session.session import Session
    from .session_rows import session_rows

    gsi = []
    ta_s = []
    # The seed determines the persons, the name of the performance what they do.
    for performance in PERFORMANCES:
        session = Session(replace(config, performance=performance))
        session.advance(session.end_s)
        rows = session_rows(session, 0)
        gsi.append(np.asarray(rows.iterations["gsi"], dtype=np.float64))
        ta_s.append(np.asarray(rows.steps["ta_s"], dtype=np.float64).reshape(len(gsi[-1]), -1))
    return np.array(gsi), np.array(ta_s)
