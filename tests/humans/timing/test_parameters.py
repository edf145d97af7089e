"""Tests of the timing parameters: allowed values, gain matrices, presets and files."""

from __future__ import annotations

import numpy as np
import pytest

from sjasim.core.errors import ConfigError, UnknownNameError
from sjasim.humans.timing.parameters import TimingParameters, preset, preset_names, read_parameters

LEADER = ((0.0, 0.1, 0.1), (0.6, 0.0, 0.2), (0.6, 0.2, 0.0))


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("timekeeper_s", -0.1),
        ("motor_s", float("nan")),
        ("common_s", 6.0),
        ("common_correlation", 1.0),
        ("coupling", -0.01),
        ("coupling", 0.7),
        ("coupling", ((0.0, 2.0), (0.1, 0.0))),
        ("coupling", ((0.0, "much"), (0.1, 0.0))),
        ("robot_coupling", 1.5),
        ("robot_coupling", (0.1, -0.2)),
        ("music_coupling", -0.1),
        ("anticipation", 1.2),
        ("dancer_spread", -1.0),
        ("scale", (1.0, -0.5)),
        ("lapse", 1.5),
        ("lapse", "often"),
        ("late_s", (9.0,)),
        ("drift", (0.5,)),
    ],
)
def test_values_outside_their_range_are_refused(field, value):
    with pytest.raises(ConfigError, match=r"number from .* to") as caught:
        TimingParameters(**{field: value})
    assert caught.value.field == f"humans.{field}"


@pytest.mark.parametrize("matrix", [((0.0, 0.1), (0.1,)), ((0.0, 0.1, 0.1), (0.1, 0.0, 0.1))])
def test_a_coupling_matrix_has_as_many_rows_as_columns(matrix):
    with pytest.raises(ConfigError, match=r"humans.coupling.*as many rows as columns"):
        TimingParameters(coupling=matrix)


def test_a_coupling_matrix_fits_one_number_of_dancers():
    with pytest.raises(ConfigError, match=r"humans.coupling.*4 rows of 4"):
        TimingParameters(coupling=LEADER).coupling_gains(4)


def test_gains_under_which_asynchronies_grow_are_refused():
    with pytest.raises(ConfigError, match=r"humans.coupling.*differences die out.*1\.4"):
        TimingParameters(coupling=((0.0, 0.8, 0.8), (0.8, 0.0, 0.8), (0.8, 0.8, 0.0)))
    with pytest.raises(ConfigError, match=r"humans.robot_coupling.*die out"):
        TimingParameters(coupling=0.6, robot_coupling=1.0).transition_matrix(3)


@pytest.mark.parametrize("dancers", range(2, 9))
def test_one_number_corrects_as_much_in_groups_of_every_size(dancers):
    matrix = TimingParameters(coupling=0.3).transition_matrix(dancers)
    assert matrix.sum(axis=1) == pytest.approx(1.0)
    eigenvalues = np.sort(np.linalg.eigvals(matrix).real)
    assert eigenvalues[:-1] == pytest.approx(1 - 0.9)


def test_a_row_of_the_matrix_corrects_towards_its_columns():
    p = TimingParameters(coupling=LEADER)
    assert np.array_equal(p.coupling_gains(3), LEADER)
    lead = p.transition_matrix(3) @ np.array([0.1, 0.0, 0.0])
    assert lead == pytest.approx([0.1 * 0.8, 0.06, 0.06])


def test_correction_scales_a_dancers_own_gains():
    gains = TimingParameters(coupling=0.3, correction=(0.2,)).coupling_gains(3)
    assert gains[0, 1:] == pytest.approx(0.06)
    assert gains[1:, 0] == pytest.approx(0.3)


def test_dancers_beyond_a_list_have_the_neutral_value():
    p = TimingParameters(late_s=(0.5,), scale=(2.0, 3.0, 4.0))
    assert list(p.per_dancer("late_s", 3, 0.0)) == [0.5, 0.0, 0.0]
    assert list(p.per_dancer("scale", 2, 1.0)) == [2.0, 3.0]


def test_an_unknown_preset_lists_the_known_ones():
    with pytest.raises(UnknownNameError, match="paper-entrainment"):
        preset("nobody")


def test_every_preset_names_its_source():
    assert len(preset_names()) >= 8
    assert all(preset(name).about for name in preset_names())


def test_parameters_are_read_from_a_file(tmp_path):
    path = tmp_path / "ours.toml"
    path.write_text("timekeeper_s = 0.03\ncoupling = [[0.0, 0.2], [0.3, 0]]\nlate_s = [0.1]\n")
    assert read_parameters(path) == TimingParameters(timekeeper_s=0.03, coupling=((0.0, 0.2), (0.3, 0)), late_s=(0.1,))


@pytest.mark.parametrize(
    ("text", "says"),
    [("timekeper_s = 1", "timekeper_s.*no such field"), ("motor_s = [", "a TOML file"), ("motor_s = -1", "motor_s")],
)
def test_a_wrong_file_is_refused(tmp_path, text, says):
    path = tmp_path / "wrong.toml"
    path.write_text(text)
    with pytest.raises(ConfigError, match=says):
        read_parameters(path)
    with pytest.raises(ConfigError, match="readable"):
        read_parameters(tmp_path / "absent.toml")
