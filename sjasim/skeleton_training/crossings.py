"""Dancers who walk past one another: whether a sensor still knows who is who.

A walker glides in the posture of a real walk behind, or before, two who stand; in an eclipse the walker halts behind
one of them, hidden from the sensor, for a second.
"""

from __future__ import annotations

import math

import numpy as np

from ..assets.names import JOINT_INDEX
from ..choreography.layout import layout
from ..config import BodyConfig, PhysicsConfig, RobotConfig, SessionConfig
from ..core import Array
from ..core.clock import stream
from ..humans.body.anatomy import Build
from ..humans.body.proportions import scaled_anatomy
from ..humans.motion.reference_trajectory import ReferenceTrajectory
from ..simulation.physics import Physics
from .scenes import RATE_HZ, planned, random_build
from .trials import PosedView, Trial, TrialResult, record_trial

_BASE = JOINT_INDEX["SpineBase"]
GAPS_M = (-0.8, 0.8, 1.2, 0.5)
"""How far behind the others the walker passes; negative is before them."""


def crossing_errors(seed: int, runs: int = 28) -> dict[str, float]:
    """Passing both others and back: runs with an identity changed or lost, worst share of frames without a person."""
    wrong, lost = 0, []
    for index in range(runs // 2):
        rng = stream(seed, "crossing", index)
        gap, speed = GAPS_M[index % len(GAPS_M)], float(rng.uniform(0.5, 0.8))
        path = np.concatenate([_ramp(-1.7, 1.7, speed), _ramp(1.7, -1.7, speed)])
        bad, share = _judge(_walk(seed + index, rng, gap, path))
        wrong += 2 * bad
        lost.append(share)
    return {"runs": 2 * (runs // 2), "wrong": wrong, "most_frames_lost": max(lost)}


def occlusion_errors(seed: int, runs: int = 8, hidden_s: float = 1.0) -> dict[str, float]:
    """Halting a second behind somebody tall and heavy; the walker is small."""
    wrong, lost = 0, []
    for index in range(runs):
        rng = stream(seed, "eclipse", index)
        speed = float(rng.uniform(0.5, 0.8))
        halt = np.full(round(hidden_s * RATE_HZ), -0.6 * _Z_BEHIND / _Z_FRONT)
        path = np.concatenate([_ramp(-1.7, float(halt[0]), speed), halt, _ramp(float(halt[0]), 0.3, speed)])
        bad, share = _judge(_walk(seed + 100 + index, rng, _Z_BEHIND - _Z_FRONT, path, small=True))
        wrong += bad
        lost.append(share)
    return {"runs": runs, "wrong": wrong, "most_frames_lost": max(lost)}


_Z_FRONT, _Z_BEHIND = 2.6, 3.5


def _ramp(start: float, end: float, speed: float) -> Array:
    count = max(2, round(abs(end - start) / speed * RATE_HZ))
    return np.linspace(start, end, count)


def _walk(seed: int, rng: np.random.Generator, gap: float, path: Array, *, small: bool = False) -> TrialResult:
    """Two stand .6 m left and right of the middle; the third passes at ``gap`` behind along x = ``path``."""
    builds = [random_build(rng) for _ in range(3)]
    if small:
        builds = [Build(1.92, 98.0), Build(1.92, 98.0), Build(1.52, 52.0)]
    bodies = [scaled_anatomy(build) for build in builds]
    length_s = len(path) / RATE_HZ + 2.0
    plans = [planned(body, [], length_s, heading_rad=math.pi / 2) for body in bodies]
    room = layout(SessionConfig())
    far_y = room.mounts[0].position[1]
    warm = round(1.5 * RATE_HZ)
    walker = np.concatenate([np.full(warm, path[0]), path, np.full(len(plans[2].yaw) - warm - len(path), path[-1])])
    _stand(plans[0], np.full(len(walker), -0.6), far_y - _Z_FRONT)
    _stand(plans[1], np.full(len(walker), 0.6), far_y - _Z_FRONT)
    _stand(plans[2], walker, far_y - _Z_FRONT - gap)
    joints, pelvis = np.array([plan.joints[0] for plan in plans]), np.array([plan.pelvis[0] for plan in plans])
    physics = Physics(bodies, room, (0.0, 0.0), joints, pelvis, PhysicsConfig(), BodyConfig(), RobotConfig())
    view = PosedView(physics, plans, (1.6, far_y - 4.2, 0.0))
    return record_trial(view, room, Trial(seed), len(walker))


def _stand(plan: ReferenceTrajectory, x: Array, y: float) -> None:
    plan.pelvis[:, 0], plan.pelvis[:, 1] = x, y


def _judge(outcome: TrialResult) -> tuple[bool, float]:
    """Whether an identity moved to somebody else or somebody got another, and the share of frames without one."""
    names = outcome.name[45:]
    wrong = False
    for k in range(names.shape[1]):
        known = names[names[:, k] >= 0, k]
        wrong = wrong or len(known) == 0 or known[-1] != known[0] or len(set(known.tolist())) > 1
    return wrong, float((names < 0).mean())
