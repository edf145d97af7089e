"""When one person starts and stops, regular and early events: the rules of the paper's motions, compiled.

Regular: the speed exceeds ``start_speed_m_s``, at the earliest ``min_hold_s`` after the last stop; it falls below ``stop_speed_m_s``,
at the earliest ``min_move_s`` after the start.

Early start: while standing, at least ``early_refractory_s`` after the stop, in ``early_frames`` consecutive frames at least
``early_joints`` of the four upper joints move by more than the floor in the same direction, which tells the kind:
nobody has to know the expected move. It is sent once and armed again after ``early_refractory_s``. Early stop: while moving,
after ``early_move_share`` of the duration of the person's last move of that kind, fewer than ``early_joints`` do so in
as many frames; never if no such move has been logged, nor with too few joints tracked to tell. At a brisk start or stop
the early event may come in the same frame as the regular one, and before it.
"""

from __future__ import annotations

import math
from math import inf, isnan

import numpy as np
from numba import njit

from ...core import Kind
from .frame_features import UPPER
from .thresholds import Record, Records

FACING_RAD = math.radians(45.0)
"""Largest heading relative to the sensor at which events count: a skeleton's depth errors double by 45 degrees."""

TURNING_RAD_S = 0.8
"""Yaw rate that counts as turning; walking swings the pelvis at up to half of it (assumed)."""

SWAYING_RAD_S = 0.4
"""Yaw rate above which early starts are disarmed for `SWAY_S`: dancers sway as they come out of a turn (assumed)."""

SWAY_S = 1.0
"""How long they do (assumed; the physics shows .6 s)."""

LOST_S = 0.3
"""A speed that is unknown for longer has hidden whatever happened meanwhile: less than the .4 s within which an event
counts as the true one (assumed)."""

BACKWARD, STANDING, FORWARD, UNSETTLED = -1, 0, 1, 2
"""What a person is doing; the moves' numbers are their sign along the way to the sensor."""

NOTHING = 0
EVENTS = {
    1: Kind.START_FORWARD,
    -1: Kind.START_BACKWARD,
    2: Kind.STOP_FORWARD,
    -2: Kind.STOP_BACKWARD,
}  # fmt: skip
"""An event as a number: the phase that starts, or twice the one that stops; `NOTHING` for none."""

PERSON = np.dtype([
    ("phase", np.int64),
    ("t_phase_s", np.float64),  # since when; all times are the sensor's
    ("t_early_s", np.float64),  # when the phase's early event was sent
    ("t_known_s", np.float64),  # when the speed was last known
    ("t_sway_s", np.float64),  # when the person last turned or swayed
    ("run", np.int64),  # frames in a row that speak for an early event; negative for moving away
    ("forward_s", np.float64),  # how long the last move forward took; infinite without one
    ("backward_s", np.float64),
])  # fmt: skip
"""What is remembered of one person's motion."""

_ROUNDING_S = 1e-6


def strangers(count: int) -> Records:
    """(count,) `PERSON` whom nobody has seen yet."""
    return np.array([(UNSETTLED, -inf, -inf, -inf, -inf, 0, inf, inf)] * count, dtype=PERSON)


@njit(cache=True)
def judge(person: Record, t_s: float, seen: Record, span_s: float, busy: bool, rules: Record) -> tuple[int, int]:
    """Judge one frame.

    Args:
        person: one of `PERSON`; changed.
        t_s: the sensor's time of the frame.
        seen: the person in it, one of `glimpse.GLIMPSE`.
        span_s: time over which its speed was taken [s].
        busy: whether a clap disarms the early start.
        rules: one of `thresholds.RULES`.

    Returns:
        the early event and the regular one that this frame shows, by their numbers in `EVENTS`. The onset of the
        regular one is estimated to be half a ``span_s`` ago.
    """
    aside = FACING_RAD < abs(seen.yaw_rad) < math.pi - FACING_RAD
    if aside or _missed_out(person, t_s, seen, rules):
        _enter(person, UNSETTLED, -inf)
        person.t_sway_s = -inf
    if person.phase == UNSETTLED:
        if not (aside or isnan(seen.yaw_rad)) and abs(seen.speed_m_s) < rules.stop_speed_m_s:
            _enter(person, STANDING, t_s)
    elif person.phase != STANDING:
        early = _early_stop(person, t_s, seen, rules)
        return early, _stop(person, t_s, seen, rules)
    elif abs(seen.yaw_rate_rad_s) > TURNING_RAD_S:
        _enter(person, STANDING, t_s)
        person.t_sway_s = t_s
    else:
        early = _early_start(person, t_s, seen, busy, rules)
        return early, _start(person, t_s, seen, rules)
    return NOTHING, NOTHING


