"""Type I error in studies of simulated people, whose events are nested in iterations and groups."""

import numpy as np
import pytest

from sjasim.analysis.error_rates import RECOMMENDED, rejection_shares
from sjasim.config import SessionConfig
from sjasim.studies.null_studies import null_studies

CONFIG = SessionConfig(method="sia", fidelity="timing", seed=500_000)


def test_both_sessions_of_a_group_have_the_same_persons_and_other_performances():
    found = null_studies(CONFIG, 2, 3)
    assert found.gsi.shape == (2, 3, 2, 4, 1)
    assert found.ta_s.shape == (2, 3, 2, 4, 9)
    assert np.unique(found.gsi[:, :, :, 1:]).size > 10
    assert not np.array_equal(found.ta_s[:, :, 0], found.ta_s[:, :, 1], equal_nan=True)
    again = null_studies(CONFIG, 2, 3)
    assert np.array_equal(found.ta_s, again.ta_s, equal_nan=True)


@pytest.mark.slow
def test_the_recommended_test_keeps_its_level_in_500_studies_and_the_event_wise_test_does_not():
    """The same figures: python scripts/type_one_error.py --studies 500."""
    found = null_studies(CONFIG, 500, 9)
    rng = np.random.default_rng(0)
    timing = rejection_shares(found.ta_s, rng)
    assert 0.03 <= timing[RECOMMENDED]["share"] <= 0.07
    assert timing["events: signed ranks"]["low"] > 0.15
    assert 0.03 <= rejection_shares(found.gsi, rng)[RECOMMENDED]["share"] <= 0.07
