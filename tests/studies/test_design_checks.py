"""Designs that are refused before their study starts."""

import re

import pytest

from sjasim.config import FaultConfig, SessionConfig
from sjasim.core.errors import SjasimError
from sjasim.studies.design_checks import checked_plan
from sjasim.studies.study_design import StudyDesign

TIMING = SessionConfig(fidelity="timing")


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"methods": ("sia", "siaa")}, "no method named 'siaa'"),
        ({"methods": ("sia", "sjasim.anticipation.sia:Sia")}, "both names mean the same"),
        ({"humans": ("paper",)}, "no humans preset named 'paper'"),
        ({"dances": ("tango",)}, "no dance named 'tango'"),
        ({"factors": {"dance.bpm": (118,)}}, "one level changes nothing"),
        ({"factors": {"dance.bpm": (100, 100.0)}}, "100 and 100.0 are equal"),
        ({"factors": {"dance.bmp": (100, 110)}}, "did you mean 'bpm'"),
        ({"factors": {"dance.bpm": (100, 1000)}}, "dance.bpm = 1000"),
        ({"factors": {"method_options.windw_s": (1, 2)}}, "an option of one of the methods"),
        ({"factors": {"method": ("eca", "sia")}}, "methods gives the values"),
        ({"factors": {"seed": (1, 2)}}, "seed gives the values"),
        ({"factors": {"humans": ("novices", "musicians")}, "humans": ("novices", "musicians")}, "given once"),
        ({"between": ("dance.bpm",)}, "dance.bpm is none"),
        ({"factors": {"dance.tail_s": (1.0, 2.0)}}, "its sessions are all equal"),
        ({"factors": {"robot.mass_kg": (6.0, 7.0)}}, "robot"),
        ({"factors": {"physics.rate_hz": (150, 300)}}, "physics"),
        ({"session": SessionConfig(fidelity="timing", method_options={"speed": 1})}, "method_options.speed = 1"),
        ({"factors": {"method_options.window_s": (1.0, -5.0)}}, "window_s"),
        (
            {"session": SessionConfig(fidelity="timing", faults=(FaultConfig("dancer_late", "dancer_9", 20.0, 1.0),))},
            "dancer_9",
        ),
        ({"factors": {"dancers": (3, 9)}}, "dancers = 9"),
    ],
)
def test_the_study_does_not_start(change, words):
    with pytest.raises(SjasimError, match=re.escape(words)) as caught:
        checked_plan(StudyDesign(**{"session": TIMING, **change}))
    assert "\n" not in str(caught.value)


def test_factors_with_an_effect_are_accepted():
    checked_plan(StudyDesign(factors={"synchrony.tau_s": (0.1, 0.25)}))
    factors = {"network.packet_loss": (0.0, 0.3), "method_options.window_s": (0.3, 1.5), "dancers": (3, 4)}
    plan = checked_plan(StudyDesign(factors=factors))
    assert len(plan.cells) == 2
    assert len(plan.without_robot) == 2
    assert len(plan.conditions) == 2 + 4