@njit(cache=True)
def _missed_out(person: Record, t_s: float, seen: Record, rules: Record) -> bool:
    """Whether the person is back from out of sight, and not in the move they were in."""
    if isnan(seen.speed_m_s):
        return False
    lost = t_s - person.t_known_s > LOST_S
    person.t_known_s = t_s
    going = abs(person.phase) == FORWARD and person.phase * seen.speed_m_s >= rules.stop_speed_m_s
    return bool(lost and not going)


@njit(cache=True)
def _enter(person: Record, phase: int, t_s: float) -> None:
    person.phase = phase
    person.t_phase_s = t_s
    person.t_early_s = -inf
    person.run = 0


@njit(cache=True)
def _start(person: Record, t_s: float, seen: Record, rules: Record) -> int:
    rested_s = t_s - person.t_phase_s + _ROUNDING_S
    if not (abs(seen.speed_m_s) > rules.start_speed_m_s and rested_s >= rules.min_hold_s):
        return NOTHING
    phase = FORWARD if seen.speed_m_s > 0.0 else BACKWARD
    _enter(person, phase, t_s)
    return phase


@njit(cache=True)
def _early_start(person: Record, t_s: float, seen: Record, busy: bool, rules: Record) -> int:
    rested_s = t_s - person.t_phase_s + _ROUNDING_S
    if abs(seen.yaw_rate_rad_s) > SWAYING_RAD_S:
        person.t_sway_s = t_s
    if busy or t_s - person.t_sway_s < SWAY_S or min(rested_s, t_s - person.t_early_s) < rules.early_refractory_s:
        person.run = 0
        return NOTHING
    sign = int(seen.towards >= rules.early_joints) - int(seen.away >= rules.early_joints)
    person.run = person.run + sign if sign * person.run > 0 else sign
    if abs(person.run) < rules.early_frames:
        return NOTHING
    person.t_early_s = t_s
    return sign


@njit(cache=True)
def _stop(person: Record, t_s: float, seen: Record, rules: Record) -> int:
    phase, moved_s = person.phase, t_s - person.t_phase_s + _ROUNDING_S
    if not (moved_s >= rules.min_move_s and phase * seen.speed_m_s < rules.stop_speed_m_s):
        return NOTHING
    if phase == FORWARD:
        person.forward_s = t_s - person.t_phase_s
    else:
        person.backward_s = t_s - person.t_phase_s
    _enter(person, STANDING, t_s)
    return int(2 * phase)


@njit(cache=True)
def _early_stop(person: Record, t_s: float, seen: Record, rules: Record) -> int:
    phase, moved_s = person.phase, t_s - person.t_phase_s + _ROUNDING_S
    armed_s = rules.early_move_share * (person.forward_s if phase == FORWARD else person.backward_s)
    if moved_s < armed_s or person.t_early_s > person.t_phase_s:
        return NOTHING
    going = seen.towards if phase == FORWARD else seen.away
    still = seen.tracked - going > len(UPPER) - rules.early_joints
    person.run = person.run + 1 if still else 0
    if person.run < rules.early_frames:
        return NOTHING
    person.t_early_s = t_s
    return int(2 * phase)
