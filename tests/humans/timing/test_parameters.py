"""Tests of the timing parameters: allowed values, gain matrices, presets and files."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sjasim.core.errors import ConfigError, UnknownNameError
from sjasim.humans.timing.parameters import (
    TimingParameters,
    parameters_at_expertise,
    preset,
    preset_names,
    read_parameters,
)

LEADER = ((0.0, 0.1, 0.1), (0.6, 0.0, 0.2), (0.6, 0.2, 0.0))


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("timekeeper_s", -0.1),
        ("motor_s", float("nan")),
        ("common_s", 6.0),
        ("common_correlation", 1.0),
        ("coupling", -0.01),
        ("coupling", 1.1),
        ("period_correction", -0.1),
        ("practice", 1.0),
        ("practice", (0.1, 2.0)),
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


@pytest.mark.parametrize(
    ("dancers", "values", "says"),
    [
        (3, {"coupling": 0.7}, r"humans.coupling.*die out: at most a gain of 0\.667 for 3 dancers"),
        (8, {"coupling": 0.3}, r"humans.coupling.*at most a gain of 0\.25 for 8 dancers"),
        (2, {"coupling": 0.9, "music_coupling": 0.4}, r"humans.coupling.*at most a gain of 0\.8 for 2 dancers"),
        (3, {"coupling": 0.6, "robot_coupling": 1.0}, r"humans.robot_coupling.*at most a gain of 0\.2 for 3 dancers"),
        (2, {"coupling": 0.8, "period_correction": 0.9}, r"period_correction.*at most a gain of 0\.4 for 2 dancers"),
    ],
)
def test_gains_under_which_asynchronies_grow_are_refused_with_the_largest_allowed_gain(dancers, values, says):
    with pytest.raises(ConfigError, match=says):
        TimingParameters(**values).transition_matrix(dancers)


def test_a_matrix_under_which_asynchronies_grow_is_refused_with_the_largest_allowed_factor():
    with pytest.raises(ConfigError, match=r"humans.coupling.*die out: at most 0\.833 times these gains"):
        TimingParameters(coupling=((0.0, 0.8, 0.8), (0.8, 0.0, 0.8), (0.8, 0.8, 0.0)))
    with pytest.raises(ConfigError, match=r"humans.coupling.*at most 0 times"):
        TimingParameters(coupling=((0.0, -0.1), (-0.1, 0.0)))


@pytest.mark.parametrize("dancers", range(2, 9))
def test_one_number_is_a_gain_per_partner_whatever_the_groups_size(dancers):
    p = TimingParameters(coupling=0.2)
    assert np.array_equal(p.coupling_gains(dancers), 0.2 * (1 - np.eye(dancers)))
    matrix = p.transition_matrix(dancers)
    assert matrix.sum(axis=1) == pytest.approx(1.0)
    eigenvalues = np.sort(np.linalg.eigvals(matrix).real)
    assert eigenvalues[:-1] == pytest.approx(1 - 0.2 * dancers)


def test_expertise_lies_between_novices_and_musicians():
    novices, half, musicians = (parameters_at_expertise(value) for value in (0.0, 0.5, 1.0))
    assert replace(novices, about="") == replace(preset("novices"), about="")
    assert replace(musicians, about="") == replace(preset("musicians"), about="")
    assert half.timekeeper_s == pytest.approx(np.sqrt(novices.timekeeper_s * musicians.timekeeper_s))
    assert half.coupling == pytest.approx((novices.coupling + musicians.coupling) / 2)
    with pytest.raises(ConfigError, match=r"humans.expertise = 1\.5 .*0 \(novices\) to 1 \(musicians\)"):
        parameters_at_expertise(1.5)


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
