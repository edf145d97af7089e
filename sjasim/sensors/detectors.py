"""Events from skeleton frames: five regular kinds and four early ones, for every person in front of a sensor.

Forward is towards the sensor. Nothing here knows the choreography. What the rules add to the bare thresholds:

* Motion counts only while the person faces the sensor, or turns their back to it, within `FACING_RAD`; a clap only
  face to face. Someone who stands sideways gives no event, and a move during which a person turns away gets no stop.
  Seen from behind, too, forward is towards the sensor: who knows where people face has to exchange the kinds.
* After a reset, after facing the sensor anew, and after having been out of sight for `LOST_S`, a person must first be
  seen standing; a motion already under way gives no event. Whoever comes back into sight still in the same move goes
  on with it; a stop or a start that happened out of sight is nobody's event, since its time is not known. While a
  person turns faster than `TURNING_RAD_S` the times that arm the start events begin anew.
* A SpineBase that is inferred serves the regular events. Early events count tracked joints only, since errors of
  inferred ones exceed the floor. A clap needs both hands tracked until shortly before they meet, where they hide
  each other: a hand the sensor cannot see is worth some 10 cm of error, and a guessed clap is worse than a lost one.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace
from enum import IntEnum
from typing import NamedTuple

from ..config import DetectorConfig
from ..types import DeviceEvent, IntArray, Kind, MoveDuration, SkeletonFrame
from .claps import ClapDetector
from .glimpse import Glimpse, Glimpses, frames_at

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

MEETING_S = 0.1
"""How long the hands may be inferred as they meet (assumed)."""

_UPPER_JOINTS = 4
_ROUNDING_S = 1e-6


class _Phase(IntEnum):
    """What a person is doing; the moves' values are their sign along the way to the sensor."""

    BACKWARD = -1
    STANDING = 0
    FORWARD = 1
    UNSETTLED = 2


_START = {_Phase.FORWARD: Kind.START_FORWARD, _Phase.BACKWARD: Kind.START_BACKWARD}
_STOP = {_Phase.FORWARD: Kind.STOP_FORWARD, _Phase.BACKWARD: Kind.STOP_BACKWARD}


class Sighting(NamedTuple):
    """An event just detected: its kind, whether it is early, and the sensor's time of the estimated onset (or None)."""

    kind: Kind
    early: bool
    t_onset_s: float | None = None


class MotionDetector:
    """Starts and stops of one person, regular and early.

    Regular: the speed exceeds ``on_m_s``, at the earliest ``min_hold_s`` after the last stop; it falls below
    ``off_m_s``, at the earliest ``min_move_s`` after the start.

    Early start: while standing, at least ``early_rest_s`` after the stop, in ``early_frames`` consecutive frames
    at least ``early_joints`` of the four upper joints move by more than the floor in the same direction, which
    tells the kind: nobody has to know the expected move. It is sent once and armed again after ``early_rest_s``.
    Early stop: while moving, after ``early_move_share`` of the duration of the person's last move of that kind,
    fewer than ``early_joints`` do so in as many frames; never if no such move has been logged, nor with too few
    joints tracked to tell. At a brisk start or stop the early event may come in the same frame as the regular one,
    and before it.

    Args:
        config: thresholds.
        durations: start kind -> duration of the person's last move of that kind [s]; shared with the caller.
    """

    __slots__ = ("_c", "_phase", "_run", "_since_s", "_t_early_s", "_t_known_s", "_t_sway_s", "durations")

    def __init__(self, config: DetectorConfig, durations: dict[Kind, float]) -> None:
        self._c = config
        self.durations = durations
        self._t_known_s = -math.inf
        self.reset()

    def reset(self) -> None:
        """Forget everything but the durations; the person must be seen standing before events come."""
        self._phase = _Phase.UNSETTLED
        self._since_s = self._t_early_s = self._t_sway_s = -math.inf
        self._run = 0

    def update(self, t_s: float, seen: Glimpse, span_s: float, busy: bool) -> tuple[Sighting | None, Sighting | None]:
        """Judge one frame.

        Args:
            t_s: the sensor's time of the frame.
            seen: the person in it.
            span_s: time over which its speed was taken [s].
            busy: whether a clap disarms the early start.

        Returns:
            the early event and the regular one that this frame shows, each or None.
        """
        aside = FACING_RAD < abs(seen.yaw_rad) < math.pi - FACING_RAD
        if aside or self._missed_out(t_s, seen):
            self.reset()
        if self._phase is _Phase.UNSETTLED:
            if not (aside or math.isnan(seen.yaw_rad)) and abs(seen.speed_m_s) < self._c.off_m_s:
                self._enter(_Phase.STANDING, t_s)
        elif self._phase is not _Phase.STANDING:
            moved_s = t_s - self._since_s + _ROUNDING_S
            return self._early_stop(t_s, moved_s, seen), self._stop(t_s, moved_s, seen, span_s)
        elif abs(seen.yaw_rate_rad_s) > TURNING_RAD_S:
            self._enter(_Phase.STANDING, t_s)
            self._t_sway_s = t_s
        else:
            rested_s = t_s - self._since_s + _ROUNDING_S
            return self._early_start(t_s, rested_s, seen, busy), self._start(t_s, rested_s, seen, span_s)
        return None, None

    def _missed_out(self, t_s: float, seen: Glimpse) -> bool:
        """Whether the person is back from out of sight, and not in the move they were in."""
        if math.isnan(seen.speed_m_s):
            return False
        lost = t_s - self._t_known_s > LOST_S
        self._t_known_s = t_s
        going = self._phase in _START and self._phase * seen.speed_m_s >= self._c.off_m_s
        return lost and not going

    def _enter(self, phase: _Phase, t_s: float) -> None:
        self._phase = phase
        self._since_s = t_s
        self._t_early_s = -math.inf
        self._run = 0

    def _start(self, t_s: float, rested_s: float, seen: Glimpse, span_s: float) -> Sighting | None:
        if not (abs(seen.speed_m_s) > self._c.on_m_s and rested_s >= self._c.min_hold_s):
            return None
        phase = _Phase.FORWARD if seen.speed_m_s > 0.0 else _Phase.BACKWARD
        self._enter(phase, t_s)
        return Sighting(_START[phase], False, t_s - span_s / 2)

    def _early_start(self, t_s: float, rested_s: float, seen: Glimpse, busy: bool) -> Sighting | None:
        if abs(seen.yaw_rate_rad_s) > SWAYING_RAD_S:
            self._t_sway_s = t_s
        busy = busy or t_s - self._t_sway_s < SWAY_S
        if busy or min(rested_s, t_s - self._t_early_s) < self._c.early_rest_s:
            self._run = 0
            return None
        enough = self._c.early_joints
        sign = (seen.towards >= enough) - (seen.away >= enough)
        self._run = self._run + sign if sign * self._run > 0 else sign
        if abs(self._run) < self._c.early_frames:
            return None
        self._t_early_s = t_s
        return Sighting(_START[_Phase(sign)], True)

    def _stop(self, t_s: float, moved_s: float, seen: Glimpse, span_s: float) -> Sighting | None:
        phase = self._phase
        if not (moved_s >= self._c.min_move_s and phase * seen.speed_m_s < self._c.off_m_s):
            return None
        self.durations[_START[phase]] = t_s - self._since_s
        self._enter(_Phase.STANDING, t_s)
        return Sighting(_STOP[phase], False, t_s - span_s / 2)

    def _early_stop(self, t_s: float, moved_s: float, seen: Glimpse) -> Sighting | None:
        phase = self._phase
        armed_s = self._c.early_move_share * self.durations.get(_START[phase], math.inf)
        if moved_s < armed_s or self._t_early_s > self._since_s:
            return None
        going = seen.towards if phase is _Phase.FORWARD else seen.away
        still = seen.tracked - going > _UPPER_JOINTS - self._c.early_joints
        self._run = self._run + 1 if still else 0
        if self._run < self._c.early_frames:
            return None
        self._t_early_s = t_s
        return Sighting(_STOP[phase], True)


