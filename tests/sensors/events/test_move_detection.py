"""Starts and stops from the features of one person."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sjasim.config import DetectorConfig
from sjasim.core import Kind
from sjasim.sensors.events.frame_features import FRAME_FEATURES
from sjasim.sensors.events.move_detection import FORWARD, KIND_OF_CODE, detect_motion, initial_motion_states
from sjasim.sensors.events.thresholds import REFERENCE_RATE_HZ, threshold_row

THRESHOLDS = threshold_row(DetectorConfig(), REFERENCE_RATE_HZ).view(np.recarray)[0]


def one_row(rows: np.ndarray) -> np.recarray:
    """The only row, whose columns are attributes in Python as well."""
    return rows.view(np.recarray)[0]


def events(speeds_m_s: list[float]) -> list[Kind]:
    """Regular events of a person who faces the sensor, one speed per frame."""
    person = one_row(initial_motion_states(1))
    features = one_row(np.zeros(1, dtype=FRAME_FEATURES))
    found = []
    for tick, speed_m_s in enumerate(speeds_m_s):
        features.approach_speed_m_s = speed_m_s
        _, code = detect_motion(person, tick / REFERENCE_RATE_HZ, features, False, THRESHOLDS)
        found += [KIND_OF_CODE[code]] if code else []
    return found


@pytest.mark.parametrize(
    ("blind_s", "expected"),
    [
        ((1.2, 1.3), "start_forward stop_forward start_backward stop_backward"),
        ((1.2, 2.2), "start_forward stop_forward start_backward stop_backward"),
        ((2.4, 3.5), "start_forward start_backward stop_backward"),
        ((3.5, 4.5), "start_forward stop_forward"),
        ((2.4, 4.5), "start_forward"),
    ],
)
def test_events_out_of_sight_are_not_reported_and_a_move_that_lasts_continues(blind_s, expected):
    """Forward from 1 to 3 s, backward from 4 to 6 s, out of sight in between."""
    times_s = np.arange(240) / REFERENCE_RATE_HZ
    speeds_m_s = 0.25 * ((times_s >= 1.0) & (times_s < 3.0)) - 0.25 * ((times_s >= 4.0) & (times_s < 6.0))
    speeds_m_s[(times_s >= blind_s[0]) & (times_s < blind_s[1])] = math.nan
    assert " ".join(kind.value for kind in events(speeds_m_s.tolist())) == expected


@pytest.mark.parametrize(("speed_m_s", "count"), [(0.19, 0), (0.21, 2)])
def test_a_move_starts_above_the_start_speed(speed_m_s: float, count: int):
    assert len(events([0.0] * 30 + [speed_m_s] * 60 + [0.0] * 30)) == count


def early_stop_frame(tracked: int, moving: int) -> int | None:
    """Frame of the early stop of a move forward with so many upper joints tracked and moving; None without one."""
    person = one_row(initial_motion_states(1))
    person.phase = FORWARD
    person.t_phase_s = 0.0
    person.t_speed_s = 0.0
    person.forward_s = 1.0

    features = one_row(np.zeros(1, dtype=FRAME_FEATURES))
    features.approach_speed_m_s = 0.3
    features.joints_tracked = tracked
    features.joints_approaching = moving
    for frame in range(60):
        early, _ = detect_motion(person, frame / REFERENCE_RATE_HZ, features, False, THRESHOLDS)
        if early:
            assert KIND_OF_CODE[early] is Kind.STOP_FORWARD
            return frame
    return None


@pytest.mark.parametrize(
    ("tracked", "moving", "frame"),
    # Armed after 0.7 of the last move of 1 s, which is frame 21; two frames are needed.
    [(4, 0, 22), (4, 1, 22), (4, 2, None), (4, 4, None), (3, 0, 22), (3, 1, None), (2, 0, None)],
)
def test_an_early_stop_needs_three_of_the_four_upper_joints_tracked_and_still(tracked, moving, frame):
    assert early_stop_frame(tracked, moving) == frame


@pytest.mark.parametrize(("moving", "frame"), [(1, None), (2, 31), (4, 31)])
def test_an_early_start_needs_two_of_the_upper_joints_in_two_frames(moving, frame):
    person = one_row(initial_motion_states(1))
    features = one_row(np.zeros(1, dtype=FRAME_FEATURES))
    features.joints_tracked = 4
    found = []
    for tick in range(40):
        features.joints_approaching = moving if tick >= 30 else 0
        early, _ = detect_motion(person, tick / REFERENCE_RATE_HZ, features, False, THRESHOLDS)
        found += [(tick, KIND_OF_CODE[early])] if early else []
    assert found == ([] if frame is None else [(frame, Kind.START_FORWARD)])
