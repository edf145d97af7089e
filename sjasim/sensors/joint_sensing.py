"""Joint sensing: skeletons from true joints, with occlusion by ray casting and the slow errors of a depth skeleton.

A white noise of the same size would make the event detectors useless (1 cm is enough). The errors of real depth
skeletons are a constant bias and a slow drift, and both grow where a joint is occluded.
"""

from __future__ import annotations

import math

import numpy as np

from ..assets.names import JOINTS
from ..choreography.layout import Mount
from ..config import JointNoiseConfig, SensorConfig, SessionConfig
from ..core import Array, BoolArray, IntArray, SceneView, Skeletons
from ..core.registry import register
from .joint_occlusion import ERROR_WIDTH, LIMBS, SENSOR_WIDTH, ErrorColumn, SensorColumn, observe_joints

TORSO_TIME_CONSTANT_S = 0.75
"""Time constant with which the errors of a torso joint grow or shrink when it is occluded or comes back; assumed.

An occluded torso joint is off by some 1.5 cm more than a visible one. Spread over .75 s that is 2 cm/s, 5 at most, far
below the .20 m/s that start a move and the .15 m/s of an early event.
"""

ARM_TIME_CONSTANT_S = 0.15
"""The same for elbows, wrists and hands, which no detector of moves reads; assumed."""

NOISE_BLOCK_FRAMES = 32
"""Noise is drawn for this many frames at a time, which is faster than frame by frame."""

ARMS = np.array([name.startswith(("Elbow", "Wrist", "Hand", "Thumb")) for name in JOINTS])
"""(25,) Which joints are of arms."""


