"""Builds of the dancers."""

from __future__ import annotations

import dataclasses

from sjasim.config import BodyConfig, SessionConfig
from sjasim.simulation.cast import sample_build


def test_builds_depend_on_the_seed_and_stay_within_the_configured_range():
    body = BodyConfig(stature_m=(1.6, 1.7), mass_kg=(60.0, 65.0))
    config = SessionConfig(seed=4, body=body)
    builds = [sample_build(config, dancer) for dancer in range(3)]
    assert len(set(builds)) == 3
    assert all(1.6 <= build.stature_m <= 1.7 and 60.0 <= build.mass_kg <= 65.0 for build in builds)
    assert [sample_build(dataclasses.replace(config, method="eca"), dancer) for dancer in range(3)] == builds
    assert sample_build(dataclasses.replace(config, seed=5), 0) != builds[0]