class Detectors:
    """All persons' detectors of one client.

    Args:
        config: thresholds.
        rate_hz: nominal frame rate.
    """

    def __init__(self, config: DetectorConfig, rate_hz: float) -> None:
        self._config = replace(config, early_frames=frames_at(rate_hz, config.early_frames))
        self._glimpses = Glimpses(config, rate_hz)
        self._durations: dict[int, dict[Kind, float]] = {}
        self._persons: IntArray | None = None
        self._names: list[int] = []
        self._motion: list[MotionDetector] = []
        self._claps: list[ClapDetector] = []

    def reset(self) -> None:
        """Begin anew: nobody has been seen standing yet. Logged durations of moves are kept."""
        self._persons = None

    def learn(self, durations: Iterable[MoveDuration]) -> None:
        """Take over durations of moves that other clients logged."""
        for known in durations:
            self._durations.setdefault(known.person, {})[known.start] = known.duration_s

    def update(self, frame: SkeletonFrame) -> list[DeviceEvent]:
        """Judge one frame; frames come in order of their time, some may be missing.

        Args:
            frame: all persons' skeletons. If the persons differ from the last frame's, all detectors begin anew.

        Returns:
            the events that it shows, in order of the persons, stamped with the time it had been processed.
        """
        persons = frame.skeletons.persons
        if persons is not self._persons:
            self._meet(persons)
        seen = self._glimpses.update(frame)
        span_s, t_s = self._glimpses.span_s, frame.t_sensor_s
        events: list[DeviceEvent] = []
        for row, glimpse in enumerate(seen):
            clap = self._clap(row, t_s, glimpse)
            early, regular = self._motion[row].update(t_s, glimpse, span_s, self._claps[row].busy(t_s))
            if clap or early or regular:
                found = (clap, early, regular)
                events.extend(_device_event(frame, self._names[row], one) for one in found if one)
        return events

    def _clap(self, row: int, t_s: float, glimpse: Glimpse) -> Sighting | None:
        ratio = glimpse.hand_ratio if abs(glimpse.yaw_rad) <= FACING_RAD else math.nan
        met_s = self._claps[row].update(t_s, ratio, glimpse.hands == 2)
        return None if met_s is None else Sighting(Kind.CLAP, False, met_s)

    def _meet(self, persons: IntArray) -> None:
        names = persons.tolist()
        if self._persons is None or names != self._names:
            self._glimpses.reset()
            self._names = names
            self._claps = [ClapDetector(self._config, MEETING_S) for _ in names]
            self._motion = [MotionDetector(self._config, self._durations.setdefault(name, {})) for name in names]
        self._persons = persons


def _device_event(frame: SkeletonFrame, person: int, seen: Sighting) -> DeviceEvent:
    onset = None if seen.t_onset_s is None else frame.t_capture_device_s + seen.t_onset_s - frame.t_sensor_s
    return DeviceEvent(frame.sensor, person, seen.kind, frame.t_device_s, seen.early, onset)