@register("sensing", "joints")
class JointSensing:
    """Skeletons of all dancers as one sensor would estimate them, made from the true joints.

    A joint is *visible* if it lies in the field of view and range and the ray to it meets nothing but its own dancer's
    body close in front of it. Visible joints are tracked. While some of the torso is visible an occluded joint is known
    too: a joint of an arm is inferred (until a moment after it comes back, see `joint_occlusion.SETTLED_SCALE`); any
    other is held in its place by the rest of the body and tracked, as with depth sensing. A joint that is out of view,
    or whose torso is occluded too, is not tracked and its position is NaN. Left and right are never confused, which a
    real sensor does behind a person's back.

    Each sensor has errors of its own: a constant bias for each person and joint, and a drift that is a first-order
    autoregression over elapsed frames, lost and skipped ones included. Both are multiplied by a scale that moves
    smoothly between 1 (visible) and ``joint_noise.occluded_factor`` (occluded).

    Args:
        mount: where the sensor is.
        config: the session, of which it takes ``dancers``, ``sensors`` and ``joint_noise``.
        rng: the sensor's own random stream; identities, errors and losses draw from separate children of it.

    Attributes:
        dancers: (P,) dancer behind each row. Only for the record: it is what the server has to find out.
        visible: (P, 25) whether each joint was visible in the last frame.
    """

    def __init__(self, mount: Mount, config: SessionConfig, rng: np.random.Generator) -> None:
        order, self._draws, self._losses = rng.spawn(3)
        persons = config.dancers
        self.dancers: IntArray = order.permutation(persons).astype(np.int64)
        self.visible: BoolArray = np.zeros((persons, len(JOINTS)), dtype=bool)
        self._persons: IntArray = np.arange(persons, dtype=np.int64)
        self._persons.flags.writeable = False

        self._joint_noise = config.joint_noise
        self._frame_loss = config.sensors.frame_loss
        self._rate_hz = config.sensors.rate_hz
        self._sensor = _sensor_numbers(mount, config.sensors)
        self._errors = self._initial_errors(persons, config.joint_noise)

        self._t_s = -math.inf
        self._interval_frames = 0
        self._intervals: dict[int, Array] = {}
        self._noise = np.zeros((NOISE_BLOCK_FRAMES, persons * len(JOINTS), 3))
        self._noise_left = 1

    def _initial_errors(self, persons: int, noise: JointNoiseConfig) -> Array:
        """(P, 25, `ERROR_WIDTH`) error states at the start: bias and drift drawn, every joint as visible."""
        errors = np.zeros((persons, len(JOINTS), ERROR_WIDTH))
        shape = (persons, len(JOINTS), 3)
        errors[:, :, ErrorColumn.BIAS : ErrorColumn.DRIFT] = noise.bias_m * self._draws.standard_normal(shape)
        drift_m = np.where(LIMBS, noise.limb_drift_m, noise.drift_m)
        errors[:, :, ErrorColumn.DRIFT : ErrorColumn.SCALE] = drift_m[:, None] * self._draws.standard_normal(shape)
        errors[:, :, ErrorColumn.OCCLUDED_SCALE] = np.where(ARMS, noise.occluded_factor_hand, noise.occluded_factor)
        errors[:, :, ErrorColumn.HELD] = ~ARMS

        # The first frame jumps to the scale that visibility asks for, and leaves the drift as it is.
        errors[:, :, ErrorColumn.GAIN] = 1.0
        errors[:, :, ErrorColumn.KEPT] = 1.0
        return errors

    def sample(self, view: SceneView) -> Skeletons | None:
        """Estimate the skeletons of this instant.

        Args:
            view: the scene; times of successive calls must not decrease.

        Returns:
            the skeletons, or None if the frame was lost.
        """
        if self._frame_loss and self._losses.random() < self._frame_loss:
            return None

        first = self._t_s == -math.inf
        if not first:
            self._set_interval(max(1, round((view.time_s - self._t_s) * self._rate_hz)))
        self._t_s = view.time_s

        shape = self.visible.shape
        visible = np.empty(shape, bool)
        joints = np.empty((*shape, 3))
        state = np.empty(shape, np.int8)
        noise = self._next_noise()
        observe_joints(
            view.joints_m, *view.solids, self.dancers, self._sensor, self._errors, noise, visible, joints, state
        )
        for array in (visible, joints, state):
            array.flags.writeable = False
        self.visible = visible
        return Skeletons(self._persons, joints, state)

    def _set_interval(self, frames: int) -> None:
        """Set how the errors change over this many frames; the intervals of a standby sensor alternate."""
        if frames == self._interval_frames:
            return
        self._interval_frames = frames
        if frames not in self._intervals:
            self._intervals[frames] = _interval_columns(self._joint_noise, self._rate_hz, frames)
        self._errors[:, :, ErrorColumn.GAIN : ErrorColumn.HELD] = self._intervals[frames]

    def _next_noise(self) -> Array:
        """(P 25, 3) unit white noise of the next frame; the first frame needs none and takes zeros."""
        if not self._noise_left:
            self._draws.standard_normal(out=self._noise)
            self._noise_left = NOISE_BLOCK_FRAMES
        self._noise_left -= 1
        noise: Array = self._noise[self._noise_left]
        return noise


def _interval_columns(noise: JointNoiseConfig, rate_hz: int, frames: int) -> Array:
    """(25, 3) columns GAIN, KEPT and INNOVATION of the error states for an interval of some frames."""
    kept = np.where(LIMBS, noise.limb_drift_correlation, noise.drift_correlation) ** frames
    gain = 1.0 - np.exp(-frames / rate_hz / np.where(ARMS, ARM_TIME_CONSTANT_S, TORSO_TIME_CONSTANT_S))
    drift_m = np.where(LIMBS, noise.limb_drift_m, noise.drift_m)
    return np.stack([gain, kept, drift_m * np.sqrt(1.0 - kept**2)], axis=1)


def _sensor_numbers(mount: Mount, config: SensorConfig) -> Array:
    """(`SENSOR_WIDTH`,) numbers that describe a sensor, see `SensorColumn`."""
    out = np.zeros(SENSOR_WIDTH)
    out[SensorColumn.ROTATION : SensorColumn.POSITION] = mount.world_from_sensor.T.reshape(-1)
    out[SensorColumn.POSITION : SensorColumn.TANGENTS] = mount.position
    out[SensorColumn.TANGENTS] = math.tan(config.horizontal_fov_rad / 2)
    out[SensorColumn.TANGENTS + 1] = math.tan(config.vertical_fov_rad / 2)
    out[SensorColumn.RANGE :] = config.min_range_m, config.max_range_m
    return out
