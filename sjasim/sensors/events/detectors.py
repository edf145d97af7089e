"""Events from skeleton frames: five regular kinds and four early ones, for every person in front of a sensor.

Forward is towards the sensor. Nothing here knows the choreography. What the rules add to the bare thresholds:

* Motion counts only while the person faces the sensor, or turns their back to it, within `motion.FACING_RAD`; a clap
  only face to face. Someone who stands sideways gives no event, and a move during which a person turns away gets no
  stop. Seen from behind, too, forward is towards the sensor: who knows where people face has to exchange the kinds.
* After a reset, after facing the sensor anew, and after having been out of sight for `motion.LOST_S`, a person must
  first be seen standing; a motion already under way gives no event. Whoever comes back into sight still in the same
  move goes on with it; a stop or a start that happened out of sight is nobody's event, since its time is not known.
  While a person turns faster than `motion.TURNING_RAD_S` the times that arm the start events begin anew.
* Who comes or goes changes nothing for the others.
* A SpineBase that is inferred serves the regular events. Early events count tracked joints only, since errors of
  inferred ones exceed the floor. A clap needs both hands tracked until shortly before they meet, where they hide
  each other: a hand the sensor cannot see is worth some 10 cm of error, and a guessed clap is worse than a lost one.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ...config import DetectorConfig
from ...core import Array, DeviceEvent, IntArray, Kind, MoveDuration, SkeletonFrame
from .clap_detection import clapping, met_s, unseen_hands
from .frame_features import look, unseen
from .move_detection import EVENTS, FACING_RAD, NOTHING, judge, strangers
from .thresholds import BASE_HZ, Record, Records, rules

MEETING_S = 0.1
"""How long the hands may be inferred as they meet (assumed)."""

CLAP = 3
KINDS = {**EVENTS, CLAP: Kind.CLAP}
FOUND = np.dtype([("row", np.int64), ("event", np.int64), ("early", np.bool_), ("t_onset_s", np.float64)])
"""An event just detected: whose, its number in `KINDS`, and the sensor's time of its onset; NaN if it is early."""

_LASTED = {Kind.START_FORWARD: "forward_s", Kind.START_BACKWARD: "backward_s"}
_STARTED = {Kind.STOP_FORWARD: Kind.START_FORWARD, Kind.STOP_BACKWARD: Kind.START_BACKWARD}


@njit(cache=True)
def _judge(
    joints: Array, state: NDArray[np.int8], t_s: float, frame: int, limits: Records, times: Array, glimpses: Records,
    hands: Records, motions: Records, found: Records,
) -> int:  # fmt: skip
    """Judge one frame of everybody.

    Args:
        joints: (P, 25, 3) in the sensor's frame [m].
        state: (P, 25) tracking states.
        t_s: the sensor's time.
        frame: how many came before it.
        limits: (1,) `thresholds.RULES`.
        times: (F,) when the last frames were, this one's place at ``frame`` modulo F; changed.
        glimpses: (F, P) `glimpse.GLIMPSE` of them; changed.
        hands: (P,) `claps.HANDS`, changed.
        motions: (P,) `motion.PERSON`, changed.
        found: (3 P,) `FOUND`, output: for each person a clap, an early event, a regular one.

    Returns:
        how many events there are.
    """
    rule: Record = limits[0]
    ring, back = len(times), rule.difference_frames
    now, before, oldest = frame % ring, (frame - min(rule.step_frames, frame)) % ring, (frame - back) % ring
    times[now] = t_s
    floor_m = rule.early_displacement_m * BASE_HZ * (t_s - times[before])
    span_s = t_s - times[oldest] if frame >= back else 0.0
    count = 0
    for p in range(len(joints)):
        seen = glimpses[now, p]
        look(joints[p], state[p], glimpses[before, p], glimpses[oldest, p], floor_m, span_s, seen)
        ratio = seen.hand_ratio if abs(seen.yaw_rad) <= FACING_RAD else math.nan
        t_met_s = met_s(hands[p], t_s, ratio, seen.hands == 2, MEETING_S, rule)
        early, regular = judge(motions[p], t_s, seen, span_s, clapping(hands[p], t_s, rule), rule)
        if not math.isnan(t_met_s):
            count = _note(found, count, p, CLAP, False, t_met_s)
        if early != NOTHING:
            count = _note(found, count, p, early, True, math.nan)
        if regular != NOTHING:
            count = _note(found, count, p, regular, False, t_s - span_s / 2)
    return count


