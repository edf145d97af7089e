"""Detection of starts and stops of one person: the regular and the early events.

Regular events follow the speed of SpineBase towards the sensor. A move starts when the speed exceeds
``start_speed_m_s``, at the earliest ``min_hold_s`` after the last stop. It stops when the speed falls below
``stop_speed_m_s``, at the earliest ``min_move_s`` after the start. Two thresholds (hysteresis) and the shortest
durations keep noise from starting and stopping a move repeatedly.

Early events follow the steps of the four upper joints from frame to frame. Joints that step farther than the floor
``early_displacement_m`` count as moving.

* An early start is detected while a person stands, when at least ``early_joints`` of the tracked joints move in the
  same direction in ``early_frames`` consecutive frames. The direction tells the kind, so the expected move need not be
  known. The event is armed ``early_refractory_s`` after the stop, and again as long after the event.
* An early stop is detected once during a move, when fewer than ``early_joints`` joints can be moving in
  ``early_frames`` consecutive frames: joints that are not tracked count as moving. The event is armed after
  ``early_move_share`` of the duration of the person's last move of the same kind, and never before such a move.

A brisk move may show the early event in the same frame as the regular one; the early event then comes first.

Source: iqbal2016, section II-B, for joints, axis and "half of the joint positions"; it gives neither speeds nor times.
"""

from __future__ import annotations

import math
from math import inf, isnan

import numpy as np

from ...core import Kind
from ...core.compiled import compiled_inner
from .frame_features import UPPER_JOINTS
from .thresholds import Record, Records

FACING_RAD = math.radians(45.0)
"""Largest heading relative to the sensor at which events are detected; depth errors of a skeleton double up to it."""

TURNING_RAD_S = 0.8
"""Yaw rate above which a person turns; walking swings the pelvis at up to half of this rate (assumed)."""

SWAY_RAD_S = 0.4
"""Yaw rate above which early starts are disarmed for `SWAY_S`: dancers sway after a turn (assumed)."""

SWAY_S = 1.0
"""Duration for which early starts stay disarmed after a turn or sway (assumed; simulated bodies sway for 0.6 s)."""

LOST_S = 0.3
"""Longest time without a known speed that is bridged (assumed).

Events during a longer time may have been missed. The limit is below the 0.4 s within which a detected event is matched
to a true one.
"""

BACKWARD = -1
"""Phase: the person moves away from the sensor."""

STANDING = 0
"""Phase: the person stands."""

FORWARD = 1
"""Phase: the person moves towards the sensor."""

UNKNOWN = 2
"""Phase: the person has not been seen standing yet; no event is detected."""

NO_EVENT = 0
"""Event code for no event."""

KIND_OF_CODE = {
    FORWARD: Kind.START_FORWARD,
    BACKWARD: Kind.START_BACKWARD,
    2 * FORWARD: Kind.STOP_FORWARD,
    2 * BACKWARD: Kind.STOP_BACKWARD,
}
"""Event code to kind. The code of a start is the phase that starts; the code of a stop is twice the phase that ends."""

MOTION_STATE = np.dtype([
    ("phase", np.int64),  # BACKWARD, STANDING, FORWARD or UNKNOWN
    ("t_phase_s", np.float64),  # start of the phase
    ("t_early_s", np.float64),  # time of the phase's early event
    ("t_speed_s", np.float64),  # last time at which the speed was known
    ("t_sway_s", np.float64),  # last time at which the person turned or swayed
    ("early_run", np.int64),  # consecutive frames that support an early event; negative for a start backward
    ("forward_s", np.float64),  # duration of the last move forward; infinite if there was none
    ("backward_s", np.float64),  # duration of the last move backward
])  # fmt: skip
"""State of one person's move detection; times are those of the sensor."""

_ROUNDING_S = 1e-6


def initial_motion_states(persons: int) -> Records:
    """Return (persons,) `MOTION_STATE` of persons who have not been seen yet."""
    return np.array([(UNKNOWN, -inf, -inf, -inf, -inf, 0, inf, inf)] * persons, dtype=MOTION_STATE)


