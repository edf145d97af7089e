"""Configuration files: round trips, and errors that name the field."""

import tomllib

import pytest

from sjasim.config import BodyConfig, FaultConfig, RobotConfig, SceneConfig, SessionConfig
from sjasim.config.toml_file import from_plain, read_toml, to_plain, to_toml
from sjasim.core.errors import ConfigError

RICH = SessionConfig(
    method="eca",
    seed=7,
    layout="custom",
    method_options={"epsilon_s": 1.25, "name": 'a "quoted" \u00e9\x7f', "count": 2, "on": True},
    faults=(FaultConfig("clock_jump", "west", 3.0, -0.4), FaultConfig("dancer_stops", "dancer_2", 9.5)),
    scene=SceneConfig(slots_m=((0.0, 1.0), (1.0, 0.0))),
    body=BodyConfig(stature_m=(1.6, 1.7)),
    robot=RobotConfig(gyro_noise_rad_s=1e-5),
)


@pytest.mark.parametrize("config", [SessionConfig(), RICH], ids=["default", "rich"])
def test_plain_and_toml_give_the_same_value_back(config, tmp_path):
    assert from_plain(to_plain(config)) == config
    path = tmp_path / "session.toml"
    path.write_text(to_toml(config), encoding="utf-8")
    assert read_toml(path) == config
    assert tomllib.loads(path.read_text(encoding="utf-8")) == to_plain(config)


def test_absent_fields_keep_the_base():
    config = from_plain({"robot": {"cruise_m_s": 0.3}}, base=RICH)
    assert config.robot == RobotConfig(gyro_noise_rad_s=1e-5, cruise_m_s=0.3)
    assert config.method == "eca"


def test_whole_numbers_are_numbers():
    config = from_plain({"dance": {"bpm": 120}})
    assert isinstance(config.dance.bpm, float)


@pytest.mark.parametrize(
    ("data", "field", "says"),
    [
        ({"methd": "sia"}, "methd", "did you mean 'method'"),
        ({"robot": {"criuse_m_s": 0.3}}, "robot.criuse_m_s", "cruise_m_s"),
        ({"robot": 3}, "robot", "a table"),
        ({"robot": {"cruise_m_s": "fast"}}, "robot.cruise_m_s", "a number"),
        ({"robot": {"cruise_m_s": -1.0}}, "robot.cruise_m_s", "0.15"),
        ({"seed": 1.5}, "seed", "a whole number"),
        ({"seed": True}, "seed", "a whole number"),
        ({"dance": {"rehearsal": "no"}}, "dance.rehearsal", "true or false"),
        ({"dance": {"lead_in_s": -4.0}}, "dance.lead_in_s", "1 to 60"),
        ({"body": {"mass_kg": [60.0]}}, "body.mass_kg", "a list of 2"),
        ({"body": {"mass_kg": [60.0, "x"]}}, "body.mass_kg[1]", "a number"),
        ({"faults": [{"target": "west"}]}, "faults[0].kind", "must be given"),
        ({"faults": {"kind": "x"}}, "faults", "a list"),
        ({"method_options": {"w": [1]}}, "method_options.w", "a number or a whole number"),
        ({"method_options": 1}, "method_options", "a table"),
    ],
)
def test_refusals_name_the_field(data, field, says):
    with pytest.raises(ConfigError) as caught:
        from_plain(data)
    assert caught.value.field == field
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


def test_unreadable_files_give_one_line(tmp_path):
    broken = tmp_path / "broken.toml"
    broken.write_text("method = ", encoding="utf-8")
    binary = tmp_path / "binary.toml"
    binary.write_bytes(b"\xff\xfe")
    for path in (tmp_path / "absent.toml", tmp_path, broken, binary):
        with pytest.raises(ConfigError) as caught:
            read_toml(path)
        assert str(path) in str(caught.value)
        assert "\n" not in str(caught.value)
