"""Identity errors when dancers walk past one another.

A walker glides past two standing dancers, behind or in front of them, with fixed joints. In a run with an occlusion the
walker stops for a second behind one of them, where the sensor cannot see the walker.
"""

from __future__ import annotations

import math

import numpy as np

from ..choreography.layout import layout
from ..config import BodyConfig, PhysicsConfig, RobotConfig, SessionConfig
from ..core import Array
from ..core.clock import stream
from ..humans.body.anatomy import Build
from ..humans.body.proportions import scaled_anatomy
from ..humans.motion.reference_trajectory import ReferenceTrajectory
from ..simulation.physics import Physics
from .scenes import RATE_HZ, planned_motion, random_build
from .trials import PosedView, Trial, TrialResult, record_trial

GAPS_M = (-0.8, 0.8, 1.2, 0.5)
"""Distances behind the standing dancers at which the walker passes; negative is in front of them."""

STANDING_DEPTH_M = 2.6
"""Distance of the standing dancers from the sensor."""

OCCLUDED_DEPTH_M = 3.5
"""Distance from the sensor of a walker who stops behind a standing dancer."""

STANDING_X_M = 0.6
"""Distance of the standing dancers from the sensor's axis, one on each side."""

PATH_END_M = 1.7
"""Distance from the sensor's axis at which the walker starts and ends."""

WALKING_SPEED_M_S = (0.5, 0.8)
"""Lowest and highest speed of the walker."""

WAIT_S = 1.5
"""Time before the walker starts, in which every dancer is assigned to a person; also the time that is not evaluated."""

TALL_AND_HEAVY = Build(1.92, 98.0)
SMALL_AND_LIGHT = Build(1.52, 52.0)


def crossing_errors(seed: int, runs: int = 28) -> dict[str, float]:
    """Let a walker pass both standing dancers and return, and count identity errors.

    Args:
        seed: seed of builds, speeds and sensor noise.
        runs: number of passes; each take has one in each direction.

    Returns:
        ``runs``; ``wrong``, the passes of takes in which an identity changed or was lost; ``most_frames_lost``, the
        largest share of frames in which a dancer had no person.
    """
    wrong = 0
    lost_shares = []
    for index in range(runs // 2):
        rng = stream(seed, "crossing", index)
        gap_m = GAPS_M[index % len(GAPS_M)]
        speed_m_s = float(rng.uniform(*WALKING_SPEED_M_S))
        there = _straight_path(-PATH_END_M, PATH_END_M, speed_m_s)
        back = _straight_path(PATH_END_M, -PATH_END_M, speed_m_s)
        builds = [random_build(rng) for _ in range(3)]

        has_error, lost_share = _identity_error(
            _record_walk(seed + index, builds, gap_m, np.concatenate([there, back]))
        )
        # A take has two passes, and an error counts for both.
        wrong += 2 * has_error
        lost_shares.append(lost_share)
    return {"runs": 2 * (runs // 2), "wrong": wrong, "most_frames_lost": max(lost_shares)}


def occlusion_errors(seed: int, runs: int = 8, hidden_s: float = 1.0) -> dict[str, float]:
    """Let a small walker stop behind a tall dancer, and count identity errors.

    Args:
        seed: seed of speeds and sensor noise.
        runs: number of runs.
        hidden_s: time for which the walker stops.

    Returns:
        the same figures as `crossing_errors`.
    """
    wrong = 0
    lost_shares = []
    for index in range(runs):
        rng = stream(seed, "eclipse", index)
        speed_m_s = float(rng.uniform(*WALKING_SPEED_M_S))

        # On the line from the sensor through the standing dancer.
        stop_m = -STANDING_X_M * OCCLUDED_DEPTH_M / STANDING_DEPTH_M
        there = _straight_path(-PATH_END_M, stop_m, speed_m_s)
        stop = np.full(round(hidden_s * RATE_HZ), stop_m)
        on = _straight_path(stop_m, 0.3, speed_m_s)

        builds = [TALL_AND_HEAVY, TALL_AND_HEAVY, SMALL_AND_LIGHT]
        gap_m = OCCLUDED_DEPTH_M - STANDING_DEPTH_M
        has_error, lost_share = _identity_error(
            _record_walk(seed + 100 + index, builds, gap_m, np.concatenate([there, stop, on]))
        )
        wrong += has_error
        lost_shares.append(lost_share)
    return {"runs": runs, "wrong": wrong, "most_frames_lost": max(lost_shares)}


def _straight_path(start_m: float, end_m: float, speed_m_s: float) -> Array:
    """Return places along x at a constant speed, one per frame [m]."""
    count = max(2, round(abs(end_m - start_m) / speed_m_s * RATE_HZ))
    return np.linspace(start_m, end_m, count)


def _record_walk(seed: int, builds: list[Build], gap_m: float, path_m: Array) -> TrialResult:
    """Record two standing dancers and a walker.

    Args:
        seed: seed of the sensor noise.
        builds: builds of the two standing dancers and of the walker.
        gap_m: distance of the walker behind the others.
        path_m: x of the walker, one place per frame.
    """
    bodies = [scaled_anatomy(build) for build in builds]
    length_s = len(path_m) / RATE_HZ + 2.0
    plans = [planned_motion(body, [], length_s, heading_rad=math.pi / 2) for body in bodies]

    wait = round(WAIT_S * RATE_HZ)
    rest = len(plans[2].yaw) - wait - len(path_m)
    walker_m = np.concatenate([np.full(wait, path_m[0]), path_m, np.full(rest, path_m[-1])])

    place = layout(SessionConfig())
    sensor_y_m = place.mounts[0].position[1]
    _set_place(plans[0], np.full(len(walker_m), -STANDING_X_M), sensor_y_m - STANDING_DEPTH_M)
    _set_place(plans[1], np.full(len(walker_m), STANDING_X_M), sensor_y_m - STANDING_DEPTH_M)
    _set_place(plans[2], walker_m, sensor_y_m - STANDING_DEPTH_M - gap_m)

    joints = np.array([plan.joints[0] for plan in plans])
    pelvis = np.array([plan.pelvis[0] for plan in plans])
    physics = Physics(bodies, place, (0.0, 0.0), joints, pelvis, PhysicsConfig(), BodyConfig(), RobotConfig())

    # The robot stands at the side, out of the way.
    view = PosedView(physics, plans, (1.6, sensor_y_m - 4.2, 0.0))
    return record_trial(view, place, Trial(seed), len(walker_m))


def _set_place(plan: ReferenceTrajectory, x_m: Array, y_m: float) -> None:
    """Set the place of a plan's pelvis on the floor."""
    plan.pelvis[:, 0] = x_m
    plan.pelvis[:, 1] = y_m


def _identity_error(result: TrialResult) -> tuple[bool, float]:
    """Return whether a dancer's identity changed or was lost, and the share of frames of dancers without a person."""
    persons = result.person[round(WAIT_S * RATE_HZ) :]
    wrong = False
    for dancer in range(persons.shape[1]):
        known = persons[persons[:, dancer] >= 0, dancer]
        wrong = wrong or len(set(known.tolist())) != 1
    return wrong, float((persons < 0).mean())
