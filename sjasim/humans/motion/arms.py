"""Motion of the arms: at rest, swinging with the steps, and clapping.

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
from .speed_profile import minimum_jerk

LEFT = np.array([ACTUATED_INDEX[f"{joint}_L"] for joint in ARM_JOINTS])
"""(4,) columns of the left arm's hinges."""

RAISE_S = 0.45
"""First part of a clap: the hands go up [s]."""

CLOSE_S = 0.26
"""Second part: the hands close [s]."""

HOLD_S = 0.10
"""Third part: the hands stay together [s]."""

LOWER_S = 0.50
"""Last part: the hands go down [s]."""

PRESS = 0.0034
"""How far the closing hands aim beyond their contact, as a share of stature."""

MEET_S = 0.040
"""Time from the contact of the palms to the end of the closing motion [s]."""


@dataclass(frozen=True, slots=True)
class ArmPoses:
    """Angles of one arm (4,) in each pose [rad]; the other arm mirrors them.

    Attributes:
        stand: the arm hangs.
        open: before the clap, the hands raised and apart.
        closed: in the clap.
    """

    stand: Array
    open: Array
    closed: Array


@cache
def arm_poses(model: str) -> ArmPoses:
    """Arm poses of a body model, by inverse kinematics.

    All lengths scale with stature, so the angles are the same for every build.
    """
    body = body_model(model).anatomy(Build())
    h = body.build.stature_m
    reach = 0.165 * h
    height = 0.155 * h

    apart = _arm_angles(body, np.array([reach * 0.95, 0.13 * h, height]))
    together = _arm_angles(body, np.array([reach, body.hand_half_m - PRESS * h, height]))
    return ArmPoses(np.array([0.05, 0.08, 0.0, -0.18]), apart, together)


def _arm_angles(body: Anatomy, hand: Array) -> Array:
    """(4,) angles of the left arm that bring the hand to a point (3,) before the pelvis, palm to the right [rad]."""
    chains = body.chains()
    segment = body.index("forearm_L")
    names = {f"{joint}_L" for joint in ARM_JOINTS}
    hinges = [hinge for part in body.segments for hinge in part.hinges if hinge.name in names]
    low = [hinge.low_rad for hinge in hinges]
    high = [hinge.high_rad for hinge in hinges]

    def residuals(angles: Array) -> Array:
        q = np.zeros(25)
        q[LEFT] = angles
        position = joint_positions(chains, q, np.zeros(3), 0.0)[JOINT_INDEX["HandLeft"]] - hand
        palm = segment_rotation(chains, q, segment)[:, 1] - np.array([0.0, 1.0, 0.0])
        # The small weight on the angles picks one of the postures that reach the point.
        return np.concatenate([20.0 * position, 0.6 * palm, 0.02 * angles])

    starts = ([-0.6, 0.1, -0.5, -1.6], [-0.9, 0.0, 0.0, -1.2])
    fits = [least_squares(residuals, np.array(start), bounds=(low, high)) for start in starts]
    return np.asarray(min(fits, key=lambda fit: float(fit.cost)).x)


def add_arm_swing(arms: Array, span: NDArray[np.bool_], speed: Array, swing: Array) -> None:
    """Add the arms' swing during a walk, in place.

    Args:
        arms: (T, 8) angles of the left and the right arm [rad].
        span: (T,) mask of the walk's ticks; N are set.
        speed: (N,) speed of the pelvis [m/s].
        swing: (N,) -1 to 1, positive while the left arm goes forward.
    """
    reach = 0.35 * np.clip(speed / 0.3, 0.0, 1.0)

    arms[span, 0] -= reach * swing
    arms[span, 4] += reach * swing
    arms[span, 3] -= 0.4 * reach
    arms[span, 7] -= 0.4 * reach


def write_clap(arms: Array, times: Array, t_s: float, poses: ArmPoses) -> None:
    """Write a clap: the arms rise, close so that the palms meet at ``t_s``, hold and go down.

    Args:
        arms: (T, 8) angles of the left and the right arm, in place [rad].
        times: (T,) session times of the rows [s].
        t_s: session time of the clap.
        poses: poses of the arms.
    """
    end = t_s + HOLD_S + LOWER_S
    first, last = np.searchsorted(times, (t_s - CLOSE_S - RAISE_S, end))
    t = times[first:last, None] - t_s

    up = minimum_jerk((t + CLOSE_S + RAISE_S) / RAISE_S)
    shut = minimum_jerk((t + CLOSE_S) / (CLOSE_S + MEET_S))
    down = minimum_jerk((t - HOLD_S) / LOWER_S)

    pose = poses.open + shut * (poses.closed - poses.open)
    pose = poses.stand + (pose - poses.stand) * up * (1.0 - down)
    arms[first:last, :4] = pose
    arms[first:last, 4:] = pose
