"""Joints sensing: the true joints, seen or hidden as rays tell, with the slow errors of a depth skeleton.

White noise of the same size would wreck the detectors (1 cm is enough); what depth skeletons really show is a
constant bias and a slow drift, and both grow where a joint is hidden.
"""

from __future__ import annotations

import math
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from ..assets.names import JOINTS
from ..choreography.layout import Mount
from ..config import JointNoiseConfig, SensorConfig, SessionConfig
from ..core import Array, BoolArray, IntArray, SceneView, Skeletons, Solids
from ..core.memory import Memory
from ..core.registry import register
from .joint_occlusion import (
    BIAS,
    BLEND,
    DRIFT,
    ERRORS,
    EYE,
    FACTOR,
    HELD,
    HIDDEN,
    KEPT,
    LIMBS,
    PLACE,
    RANGE,
    SLOPES,
    observe,
)  # fmt: skip

T = TypeVar("T", bound=np.generic)

TORSO_BLEND_S = 0.75
"""Time constant with which an error grows or shrinks when a joint is hidden or seen again (assumed).

A hidden torso joint is off by some 1.5 cm more than a visible one; spread over .75 s that is 2 cm/s, 5 at most, far
below the .20 m/s of a move and the .15 m/s of an early event.
"""

HAND_BLEND_S = 0.15
"""The same for elbows, wrists and hands, which no motion event looks at (assumed)."""

_BLOCK_FRAMES = 32
"""Noise is drawn, and room made, for so many frames at a time: that is cheaper."""

_ARM = np.array([name.startswith(("Elbow", "Wrist", "Hand", "Thumb")) for name in JOINTS])


@register("sensing", "joints")
class JointSensing:
    """One sensor's skeletons of everybody on the stage, from the truth.

    A joint is *visible* if it lies in the field of view and range and the ray to it meets nothing before it but
    its own dancer's flesh. Visible joints are tracked. While some of the torso is visible a hidden joint is known all
    the same: one of the arms is inferred (until a moment after it comes back: see `sight.SETTLED_FACTOR`), any other
    is held in its place by the rest of the body and tracked, as by ``depth`` sensing. Out of view, or with the torso
    hidden too, a joint is not tracked and its position is NaN. Left and right are never confused, which a real sensor
    does behind a person's back.

    Errors are the sensor's own: a constant bias per person and joint, and a drift, other for limbs than for the rest,
    that follows a first-order autoregression over elapsed frames, also those that were lost or not taken; both times
    a factor that moves smoothly from 1 (visible) to ``occluded_factor`` (hidden).

    Args:
        mount: where the sensor is.
        config: the session, of which it takes ``dancers``, ``sensors`` and ``joint_noise``.
        rng: the sensor's own random stream; identities, errors and loss draw from separate children of it.

    Attributes:
        dancers: (P,) index of the dancer behind each row. Only for the record: it is what a server has to find out.
        visible: (P, 25) what the last frame could see.
    """

    def __init__(self, mount: Mount, config: SessionConfig, rng: np.random.Generator) -> None:
        group, sensors, noise = config.dancers, config.sensors, config.joint_noise
        order, self._draws, self._losses = rng.spawn(3)
        self.dancers: IntArray = order.permutation(group).astype(np.int64)
        self._shape = (group, len(JOINTS))
        self.visible: BoolArray = np.zeros(self._shape, dtype=bool)
        self._joint_noise = noise
        self._loss, self._rate_hz = sensors.frame_loss, sensors.rate_hz
        self._persons: IntArray = np.arange(group, dtype=np.int64)
        self._persons.flags.writeable = False
        self._eye = _eye(mount, sensors)
        self._errors = np.zeros((*self._shape, ERRORS))
        self._errors[:, :, BIAS:DRIFT] = noise.bias_m * self._normal()
        drift_m = np.where(LIMBS, noise.limb_drift_m, noise.drift_m)
        self._errors[:, :, DRIFT:FACTOR] = drift_m[:, None] * self._normal()
        self._errors[:, :, HIDDEN] = np.where(_ARM, noise.occluded_factor_hand, noise.occluded_factor)
        self._errors[:, :, BLEND] = self._errors[:, :, KEPT] = 1.0  # at first they are as that sight leaves them
        self._errors[:, :, HELD] = ~_ARM
        self._solids: Solids | None = None
        self._around = Memory()
        self._t_s = -math.inf
        self._frames = 0
        self._paces: dict[int, Array] = {}
        self._noise = np.zeros((_BLOCK_FRAMES, group * len(JOINTS), 3))
        self._own = Memory(self.dancers, self._eye, self._errors, self._noise)
        self._room = _Room(1, group)

    def sample(self, view: SceneView) -> Skeletons | None:
        """See the stage at this instant.

        Args:
            view: the stage; times of successive calls must not fall.

        Returns:
            the skeletons, or None if the frame was lost.
        """
        if self._loss and self._losses.random() < self._loss:
            return None
        t_s, before_s = view.time_s, self._t_s
        self._t_s = t_s
        if before_s > -math.inf:
            frames = max(1, round((t_s - before_s) * self._rate_hz))
            if frames != self._frames:
                self._pace(frames)
            if not self._room.left:
                self._draws.standard_normal(out=self._noise)
                self._room = _Room(_BLOCK_FRAMES, len(self.dancers))
        solids, room = view.solids, self._room
        if solids is not self._solids:
            self._solids, self._around = solids, Memory(*solids)
        room.left = frame = room.left - 1
        observe(view.joints_m, self._around.table, self._own.table, *room.arrays, frame)
        visible, joints, state = room.told
        self.visible = visible[frame]
        return Skeletons(self._persons, joints[frame], state[frame])

    def _pace(self, frames: int) -> None:
        """Let errors move as they do in so many frames; an idle sensor's intervals alternate."""
        self._frames = frames
        if frames not in self._paces:
            self._paces[frames] = _pace(self._joint_noise, self._rate_hz, frames)
        self._errors[:, :, BLEND:HELD] = self._paces[frames]

    def _normal(self) -> Array:
        """(P, 25, 3) unit white noise."""
        return self._draws.standard_normal((*self._shape, 3))