@compiled_inner
def detect_motion(
    person: Record, t_s: float, features: Record, early_start_blocked: bool, thresholds: Record
) -> tuple[int, int]:
    """Update the state with one frame and return the events that the frame shows.

    Args:
        person: one of `MOTION_STATE`; changed.
        t_s: time of the frame.
        features: one of `FRAME_FEATURES`.
        early_start_blocked: whether early starts are disarmed, because the person may be clapping.
        thresholds: one of `THRESHOLDS`.

    Returns:
        codes of the early and of the regular event, keys of `KIND_OF_CODE`; `NO_EVENT` for none.
    """
    sideways = FACING_RAD < abs(features.yaw_rad) < math.pi - FACING_RAD
    if sideways or _motion_was_missed(person, t_s, features, thresholds):
        _enter_phase(person, UNKNOWN, -inf)
        person.t_sway_s = -inf

    if person.phase == UNKNOWN:
        heading_fits = not (sideways or isnan(features.yaw_rad))
        if heading_fits and abs(features.approach_speed_m_s) < thresholds.stop_speed_m_s:
            _enter_phase(person, STANDING, t_s)
    elif person.phase != STANDING:
        # Early events first: a regular event ends the phase that they belong to.
        early = _early_stop(person, t_s, features, thresholds)
        return early, _regular_stop(person, t_s, features, thresholds)
    elif abs(features.yaw_rate_rad_s) > TURNING_RAD_S:
        # A turn restarts the phase, and with it the times that arm the starts.
        _enter_phase(person, STANDING, t_s)
        person.t_sway_s = t_s
    else:
        early = _early_start(person, t_s, features, early_start_blocked, thresholds)
        return early, _regular_start(person, t_s, features, thresholds)
    return NO_EVENT, NO_EVENT


@compiled_inner
def _motion_was_missed(person: Record, t_s: float, features: Record, thresholds: Record) -> bool:
    """Return whether the speed was unknown for too long and the person is not in the same move as before."""
    if isnan(features.approach_speed_m_s):
        return False
    lost = t_s - person.t_speed_s > LOST_S
    person.t_speed_s = t_s
    still_moving = (
        abs(person.phase) == FORWARD and person.phase * features.approach_speed_m_s >= thresholds.stop_speed_m_s
    )
    return bool(lost and not still_moving)


@compiled_inner
def _enter_phase(person: Record, phase: int, t_s: float) -> None:
    """Start a phase at ``t_s`` and arm its early event anew."""
    person.phase = phase
    person.t_phase_s = t_s
    person.t_early_s = -inf
    person.early_run = 0


@compiled_inner
def _regular_start(person: Record, t_s: float, features: Record, thresholds: Record) -> int:
    """Return the code of a regular start, or `NO_EVENT`."""
    stood_s = t_s - person.t_phase_s + _ROUNDING_S
    speed_m_s = features.approach_speed_m_s
    if not (abs(speed_m_s) > thresholds.start_speed_m_s and stood_s >= thresholds.min_hold_s):
        return NO_EVENT

    phase = FORWARD if speed_m_s > 0.0 else BACKWARD
    _enter_phase(person, phase, t_s)
    return phase


@compiled_inner
def _early_start(person: Record, t_s: float, features: Record, blocked: bool, thresholds: Record) -> int:
    """Return the code of an early start, or `NO_EVENT`."""
    stood_s = t_s - person.t_phase_s + _ROUNDING_S
    if abs(features.yaw_rate_rad_s) > SWAY_RAD_S:
        person.t_sway_s = t_s
    swaying = t_s - person.t_sway_s < SWAY_S
    if blocked or swaying or min(stood_s, t_s - person.t_early_s) < thresholds.early_refractory_s:
        person.early_run = 0
        return NO_EVENT

    # Zero if as many joints move towards the sensor as away from it.
    approaching = int(features.joints_approaching >= thresholds.early_joints)
    receding = int(features.joints_receding >= thresholds.early_joints)
    direction = approaching - receding
    person.early_run = person.early_run + direction if direction * person.early_run > 0 else direction
    if abs(person.early_run) < thresholds.early_frames:
        return NO_EVENT

    person.t_early_s = t_s
    return direction


@compiled_inner
def _regular_stop(person: Record, t_s: float, features: Record, thresholds: Record) -> int:
    """Return the code of a regular stop, or `NO_EVENT`; keep the duration of the move."""
    phase = person.phase
    moved_s = t_s - person.t_phase_s + _ROUNDING_S
    slow = phase * features.approach_speed_m_s < thresholds.stop_speed_m_s
    if not (moved_s >= thresholds.min_move_s and slow):
        return NO_EVENT

    if phase == FORWARD:
        person.forward_s = t_s - person.t_phase_s
    else:
        person.backward_s = t_s - person.t_phase_s
    _enter_phase(person, STANDING, t_s)
    return int(2 * phase)


@compiled_inner
def _early_stop(person: Record, t_s: float, features: Record, thresholds: Record) -> int:
    """Return the code of an early stop, or `NO_EVENT`."""
    phase = person.phase
    moved_s = t_s - person.t_phase_s + _ROUNDING_S
    last_move_s = person.forward_s if phase == FORWARD else person.backward_s
    if moved_s < thresholds.early_move_share * last_move_s or person.t_early_s > person.t_phase_s:
        return NO_EVENT

    # Joints that are not tracked may move, so only tracked joints count as still.
    moving = features.joints_approaching if phase == FORWARD else features.joints_receding
    still = features.joints_tracked - moving > len(UPPER_JOINTS) - thresholds.early_joints
    person.early_run = person.early_run + 1 if still else 0
    if person.early_run < thresholds.early_frames:
        return NO_EVENT

    person.t_early_s = t_s
    return int(2 * phase)
