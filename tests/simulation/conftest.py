"""Worlds and floors that the tests of the simulation share."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import pytest

from sjasim.choreography.layout import layout
from sjasim.choreography.timetable import timetable
from sjasim.config import DanceConfig, FaultConfig, SessionConfig
from sjasim.simulation.physics_world import PhysicsWorld

from ..humans.dancing import Floor, builds


@pytest.fixture(scope="session")
def short_config() -> SessionConfig:
    """One iteration without rehearsal, by metronomic dancers, with joint sensing."""
    return SessionConfig(
        humans="metronomic", sensing="joints", iterations=1, dance=DanceConfig(rehearsal=False, lead_in_s=1.0)
    )


@pytest.fixture(scope="session")
def make_world(short_config: SessionConfig) -> Callable[..., PhysicsWorld]:
    """Makes the world of the short session with some faults."""

    def make(*faults: FaultConfig, robot: bool = True) -> PhysicsWorld:
        config = dataclasses.replace(short_config, faults=faults)
        return PhysicsWorld(config, timetable(config), layout(config), robot=robot)

    return make


@pytest.fixture(scope="session")
def make_floor() -> Callable[..., Floor]:
    """Makes a floor with dancers of various builds, who stand until they are given cues."""

    def make(count: int = 1, seconds: float = 6.0, **options) -> Floor:
        return Floor(builds(count, 2), seconds, **options)

    return make