class _Room:
    """Where frames are written to, from the last to the first, and the same for whoever is told of them.

    Args:
        frames: how many.
        group: number of persons.

    Attributes:
        left: how many frames are not written yet.
        arrays: what is visible, joints and states.
        told: the same, not to be written.
    """

    __slots__ = ("arrays", "left", "told")

    def __init__(self, frames: int, group: int) -> None:
        self.left = frames
        shape = (frames, group, len(JOINTS))
        visible, joints, state = np.empty(shape, bool), np.empty((*shape, 3)), np.empty(shape, np.int8)
        self.arrays = visible, joints, state
        self.told = _frozen(visible), _frozen(joints), _frozen(state)


def _pace(config: JointNoiseConfig, rate_hz: int, frames: int) -> Array:
    """(25, 3) share of the factor's way in so many frames, share of the drift that is kept, what comes anew [m]."""
    kept = np.where(LIMBS, config.limb_drift_correlation, config.drift_correlation) ** frames
    blend = 1.0 - np.exp(-frames / rate_hz / np.where(_ARM, HAND_BLEND_S, TORSO_BLEND_S))
    drift_m = np.where(LIMBS, config.limb_drift_m, config.drift_m)
    return np.stack([blend, kept, drift_m * np.sqrt(1.0 - kept**2)], axis=1)


def _eye(mount: Mount, config: SensorConfig) -> Array:
    """The numbers of an eye; see `sight.EYE`."""
    out = np.zeros(EYE)
    out[:PLACE] = mount.world_from_sensor.T.reshape(-1)
    out[PLACE:SLOPES] = mount.position
    out[SLOPES:RANGE] = math.tan(config.horizontal_fov_rad / 2), math.tan(config.vertical_fov_rad / 2)
    out[RANGE:EYE] = config.min_range_m, config.max_range_m
    return out


def _frozen(values: NDArray[T]) -> NDArray[T]:
    """The same values, not to be written."""
    out = values.view()
    out.flags.writeable = False
    return out
