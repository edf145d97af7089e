"""Former names of fields are read, each with one line that names the present one."""

from __future__ import annotations

import dataclasses

import pytest

from sjasim.config import SessionConfig
from sjasim.config.renamed_fields import RENAMED, RENAMED_SIA_OPTIONS, with_present_names
from sjasim.config.toml_file import from_plain, read_toml


def fields(config: SessionConfig) -> set[str]:
    """Dotted names of all fields of a configuration, tables included."""
    found = set()
    for field in dataclasses.fields(config):
        found.add(field.name)
        value = getattr(config, field.name)
        if dataclasses.is_dataclass(value):
            found |= {f"{field.name}.{inner.name}" for inner in dataclasses.fields(value)}
    return found


def test_every_present_name_exists_and_no_former_one_does():
    known = fields(SessionConfig())
    assert set(RENAMED.values()) <= known
    assert not set(RENAMED) & known


def test_a_file_with_former_names_gives_the_same_configuration_and_a_warning_for_each(tmp_path):
    path = tmp_path / "old.toml"
    path.write_text(
        'sensing = "joints"\ngroup = 5\n[room]\nside_m = 1.5\nmove_m = 0.4\n[network]\nloss = 0.1\n'
        "[sensors]\nbias_m = 0.02\nrate_hz = 25\n[method_options]\ntau_s = 0.5\neffective_from = 1\n"
    )
    with pytest.warns(FutureWarning) as caught:
        config = read_toml(path)

    assert (config.dancers, config.scene.side_m, config.dance.step_m) == (5, 1.5, 0.4)
    assert (config.network.packet_loss, config.joint_noise.bias_m, config.sensors.rate_hz) == (0.1, 0.02, 25)
    assert config.synchrony.tau_s == 0.5
    assert config.method_options == {"first_followed_iteration": 1}
    said = sorted(str(item.message).partition(" is now called ")[0] for item in caught)
    assert said == sorted(
        ["group", "room.side_m", "room.move_m", "network.loss", "sensors.bias_m", *RENAMED_SIA_OPTIONS]
    )


def test_the_present_name_wins_where_both_are_given():
    config = from_plain({"group": 5, "dancers": 2, "room": {"side_m": 1.6}, "scene": {"side_m": 1.5}})
    assert (config.dancers, config.scene.side_m) == (2, 1.5)


def test_options_of_other_methods_keep_their_names():
    data = {"method": "my:Own", "method_options": {"tau_s": 0.5}}
    assert with_present_names(data) == (data, {})
