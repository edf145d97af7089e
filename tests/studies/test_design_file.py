"""Designs as TOML files and as words of a command line."""

from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sjasim.config import DanceConfig, SessionConfig
from sjasim.core.errors import ConfigError
from sjasim.studies.design_file import (
    design_from_toml,
    design_to_plain,
    design_to_toml,
    factors_from_words,
    read_design,
)
from sjasim.studies.study_design import StudyDesign

EXAMPLE = """
groups = 12
methods = ["sia", "metronome"]
missing = "drop-step"

[session]
dancers = 4
dance.bpm = 100

[factors]
network.packet_loss = [0, 0.1]
"method_options.window_s" = [1.0, 1.5]
"""

LEVELS = st.lists(st.one_of(st.integers(-5, 5), st.floats(-1, 1), st.booleans(), st.text("ab-", max_size=3)))


def test_a_file_gives_the_fields_that_it_names(tmp_path):
    (tmp_path / "design.toml").write_text(EXAMPLE, encoding="utf-8")
    design = read_design(tmp_path / "design.toml")
    assert design == StudyDesign(
        groups=12,
        methods=("sia", "metronome"),
        missing="drop-step",
        session=SessionConfig(fidelity="timing", dancers=4, dance=DanceConfig(bpm=100.0)),
        factors={"network.packet_loss": (0, 0.1), "method_options.window_s": (1.0, 1.5)},
    )


@settings(max_examples=50)
@given(
    groups=st.integers(2, 10**6),
    events=st.booleans(),
    bpm=st.floats(40, 220),
    factors=st.dictionaries(st.sampled_from(("dance.bpm", "robot.mass_kg", "sensing")), LEVELS.map(tuple)),
)
def test_a_design_survives_its_file(groups, events, bpm, factors):
    session = SessionConfig(fidelity="timing", dance=DanceConfig(bpm=bpm))
    design = StudyDesign(groups=groups, events=events, session=session, factors=factors)
    text = design_to_toml(design)
    assert design_to_plain(design_from_toml(text)) == design_to_plain(design)
    assert design_to_toml(design_from_toml(text)) == text


def test_levels_that_are_lists_survive_their_file():
    design = StudyDesign(factors={"dance.pauses": ([], [[8.0, 2.0]])})
    assert design_to_toml(design_from_toml(design_to_toml(design))) == design_to_toml(design)


def test_words_give_factors():
    words = [
        "dance.bpm=100,118.5",
        "network.packet_loss=0,.2",
        "sensing=joints,depth",
        "method-options.flag=true,false",
        "dance.pauses=[],[[8,2]]",
    ]
    assert factors_from_words(words) == {
        "dance.bpm": (100, 118.5),
        "network.packet_loss": (0, 0.2),
        "sensing": ("joints", "depth"),
        "method_options.flag": (True, False),
        "dance.pauses": ([], [[8, 2]]),
    }


@pytest.mark.parametrize(
    ("text", "field"),
    [
        ("grups = 3", "design.grups"),
        ('groups = "nine"', "groups"),
        ("session = 3", "session"),
        ("[session]\ndancrs = 3", "dancrs"),
        ('[session]\nmethod = "eca"', "session.method"),
        ("[factors]\ndance.bpm = 100", "factors.dance.bpm"),
        ("groups =", "design"),
    ],
)
def test_a_wrong_file_is_refused_by_field(tmp_path, text, field):
    (tmp_path / "design.toml").write_text(text, encoding="utf-8")
    with pytest.raises(ConfigError) as caught:
        read_design(tmp_path / "design.toml")
    assert field in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_word_without_levels_is_refused():
    with pytest.raises(ConfigError, match="NAME=LEVEL"):
        factors_from_words(["dance.bpm"])


def test_a_file_that_does_not_exist_is_named(tmp_path):
    with pytest.raises(ConfigError, match=r"nowhere\.toml"):
        read_design(tmp_path / "nowhere.toml", replace(StudyDesign(), groups=3))
