"""Faults in the dancers' cues, and the timing error that the dancers perceive."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from sjasim.choreography.timetable import timetable
from sjasim.config import FaultConfig, SessionConfig
from sjasim.core import ROBOT, Cue, Kind, Move
from sjasim.core.errors import ConfigError, SjasimError
from sjasim.core.session_log import AgentEvent
from sjasim.humans.timing.parameters import TimingParameters, read_parameters
from sjasim.session.dancers import cues_with_faults, make_human_timing, perceived_timing_error_s


def test_perceived_error_is_the_distance_from_the_dancers_mean_time():
    cues = [Cue(f"dancer_{k}", Move.FORWARD, 1, 0, 0.0, 10.0 + 0.2 * k, 2.0) for k in range(3)]
    clap = Cue("dancer_1", Move.CLAP, 1, 8, 32.0, 26.0, 0.0)
    robot = [AgentEvent(1, ROBOT, Kind.START_FORWARD, 10.5), AgentEvent(1, ROBOT, Kind.TURN, 26.5)]
    assert perceived_timing_error_s([*cues, clap], robot) == pytest.approx((0.3 + 0.5) / 2)


def test_perceived_error_is_none_without_dancers_or_robot():
    clap = Cue("dancer_1", Move.CLAP, 1, 8, 32.0, 26.0, 0.0)
    turn = AgentEvent(1, ROBOT, Kind.TURN, 26.5)
    assert perceived_timing_error_s([clap], []) is None
    assert perceived_timing_error_s([], [turn]) is None


def test_faults_delay_or_remove_the_cues_of_their_target_from_their_time_on():
    cues = tuple(
        Cue(dancer, Move.FORWARD, 1, 0, 0.0, t_s, 2.0) for dancer in ("dancer_1", "dancer_2") for t_s in (4.0, 8.0)
    )
    late = cues_with_faults(cues, [FaultConfig("dancer_late", "dancer_1", 5.0, 0.5)])
    assert [cue.t_s for cue in late] == [4.0, 8.5, 4.0, 8.0]
    stopped = cues_with_faults(cues, [FaultConfig("dancer_stops", "dancer_2", 8.0)])
    assert [(cue.dancer, cue.t_s) for cue in stopped] == [("dancer_1", 4.0), ("dancer_1", 8.0), ("dancer_2", 4.0)]


def test_people_of_an_expertise_dance():
    config = SessionConfig(humans="expertise:0.5")
    model = make_human_timing(config, timetable(config))
    model.begin(1, None, np.zeros(3))
    assert sum(len(own) for own in model.decide(0.0, ())) >= 12
    for wrong in ("expertise:", "expertise:much", "expertise:2"):
        with pytest.raises(ConfigError, match=r"humans.*0.* to 1"):
            make_human_timing(replace(config, humans=wrong), timetable(config))


def planned(humans: str, **options) -> list[float]:
    """Begins of all moves of iteration 1 [s]."""
    config = SessionConfig(humans=humans, **options)
    model = make_human_timing(config, timetable(config))
    model.begin(1, None, np.zeros(3))
    return [cue.t_s for own in model.decide(0.0, ()) for cue in own]


@pytest.mark.parametrize("humans", ["adam", "ashle"])
def test_further_models_dance_by_name_with_the_same_persons_under_every_method(humans):
    one = planned(humans, method="eca", performance="monday")
    assert one == planned(humans, method="sia", performance="monday")
    assert one != planned(humans, method="sia", performance="tuesday")
    assert one != planned(humans, method="eca", performance="monday", seed=1)


def test_a_file_chooses_its_model(tmp_path):
    def written(text: str) -> str:
        path = tmp_path / "people.toml"
        path.write_text(text)
        return str(path)

    quiet = planned(written('model = "adam"\ntimekeeper_s = 0.0\nmotor_s = 0.0\nlapse = 0.0\n'))
    assert quiet == pytest.approx(planned("metronomic"))
    assert quiet == pytest.approx(planned(written("lapse = 0.0\n")))
    noisy = planned(written('model = "adam"\nlapse = 0.0\n'))
    assert noisy != pytest.approx(quiet, abs=0.01)

    ensemble = Path(written('model = "ensemble"\ncoupling = 0.2\n'))
    planned(str(ensemble))
    assert read_parameters(ensemble) == TimingParameters(coupling=0.2)
    assert read_parameters(Path(written('model = "adam"\n'))) is None
    planned(written('model = "ashle"\nspontaneous_s = 0.5\n[oscillators]\nnoise = 0.1\n'))

    for text, says in (
        ('model = "adam"\ncoupling = 0.2\n', "coupling.*no such field"),
        ('model = "ashle"\n[oscillators]\nnoise = "loud"\n', "oscillators.noise.*a number"),
        ("model = 3\n", "no humans named '3'"),
        ('model = "eve"\n', "no humans named 'eve': known are adam, ashle"),
    ):
        with pytest.raises(SjasimError, match=says):
            planned(written(text))


def test_an_unknown_name_lists_presets_and_models():
    with pytest.raises(SjasimError, match=r"'nobody': known are metronomic, .*adam, ashle"):
        planned("nobody")
