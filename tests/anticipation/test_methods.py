"""ECA, the metronome and the event history, against scripted dances."""

import numpy as np
import pytest

from sjasim.anticipation.scheduled_method import LEAD_S
from sjasim.core.method_io import ScheduleCommand

AT = {"dancer_1": 0.2, "dancer_2": 0.3, "dancer_3": 0.4}


def test_eca_repeats_the_mean_of_the_iteration_before(story):
    played = story.Story("eca").play(0, AT)
    assert played.after(1) == pytest.approx(story.nominal + 0.3 - LEAD_S)
    assert all(isinstance(answer, ScheduleCommand) and answer.person == "" for answer in played.answers)
    played.play(1, {name: offset - 0.5 for name, offset in AT.items()})
    assert played.after(2) == pytest.approx(story.nominal - 0.2 - LEAD_S)


def test_eca_leaves_a_straggler_out_of_the_mean(story):
    played = story.Story("eca").play(0, {"dancer_1": 0.0, "dancer_2": 0.2, "dancer_3": 2.5})
    assert played.after(1) == pytest.approx(story.nominal + 0.1 - LEAD_S)


def test_eca_keeps_the_last_time_of_a_step_that_only_one_dancer_did(story):
    played = story.Story("eca").play(0, AT)
    alone = [(name, 4) for name in ("dancer_1", "dancer_2")]
    played.play(1, {name: offset + 0.4 for name, offset in AT.items()}, skip=alone)
    expected = story.nominal + 0.7 - LEAD_S
    expected[4] = story.nominal[4] + 0.3 - LEAD_S
    assert played.after(2) == pytest.approx(expected)
    assert "kept" in played.plan[2, 4].why


def test_a_missing_first_forward_does_not_make_the_second_one_first(story):
    played = story.Story("eca").play(0, AT, skip=[("dancer_2", 0), ("dancer_2", 1)])
    expected = story.nominal + 0.3 - LEAD_S
    assert played.after(1) == pytest.approx(expected)


@pytest.mark.parametrize("name", ["eca", "sia"])
def test_without_events_the_schedule_is_the_music_then_the_last_schedule(story, name):
    played = story.Story(name)
    played.begin(0)
    played.end(0)
    assert played.after(1) == pytest.approx(story.nominal - LEAD_S)
    eca = story.Story("eca").play(0, AT)
    eca.begin(1)
    eca.end(1)
    assert eca.after(2) == pytest.approx(story.nominal + 0.3 - LEAD_S)


@pytest.mark.parametrize("name", ["eca", "sia", "metronome"])
def test_without_a_rehearsal_the_first_iteration_is_scheduled_at_its_start(story, name):
    played = story.Story(name)
    played.begin(1)
    assert played.after(1) == pytest.approx(story.nominal - LEAD_S)


def test_a_dancer_alone_is_enough_for_a_group_of_one(story):
    played = story.Story("eca", cast=("dancer_1",)).play(0, {"dancer_1": 0.5})
    assert played.after(1) == pytest.approx(story.nominal + 0.5 - LEAD_S)


def test_early_events_and_events_of_unknown_persons_are_not_kept(story):
    played = story.Story("eca")
    for person in (*AT, "stranger"):
        for step in range(9):
            kind = story.context().steps[step].kind
            played.tell(story.event(person, 0, kind, story.nominal[step] + 9.0, early=person != "stranger"))
    played.end(0)
    assert played.after(1) == pytest.approx(story.nominal - LEAD_S)


def test_the_metronome_ignores_events(story):
    played = story.Story("metronome", lead_s=0.3)
    for iteration in range(4):
        played.play(iteration, {"dancer_1": 1.0, "dancer_2": -1.0})
    for iteration in range(1, 5):
        assert played.after(iteration) == pytest.approx(story.nominal - 0.3)
    assert len(played.answers) == 36


def test_nothing_is_scheduled_after_the_last_iteration(story):
    for name in ("eca", "sia", "metronome"):
        played = story.Story(name).play(4, AT)
        assert not any(iteration > 4 for iteration, _ in played.plan)


def test_a_shift_of_the_whole_group_moves_the_schedule_by_as_much(story):
    rng = np.random.default_rng(5)
    offsets = {name: rng.normal(0, 0.2, 9) for name in AT}
    base = story.Story("eca").play(0, offsets).after(1)
    later = story.Story("eca").play(0, {name: offset + 0.6 for name, offset in offsets.items()}).after(1)
    assert later - base == pytest.approx(np.full(9, 0.6))
