"""Arms: how they hang, swing with the steps, and meet in a clap.

Where the hands meet and how fast they close is assumed.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from ...assets.names import ACTUATED_INDEX, ARM_JOINTS, JOINT_INDEX
from ...core import Array
from ..body.anatomy import Anatomy, Build
from ..body.body_model import body_model
from ..body.kinematics import joint_positions, segment_rotation
from .speed_profile import smooth

LEFT = np.array([ACTUATED_INDEX[f"{joint}_L"] for joint in ARM_JOINTS])
RAISE_S, CLOSE_S, HOLD_S, LOWER_S = 0.45, 0.26, 0.10, 0.50
"""A clap's parts [s]: hands up, hands together, hands held, hands down."""
PRESS = 0.0034
"""How far the closing hands aim past their contact, as a share of stature."""
MEET_S = 0.040
"""The palms touch so long before the closing motion would end [s]."""


@dataclass(frozen=True, slots=True)
class ArmPoses:
    """Angles of one arm (4,) in each of the poses; the other arm mirrors them [rad]."""

    stand: Array
    open: Array
    closed: Array


@cache
def arm_poses(model: str) -> ArmPoses:
    """Poses of every build of a body model: all lengths go with stature, so the angles are the same for everybody.

    The clapping ones are found by inverse kinematics.
    """
    body = body_model(model).anatomy(Build())
    h = body.build.stature_m
    reach, height = 0.165 * h, 0.155 * h
    apart = _reach(body, np.array([reach * 0.95, 0.13 * h, height]))
    together = _reach(body, np.array([reach, body.hand_half_m - PRESS * h, height]))
    return ArmPoses(np.array([0.05, 0.08, 0.0, -0.18]), apart, together)


def _reach(body: Anatomy, hand: Array) -> Array:
    """Angles (4,) of the left arm that bring the hand to a point (3,) before the pelvis, palm to the middle."""
    chains = body.chains()
    segment = body.index("forearm_L")
    hinges = [hinge for part in body.segments for hinge in part.hinges if hinge.name in {f"{j}_L" for j in ARM_JOINTS}]
    low = [hinge.low_rad for hinge in hinges]
    high = [hinge.high_rad for hinge in hinges]

    def misses(angles: Array) -> Array:
        q = np.zeros(25)
        q[LEFT] = angles
        miss = joint_positions(chains, q, np.zeros(3), 0.0)[JOINT_INDEX["HandLeft"]] - hand
        palm = segment_rotation(chains, q, segment)[:, 1] - np.array([0.0, 1.0, 0.0])
        return np.concatenate([20.0 * miss, 0.6 * palm, 0.02 * angles])

    starts = ([-0.6, 0.1, -0.5, -1.6], [-0.9, 0.0, 0.0, -1.2])
    fits = [least_squares(misses, np.array(start), bounds=(low, high)) for start in starts]
    return np.asarray(min(fits, key=lambda fit: float(fit.cost)).x)


def walk(arms: Array, span: NDArray[np.bool_], speed: Array, swing: Array) -> None:
    """Swing the arms with the steps, in place.

    Args:
        arms: (T, 8) angles of both arms [rad].
        span: (T,) mask of the walk's ticks; N are set.
        speed: (N,) speed of the pelvis [m/s].
        swing: (N,) -1 to 1, positive while the left arm goes forward.
    """
    reach = 0.35 * np.clip(speed / 0.3, 0.0, 1.0)
    arms[span, 0] -= reach * swing
    arms[span, 4] += reach * swing
    arms[span, 3] -= 0.4 * reach
    arms[span, 7] -= 0.4 * reach


def clap(arms: Array, times: Array, t_s: float, poses: ArmPoses) -> None:
    """Raise, close, hold and lower both arms so that the palms meet at ``t_s``, in place on arms (T, 8) [rad]."""
    end = t_s + HOLD_S + LOWER_S
    first, last = np.searchsorted(times, (t_s - CLOSE_S - RAISE_S, end))
    t = times[first:last, None] - t_s
    up = smooth((t + CLOSE_S + RAISE_S) / RAISE_S)
    shut = smooth((t + CLOSE_S) / (CLOSE_S + MEET_S))
    down = smooth((t - HOLD_S) / LOWER_S)
    pose = poses.open + shut * (poses.closed - poses.open)
    pose = poses.stand + (pose - poses.stand) * up * (1.0 - down)
    arms[first:last, :4] = pose
    arms[first:last, 4:] = pose
