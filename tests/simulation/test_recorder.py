"""Truth and odometry as columns; states by formula."""

import numpy as np
import pytest

from sjasim.assets.names import JOINT_INDEX
from sjasim.choreography.layout import Mount
from sjasim.core import Skeletons
from sjasim.simulation.recorder import ODOMETRY_COLUMNS, TRUTH_COLUMNS, GroundTruthRecorder

WEIGHTS = np.array([700.0, 650.0])


def states():
    """Two dancers: the first one's hands .3 m apart, the second pulled by 3 N and 4 N, half the weight on the floor."""
    rows = np.zeros((2, 36))
    rows[:, 6:12] = np.arange(12.0).reshape(2, 6)
    rows[0, 27] = 0.3
    rows[1, 30:35] = [3.0, 4.0, 1.0, 2.0, 2.0]
    rows[:, 35] = 0.5 * WEIGHTS
    return rows


@pytest.fixture
def recorder():
    recorder = GroundTruthRecorder(WEIGHTS, 1)
    seen = np.zeros((2, 25), dtype=bool)
    seen[0, JOINT_INDEX["SpineBase"]] = True  # row 0 is the second dancer
    for tick in range(10):
        if tick == 4:
            recorder.add_frame(np.full((2, 25, 3), 1.5), seen, np.array([1, 0]))
        if tick == 6:
            recorder.mark_fallen(tick / 60, 1)
        if tick == 8:
            recorder.add_frame(np.zeros((2, 25, 3)), None, np.array([1, 0]))
        row = recorder.next_state_row(tick / 60)
        recorder.states[row] = states()
    return recorder


def test_truth_has_one_row_per_tick_and_dancer(recorder):
    truth = recorder.truth()
    assert tuple(truth) == TRUTH_COLUMNS
    assert truth["t_s"].tolist() == np.repeat(np.arange(10) / 60, 2).tolist()
    assert truth["dancer"].tolist() == [0, 1] * 10
    second = truth["dancer"] == 1
    assert set(truth["x_m"][second]) == {6.0}
    assert set(truth["heading_rad"][second]) == {9.0}
    assert truth["hands_m"][:2].tolist() == [0.3, 0.0]
    assert (truth["tether_x_n"][1], truth["tether_y_n"][1], truth["tether_torque_nm"][1]) == (3.0, 4.0, 3.0)
    assert truth["load_n"][:2].tolist() == (0.5 * WEIGHTS).tolist()
    assert truth["fallen"][second].tolist() == [0] * 6 + [1] * 4


def test_what_was_seen_belongs_to_the_right_dancer_and_is_nan_while_nobody_watched(recorder):
    share = recorder.truth()["spine_seen"].reshape(10, 2)
    assert share[4:8].tolist() == [[0.0, 0.25]] * 4
    assert np.isnan(share[8:]).all()


def test_odometry_and_joints_are_kept_as_given(recorder):
    assert recorder.odometry() == {}
    row = recorder.next_odometry_row()
    recorder.odometry_rows[row] = 0.5, 1.0, 2.0, 3.0, 0.004, 0.1, 1.1, 2.1, 3.1
    columns = recorder.odometry()
    assert [float(columns[name][0]) for name in ODOMETRY_COLUMNS] == [0.5, 1.0, 2.0, 3.0, 0.004, 0.1, 1.1, 2.1, 3.1]
    assert recorder.joints().shape == (2, 2, 25, 3)
    assert recorder.joints()[0].max() == 1.5


def test_estimates_are_in_the_world_and_belong_to_the_dancers_behind_them():
    recorder = GroundTruthRecorder(WEIGHTS, 1)
    mount = Mount("north", np.array([0.0, 3.0, 0.9]), np.diag([-1.0, 1.0, -1.0]))
    local, state = np.ones((2, 25, 3)), np.full((2, 25), 2, dtype=np.int8)
    recorder.add_frame(np.zeros((2, 25, 3)), None, np.array([0, 1]))
    recorder.add_skeletons(Skeletons(np.arange(2), local, state), np.array([1, -1]), mount)
    recorder.add_frame(np.zeros((2, 25, 3)), None, np.array([0, 1]))
    out = recorder.skeletons()
    assert np.isnan(out[0]).all()
    assert np.isnan(out[1, 0]).all()
    assert out[1, 1, 7].tolist() == pytest.approx([-1.0, 4.0, -0.1, 2.0])
