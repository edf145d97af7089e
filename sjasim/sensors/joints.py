"""Joints sensing: the true joints, seen or hidden as rays tell, with the slow errors of a depth skeleton.

White noise of the same size would wreck the detectors (1 cm is enough); what depth skeletons really show is a
constant bias and a slow drift, and both grow where a joint is hidden.
"""

from __future__ import annotations

import math

import numpy as np

from ..assets.names import JOINTS
from ..choreography.layout import Mount
from ..config import SensorConfig
from ..registry import register
from ..types import Array, BoolArray, IntArray, Skeletons, StageView
from .sight import BIAS, BLEND, DRIFT, ERRORS, FRESH, HIDDEN, KEPT, observe

_LIMBS = ("Elbow", "Wrist", "Hand", "Thumb", "Knee", "Ankle", "Foot")
FLESH_M = np.where([name.startswith(_LIMBS) for name in JOINTS], 0.13, 0.20)
"""(25,) A ray that first meets the joint's own dancer so close before the joint counts as reaching it: a trunk is that
thick, also seen from the side; a limb is not, and farther behind other flesh it is hidden by it (assumed)."""

TORSO_BLEND_S = 0.75
"""Time constant with which an error grows or shrinks when a joint is hidden or seen again (assumed).

A hidden torso joint is off by some 1.5 cm more than a visible one; spread over .75 s that is 2 cm/s, 5 at most, far
below the .20 m/s of a move and the .15 m/s of an early event.
"""

HAND_BLEND_S = 0.15
"""The same for elbows, wrists and hands, which no motion event looks at (assumed)."""

_BLOCK_FRAMES = 32
_NO_NOISE = np.empty((0, 3))

_ARM = np.array([name.startswith(("Elbow", "Wrist", "Hand", "Thumb")) for name in JOINTS])


@register("sensing", "joints")
class JointsSensing:
    """One sensor's skeletons of everybody on the stage, from the truth.

    A joint is *visible* if it lies in the field of view and range and the ray to it meets nothing before it but
    its own dancer's flesh. Visible joints are tracked (a moment after they come back: see `sight.SETTLED_FACTOR`),
    others inferred while some of the torso is visible; out of view, or with the torso hidden too, a joint is not
    tracked and its position is NaN. Left and right are never confused, which a real sensor does behind a person's back.

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
        order, self._draws, self._losses = rng.spawn(3)
        self.dancers: IntArray = order.permutation(group).astype(np.int64)
        self._shape = (group, len(JOINTS))
        self.visible: BoolArray = np.zeros(self._shape, dtype=bool)
        self._mount = mount
        self._config = config
        self._persons: IntArray = np.arange(group, dtype=np.int64)
        self._persons.flags.writeable = False
        slopes = [math.tan(angle / 2) for angle in (config.horizontal_fov_rad, config.vertical_fov_rad)]
        place = [*mount.world_from_sensor.T.reshape(-1), *mount.position]
        self._eye = np.array([*place, *slopes, config.min_range_m, config.max_range_m, 0.0, 0.0])
        size = group * len(JOINTS)
        errors = np.zeros((size, ERRORS))
        errors[:, BIAS : BIAS + 3] = config.bias_m * self._draws.standard_normal((size, 3))
        errors[:, DRIFT : DRIFT + 3] = config.drift_m * self._draws.standard_normal((size, 3))
        self._arm = np.tile(_ARM, (group, 1))
        self._errors = errors.reshape(*self._shape, ERRORS)
        self._errors[:, :, HIDDEN] = np.where(self._arm, config.hidden_factor_hand, config.hidden_factor)
        self._owners = np.arange(group).repeat(len(JOINTS))
        self._flesh = np.tile(FLESH_M, group)
        self._noises: list[Array] = []
        self._frames = 0
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
        truth = view.joints_m
        hidden = view.hidden(self._mount.position, truth.reshape(-1, 3), self._owners, self._flesh)
        t_s = view.time_s
        noise = _NO_NOISE if math.isinf(self._t_s) else self._noise()
        frames = 1 if math.isinf(self._t_s) else max(1, round((t_s - self._t_s) * self._config.rate_hz))
        self._t_s = t_s
        if frames != self._frames:
            self._pace(frames)
        self.visible = np.empty(self._shape, dtype=bool)
        joints = np.empty((*self._shape, 3))
        state = np.empty(self._shape, dtype=np.int8)
        observe(truth, self.dancers, hidden, self._eye, noise, self._errors, self.visible, joints, state)
        joints.flags.writeable = state.flags.writeable = False
        return Skeletons(self._persons, joints, state)

    def _noise(self) -> Array:
        """Unit white noise for one frame, (N, 3); drawn for many frames at a time, which is cheaper."""
        if not self._noises:
            size = len(self._owners)
            self._noises = list(self._draws.standard_normal((_BLOCK_FRAMES, size, 3)))
        return self._noises.pop()

    def _pace(self, frames: int) -> None:
        """How errors move in so many frames: share of the drift kept, what comes anew, share of the factor's way."""
        self._frames = frames
        kept = self._config.drift_correlation**frames
        self._eye[KEPT], self._eye[FRESH] = kept, self._config.drift_m * math.sqrt(1.0 - kept**2)
        blend_s = np.where(self._arm, HAND_BLEND_S, TORSO_BLEND_S)
        self._errors[:, :, BLEND] = 1.0 - np.exp(-frames / self._config.rate_hz / blend_s)
