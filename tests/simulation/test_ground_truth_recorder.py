"""Ground truth, odometry and skeletons as table columns, from states with known values."""

from __future__ import annotations

import numpy as np
import pytest

from sjasim.assets.names import JOINT_INDEX
from sjasim.choreography.layout import Mount
from sjasim.core import Skeletons
from sjasim.core.bodies import DANCER_STATE_WIDTH, StateColumn
from sjasim.simulation.ground_truth_recorder import ODOMETRY_COLUMNS, TRUTH_COLUMNS, GroundTruthRecorder

WEIGHTS_N = np.array([700.0, 650.0])
TICKS = 10
RATE_HZ = 60
FALL_TICK = 6


def states() -> np.ndarray:
    """Two dancers: the first has the hands .3 m apart, the second is held by 3 N, 4 N and 3 Nm."""
    rows = np.zeros((2, DANCER_STATE_WIDTH))
    rows[:, StateColumn.ROOT : StateColumn.ROOT + 6] = np.arange(12.0).reshape(2, 6)
    rows[0, StateColumn.HANDS + 3] = 0.3
    rows[1, StateColumn.TETHER : StateColumn.TETHER + 5] = [3.0, 4.0, 1.0, 2.0, 2.0]
    rows[:, StateColumn.LOAD] = 0.5 * WEIGHTS_N
    return rows


@pytest.fixture
def recorder() -> GroundTruthRecorder:
    """Ten ticks; a frame with detection at tick 4 and one without at tick 8; the second dancer falls at tick 6."""
    recorder = GroundTruthRecorder(WEIGHTS_N, 1)
    order = np.array([1, 0])  # row 0 of the sensor is the second dancer
    visible = np.zeros((2, 25), dtype=bool)
    visible[0, JOINT_INDEX["SpineBase"]] = True
    for tick in range(TICKS):
        if tick == 4:
            recorder.add_frame(np.full((2, 25, 3), 1.5), visible, order)
        if tick == FALL_TICK:
            recorder.mark_fallen(tick / RATE_HZ, 1)
        if tick == 8:
            recorder.add_frame(np.zeros((2, 25, 3)), None, order)
        row = recorder.next_state_row(tick / RATE_HZ)
        recorder.states[row] = states()
    return recorder


def test_truth_has_one_row_for_each_tick_and_dancer(recorder):
    truth = recorder.truth()
    assert tuple(truth) == TRUTH_COLUMNS
    assert truth["t_s"].tolist() == np.repeat(np.arange(TICKS) / RATE_HZ, 2).tolist()
    assert truth["dancer"].tolist() == [0, 1] * TICKS
    second = truth["dancer"] == 1
    assert set(truth["x_m"][second]) == {6.0}
    assert set(truth["heading_rad"][second]) == {9.0}
    assert truth["hands_m"][:2].tolist() == [0.3, 0.0]
    assert (truth["tether_x_n"][1], truth["tether_y_n"][1], truth["tether_torque_nm"][1]) == (3.0, 4.0, 3.0)
    assert truth["load_n"][:2].tolist() == (0.5 * WEIGHTS_N).tolist()
    assert truth["fallen"][second].tolist() == [0] * FALL_TICK + [1] * (TICKS - FALL_TICK)


def test_visibility_belongs_to_the_right_dancer_and_is_nan_while_nothing_is_detected(recorder):
    share = recorder.truth()["spine_seen"].reshape(TICKS, 2)
    assert share[4:8].tolist() == [[0.0, 0.25]] * 4
    assert np.isnan(share[8:]).all()


def test_only_every_nth_state_is_recorded():
    recorder = GroundTruthRecorder(WEIGHTS_N, 3)
    rows = [recorder.next_state_row(tick / RATE_HZ) for tick in range(7)]
    assert rows == [0, -1, -1, 1, -1, -1, 2]
    assert len(recorder.states) >= 3  # the array has grown
    assert recorder.truth()["t_s"].tolist() == np.repeat([0.0, 3 / RATE_HZ, 6 / RATE_HZ], 2).tolist()


def test_odometry_and_joints_are_recorded_as_given(recorder):
    assert recorder.odometry() == {}
    values = [0.5, 1.0, 2.0, 3.0, 0.004, 0.1, 1.1, 2.1, 3.1]
    row = recorder.next_odometry_row()
    recorder.odometry_rows[row] = values
    columns = recorder.odometry()
    assert [float(columns[name][0]) for name in ODOMETRY_COLUMNS] == values
    assert recorder.joints().shape == (2, 2, 25, 3)
    assert recorder.joints()[0].max() == 1.5


def test_skeletons_are_in_the_world_and_belong_to_their_dancers():
    recorder = GroundTruthRecorder(WEIGHTS_N, 1)
    everybody = np.array([0, 1])
    recorder.add_frame(np.zeros((2, 25, 3)), None, everybody)

    # The second frame has a skeleton of the second dancer, and one of nobody.
    mount = Mount("north", np.array([0.0, 3.0, 0.9]), np.diag([-1.0, 1.0, -1.0]))
    skeletons = Skeletons(np.arange(2), np.ones((2, 25, 3)), np.full((2, 25), 2, dtype=np.int8))
    recorder.add_skeletons(skeletons, np.array([1, -1]), mount)
    recorder.add_frame(np.zeros((2, 25, 3)), None, everybody)

    out = recorder.skeletons()
    assert np.isnan(out[0]).all()
    assert np.isnan(out[1, 0]).all()
    assert out[1, 1, 7].tolist() == pytest.approx([-1.0, 4.0, -0.1, 2.0])
