"""Configuration values are checked when they are made."""

import dataclasses

import pytest

from sjasim import config
from sjasim.config import FAULTS, BodyConfig, FaultConfig, PhysicsConfig, SessionConfig
from sjasim.core.errors import ConfigError

ROOMS = [field.name for field in dataclasses.fields(SessionConfig) if dataclasses.is_dataclass(field.default)]


def test_configurations_are_values():
    assert SessionConfig() == SessionConfig()
    with pytest.raises(dataclasses.FrozenInstanceError):
        SessionConfig().seed = 3


@pytest.mark.parametrize("room", ROOMS)
def test_every_number_has_limits_and_its_refusal_names_it(room):
    default = getattr(SessionConfig(), room)
    numbers = [
        field.name
        for field in dataclasses.fields(default)
        if isinstance(getattr(default, field.name), int | float) and not isinstance(getattr(default, field.name), bool)
    ]
    for name in numbers:
        for wrong in (-1e9, float("nan"), "fast", True):
            with pytest.raises(ConfigError) as caught:
                dataclasses.replace(default, **{name: wrong})
            assert caught.value.field == f"{room}.{name}"


@pytest.mark.parametrize(
    ("changes", "field"),
    [
        ({"iterations": 0}, "iterations"),
        ({"seed": -1}, "seed"),
        ({"seed": 1.5}, "seed"),
        ({"dancers": 9}, "dancers"),
        ({"fidelity": "exact"}, "fidelity"),
        ({"layout": "circle"}, "layout"),
    ],
)
def test_a_session_refuses_values_out_of_range(changes, field):
    with pytest.raises(ConfigError) as caught:
        SessionConfig(**changes)
    assert caught.value.field == field


def test_ranges_rise():
    with pytest.raises(ConfigError, match="rising"):
        config.BodyConfig(stature_m=(1.8, 1.6))


def test_faults_are_of_known_kinds_and_sizes():
    assert all(FaultConfig(kind, "x").kind == kind for kind in FAULTS)
    with pytest.raises(ConfigError, match="dead_sensor"):
        FaultConfig("meteor", "north")
    with pytest.raises(ConfigError, match="t_s"):
        FaultConfig("dead_sensor", "north", -1.0)
    with pytest.raises(ConfigError, match="value"):
        FaultConfig("clock_jump", "north", 0.0, 100.0)


def test_without_balance_support_control_is_fast_unless_rates_are_given():
    free = BodyConfig(balance_support="none")
    assert SessionConfig(body=free).physics.control_hz == 240
    assert SessionConfig(body=free, physics=PhysicsConfig(rate_hz=300, control_hz=100)).physics.control_hz == 100
    assert SessionConfig().physics.control_hz == 50
    logged = SessionConfig(body=free, physics=PhysicsConfig(ground_truth_hz=25)).physics
    assert logged == PhysicsConfig(rate_hz=240, control_hz=240, ground_truth_hz=25)


def test_depth_sensing_tracks_six_dancers_at_most():
    assert SessionConfig(dancers=6).dancers == 6
    assert SessionConfig(dancers=8, sensing="joints").dancers == 8
    with pytest.raises(ConfigError, match="dancers = 7 is not allowed: at most 6 with depth sensing"):
        SessionConfig(dancers=7)