@njit(cache=True)
def _note(found: Records, count: int, row: int, event: int, early: bool, t_onset_s: float) -> int:
    one = found[count]
    one.row, one.event, one.early, one.t_onset_s = row, event, early, t_onset_s
    return count + 1


class EventDetector:
    """All persons' detectors of one client.

    Args:
        config: thresholds.
        rate_hz: nominal frame rate.
    """

    def __init__(self, config: DetectorConfig, rate_hz: float) -> None:
        self._rules = rules(config, rate_hz)
        self._lasted_s: dict[tuple[int, Kind], float] = {}
        self._persons: IntArray | None = None
        self._names: list[int] = []
        self._memory: tuple[Array, Records, Records, Records, Records]
        self._meet(np.zeros(0, dtype=np.int64))
        self.reset()

    def reset(self) -> None:
        """Begin anew: nobody has been seen standing yet. Logged durations of moves are kept."""
        self._persons = None

    def set_durations(self, durations: Iterable[MoveDuration]) -> None:
        """Take over durations of moves that other clients logged."""
        for known in durations:
            self._lasted_s[known.person, known.start] = known.duration_s
        self._recall()

    def update(self, frame: SkeletonFrame) -> list[DeviceEvent]:
        """Judge one frame; frames come in order of their time, some may be missing.

        Args:
            frame: all persons' skeletons. Those of somebody new begin anew, the others' go on.

        Returns:
            the events that it shows, in order of the persons, stamped with the time it had been processed.
        """
        persons, joints, state = frame.skeletons
        if persons is not self._persons:
            self._meet(persons)
        count = _judge(joints, state, frame.t_sensor_s, self._frames, self._rules, *self._memory)
        self._frames += 1
        return [self._event(frame, *found) for found in self._found[:count].tolist()] if count else []

    def _event(self, frame: SkeletonFrame, row: int, event: int, early: bool, t_onset_s: float) -> DeviceEvent:
        person, kind = self._names[row], KINDS[event]
        if kind in _STARTED and not early:
            start = _STARTED[kind]
            self._lasted_s[person, start] = float(self._motions[row][_LASTED[start]])
        onset_s = None if early else frame.t_capture_device_s + t_onset_s - frame.t_sensor_s
        return DeviceEvent(frame.sensor, person, kind, frame.t_device_s, early, onset_s)

    def _meet(self, persons: IntArray) -> None:
        """Begin anew with those who were not there before."""
        names = persons.tolist()
        if self._persons is None or names != self._names:
            ring, count = int(self._rules["difference_frames"][0]) + 1, len(names)
            before = [] if self._persons is None else self._names
            stay = [name for name in names if name in before]
            times, glimpses = np.zeros(ring), unseen(ring, count)
            hands, motions = unseen_hands(count), strangers(count)
            if stay:
                now, then = [names.index(name) for name in stay], [before.index(name) for name in stay]
                times = self._memory[0]
                glimpses[:, now] = self._memory[1][:, then]
                hands[now], motions[now] = self._memory[2][then], self._memory[3][then]
            else:
                self._frames = 0
            self._names, self._motions, self._found = names, motions, np.zeros(3 * count, dtype=FOUND)
            self._memory = (times, glimpses, hands, motions, self._found)
            self._recall()
        self._persons = persons

    def _recall(self) -> None:
        """Tell the rules how long everybody's last moves took."""
        for (person, start), lasted_s in self._lasted_s.items():
            if person in self._names:
                self._motions[_LASTED[start]][self._names.index(person)] = lasted_s
