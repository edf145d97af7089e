"""Joints sensing: the true joints, seen or hidden as rays tell, with the slow errors of a depth skeleton.

White noise of the same size would wreck the detectors (1 cm is enough); what depth skeletons really show is a
constant bias and a slow drift, and both grow where a joint is hidden.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ..assets.names import JOINT_INDEX, JOINTS
from ..choreography.layout import Mount
from ..config import SensorConfig
from ..registry import register
from ..types import TRACKED, Array, IntArray, Skeletons, StageView

BoolArray = NDArray[np.bool_]

FLESH_M = 0.20
"""A ray that first meets the joint's own dancer so close before the joint counts as reaching it (assumed)."""

TORSO_BLEND_S = 0.5
"""Time constant with which an error grows or shrinks when a joint is hidden or seen again (assumed).

A hidden torso joint is off by some 1 cm more than a visible one; spread over half a second that is 3 cm/s, far
below the .20 m/s of a move and the .15 m/s of an early event.
"""

HAND_BLEND_S = 0.15
"""The same for elbows, wrists and hands, which no motion event looks at (assumed)."""

SETTLED_FACTOR = 1.5
"""A joint that is seen again is tracked once its error is at most this much larger than a visible joint's (assumed)."""

TORSO = tuple(
    JOINT_INDEX[name]
    for name in ("SpineBase", "SpineMid", "SpineShoulder", "ShoulderLeft", "ShoulderRight", "HipLeft", "HipRight")
)
"""While any of these is visible, the person's hidden joints are inferred."""

_ARM = np.array([name.startswith(("Elbow", "Wrist", "Hand", "Thumb")) for name in JOINTS])


@register("sensing", "joints")
class JointsSensing:
    """One sensor's skeletons of everybody on the stage, from the truth.

    A joint is *visible* if it lies in the field of view and range and the ray to it meets nothing before it but
    its own dancer's flesh. Visible joints are tracked (a moment after they come back: see `SETTLED_FACTOR`), others
    inferred while some of the torso is visible; out of view, or with the torso hidden too, a joint is not tracked
    and its position is NaN. Left and right are never confused, which a real sensor does behind a person's back.

    Errors are the sensor's own: a constant bias per person and joint, and a drift that follows a first-order
    autoregression over elapsed frames, also those that were lost or not taken; both times a factor that moves
    smoothly from 1 (visible) to ``hidden_factor`` (hidden).

    Args:
        mount: where the sensor is.
        config: field of view, range, errors, loss.
        group: number of dancers.
        rng: the sensor's own random stream; identities, errors and loss draw from separate children of it.

    Attributes:
        dancers: (P,) index of the dancer behind each row. Only for the record: it is what a server has to find out.
        visible: (P, 25) what the last frame could see.
    """

    def __init__(self, mount: Mount, config: SensorConfig, group: int, rng: np.random.Generator) -> None:
        order, self._errors, self._losses = rng.spawn(3)
        self.dancers: IntArray = order.permutation(group).astype(np.int64)
        self.visible: BoolArray = np.zeros((group, len(JOINTS)), dtype=bool)
        self._mount = mount
        self._config = config
        self._persons: IntArray = np.arange(group, dtype=np.int64)
        self._persons.flags.writeable = False
        self._slope = np.array([math.tan(config.horizontal_fov_rad / 2), math.tan(config.vertical_fov_rad / 2)])
        shape = (group, len(JOINTS), 3)
        self._bias = config.bias_m * self._errors.standard_normal(shape)
        self._drift = config.drift_m * self._errors.standard_normal(shape)
        self._hidden = np.where(_ARM, config.hidden_factor_hand, config.hidden_factor)
        self._factor: Array = np.empty(0)
        self._paces: dict[int, tuple[float, float, Array]] = {}
        self._t_s = -math.inf

    def sample(self, view: StageView) -> Skeletons | None:
        """See the stage at this instant.

        Args:
            view: the stage; times of successive calls must not fall.

        Returns:
            the skeletons, or None if the frame was lost.
        """
        if self._config.frame_loss and self._losses.random() < self._config.frame_loss:
            return None
        offset = view.joints_m[self.dancers] - self._mount.position
        local = offset @ self._mount.world_from_sensor
        in_view = self._in_view(local)
        self.visible = in_view & self._reached(view, offset)
        factor = self._advance(view.time_s)
        known = in_view & self.visible[:, TORSO].any(axis=1)[:, None]
        tracked = self.visible & (factor <= SETTLED_FACTOR)
        state = known * (1 + (tracked & known).view(np.int8)).astype(np.int8)
        joints = self._bias + self._drift
        joints *= factor[:, :, None]
        joints += local
        if not known.all():
            joints[~known] = np.nan
        joints.flags.writeable = state.flags.writeable = False
        return Skeletons(self._persons, joints, state)

    def _in_view(self, local: Array) -> BoolArray:
        depth = local[:, :, 2]
        inside = np.abs(local[:, :, :2]) <= depth[:, :, None] * self._slope
        near, far = self._config.min_range_m, self._config.max_range_m
        within: BoolArray = inside[:, :, 0] & inside[:, :, 1] & (depth >= near) & (depth <= far)
        return within

    def _reached(self, view: StageView, offset: Array) -> BoolArray:
        distance = np.sqrt(np.einsum("pji,pji->pj", offset, offset))
        hit, owner = view.first_hits(self._mount.position, (offset / distance[:, :, None]).reshape(-1, 3))
        own = owner.reshape(distance.shape) == self.dancers[:, None]
        hit = hit.reshape(distance.shape)
        reached: BoolArray = (hit < 0.0) | (hit >= distance - FLESH_M * own)
        return reached

    def _advance(self, t_s: float) -> Array:
        """Move the errors on to this frame and return their factor, (P, 25)."""
        target = np.where(self.visible, 1.0, self._hidden)
        if not self._factor.size:
            self._factor = target
        else:
            kept, fresh, blend = self._pace(max(1, round((t_s - self._t_s) * self._config.rate_hz)))
            self._drift *= kept
            self._drift += fresh * self._errors.standard_normal(self._drift.shape)
            self._factor = self._factor + blend * (target - self._factor)
        self._t_s = t_s
        return self._factor

    def _pace(self, frames: int) -> tuple[float, float, Array]:
        """After so many frames: share of the drift kept, s.d. of what is added [m], (25,) share of a factor's change."""
        if frames not in self._paces:
            kept = self._config.drift_correlation**frames
            blend = 1.0 - np.exp(-frames / self._config.rate_hz / np.where(_ARM, HAND_BLEND_S, TORSO_BLEND_S))
            self._paces[frames] = (kept, self._config.drift_m * math.sqrt(1.0 - kept**2), blend)
        return self._paces[frames]
