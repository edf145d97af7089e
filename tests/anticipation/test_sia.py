"""SIA against scripted streams of events."""

import numpy as np
import pytest

from sjasim.anticipation.method import build_method
from sjasim.anticipation.scheduled_method import LEAD_S
from sjasim.anticipation.sia import MIN_PAUSE_S
from sjasim.choreography.march import march
from sjasim.core import Event, Kind
from sjasim.core.method_io import CancelCommand, MethodContext, ScheduleCommand, SetTimer

TOGETHER = {"dancer_1": 0.0, "dancer_2": 0.05, "dancer_3": 0.6}
SF, TF, SB, TB, CLAP, TURN = Kind


@pytest.fixture
def following(story):
    """A story at the beginning of iteration 2, in which dancer_1 is followed."""
    played = story.Story("sia").play(0, TOGETHER).play(1, TOGETHER)
    played.begin(2)
    assert played.method.follows(2) == ("dancer_1",)
    return played


def sent(answers):
    """(ordinal, person) of the commands among a hook's actions."""
    return [(a.ordinal, a.person) for a in answers if isinstance(a, ScheduleCommand)]


def test_iteration_one_is_scheduled_from_the_rehearsal(story):
    played = story.Story("sia").play(0, TOGETHER)
    eca = story.Story("eca").play(0, TOGETHER)
    assert played.after(1) == pytest.approx(eca.after(1))
    assert played.method.follows(1) == ()
    before = len(played.answers)
    played.play(1, TOGETHER)
    assert all(answer.iteration == 2 for answer in played.answers[before:])


@pytest.mark.parametrize(("tau_s", "leader"), [(0.25, "dancer_1"), (1.0, "dancer_2")])
def test_the_leader_is_the_most_synchronous_dancer_by_the_contexts_tau(story, tau_s, leader):
    """Dancers 1 and 2 coincide within .25 s and are tied; within 1 s dancer 2 coincides with dancer 3 as well."""
    offsets = {"dancer_1": 0.0, "dancer_2": 0.2, "dancer_3": 1.1}
    played = story.Story("sia", tau_s=tau_s).play(0, offsets).play(1, offsets)
    assert played.method.follows(2) == (leader,)


def test_the_robots_edges_while_it_follows_nobody_are_an_option(story):
    assert story.Story("sia", edges="all").play(0, TOGETHER).method.follows(1) is None


def test_the_rehearsals_leader_is_followed_at_once_if_asked(story):
    played = story.Story("sia", first_followed_iteration=1).play(0, TOGETHER)
    assert played.method.follows(1) == ("dancer_1",)
    assert sent(played.tell(story.event("dancer_1", 1, SF, 0.1, early=True))) == [(0, "dancer_1")]


def test_one_dancer_always_late_is_never_followed(story):
    rng = np.random.default_rng(1)
    for _ in range(10):
        played = story.Story("sia")
        for iteration in range(4):
            offsets = {name: rng.normal(0, 0.05, 9) for name in ("dancer_1", "dancer_3")}
            played.play(iteration, {**offsets, "dancer_2": 0.7 + rng.normal(0, 0.05, 9)})
        assert all(played.method.follows(i) != ("dancer_2",) for i in (2, 3, 4))
        assert all(a.person != "dancer_2" for a in played.answers)


def test_an_early_event_of_the_leader_triggers_at_once(following, story):
    early = story.event("dancer_1", 2, SF, -0.1, early=True)
    (answer,) = following.tell(early)
    assert (answer.iteration, answer.ordinal, answer.person) == (2, 0, "dancer_1")
    assert answer.t_s == early.t_arrival_s
    assert answer.why.startswith("early start_forward of dancer_1")


def test_early_and_regular_of_one_move_trigger_once(following, story):
    stream = [(SF, -0.1, True), (SF, 0.0, False), (SF, 0.0, False), (TF, 1.9, True), (TF, 2.0, False)]
    answers = [a for kind, at, early in stream for a in following.tell(story.event("dancer_1", 2, kind, at, early))]
    assert sent(answers) == [(0, "dancer_1"), (1, "dancer_1")]


def test_the_regular_event_triggers_where_no_early_one_came(following, story):
    assert sent(following.tell(story.event("dancer_1", 2, SF, 0.2))) == [(0, "dancer_1")]


def test_nobody_but_the_leader_is_followed(following, story):
    for person in ("dancer_2", "dancer_3", "stranger"):
        assert following.tell(story.event(person, 2, SF, 0.0, early=True)) == []
        assert following.tell(story.event(person, 2, SF, 0.0)) == []


def test_only_the_expected_kind_counts(following, story):
    for kind in (TF, SB, TB):
        assert following.tell(story.event("dancer_1", 2, kind, 0.0, early=True)) == []
    assert sent(following.tell(story.event("dancer_1", 2, SF, 0.1))) == [(0, "dancer_1")]


def test_an_early_clap_is_no_clap(following, story):
    for step in range(8):
        following.tell(story.event("dancer_1", 2, story.context().steps[step].kind, story.nominal[step]))
    assert following.tell(story.event("dancer_1", 2, CLAP, story.nominal[8], early=True)) == []
    assert sent(following.tell(story.event("dancer_1", 2, CLAP, story.nominal[8] + 0.1))) == [(8, "dancer_1")]


def test_an_event_outside_the_window_is_not_followed(story):
    played = story.Story("sia", window_s=1.0).play(0, TOGETHER).play(1, TOGETHER)
    played.begin(2)
    assert played.tell(story.event("dancer_1", 2, SF, -1.1, early=True)) == []
    assert sent(played.tell(story.event("dancer_1", 2, SF, -0.9, early=True))) == [(0, "dancer_1")]


def test_without_events_of_the_leader_the_fallback_comes_at_the_end_of_the_window(following, story):
    for step in range(9):
        plan = following.plan[2, step]
        assert plan.why.startswith("fallback")
        assert plan.person == ""
    close = story.timetable.close_s(2) - story.start_s(2)
    latest = np.minimum(story.nominal + 2.0, close)
    for back in (2, 6):  # so that the robot is back before the next phrase, or the clap
        latest[back] = min(
            latest[back], story.nominal[back + 2] - MIN_PAUSE_S - (story.nominal[back + 1] - story.nominal[back])
        )
    assert following.after(2)[:8] == pytest.approx(latest[:8])


def test_the_reason_of_a_fallback_says_how_long_its_own_window_was(following):
    reasons = [following.plan[2, step].why for step in range(9)]
    assert reasons[0] == (
        "fallback: no start_forward of dancer_1, most synchronous in iteration 1 (tie with dancer_2) "
        "until 2.0 s after its expected time"
    )
    # The turn's window ends 1 s after its scheduled time: dancer_1 is .22 s ahead of the mean, the robot leads by .15.
    assert "no clap of dancer_1" in reasons[8]
    assert reasons[8].endswith("until 1.1 s after its expected time")


def test_a_window_that_ends_before_the_expected_time_says_so(story):
    """The leader's last clap was late: the turn is scheduled at the mean, .15 s early, and waits for no clap."""
    offsets = TOGETHER | {"dancer_1": np.array([0.0] * 8 + [0.9])}
    played = story.Story("sia", clap_wait_s=0.0).play(0, TOGETHER).play(1, offsets)
    played.begin(2)
    assert played.method.follows(2) == ("dancer_1",)
    assert played.plan[2, 8].why.endswith("until 0.5 s before its expected time")


def test_a_turn_without_a_clap_waits_a_second_past_its_schedule(following, story):
    scheduled = story.nominal[8] + (0.05 + 0.6) / 3 - LEAD_S
    assert following.after(2)[8] == pytest.approx(scheduled + 1.0)
    assert sent(following.tell(story.event("dancer_1", 2, CLAP, story.nominal[8] + 1.2))) == []


def test_a_phrase_that_comes_early_as_a_whole_is_followed(following, story):
    for index, kind in enumerate((SF, TF, SB, TB)):
        following.tell(story.event("dancer_1", 2, kind, story.nominal[index]))
    early = story.nominal[4:8] - [1.8, 2.4, 2.9, 2.7]
    answers = [
        following.tell(story.event("dancer_1", 2, kind, at)) for kind, at in zip((SF, TF, SB, TB), early, strict=True)
    ]
    assert [sent(one) for one in answers] == [[(ordinal, "dancer_1")] for ordinal in (4, 5, 6, 7)]


def test_a_phrase_completed_without_the_leader_is_not_scheduled_twice(story):
    early = np.array([0.0, 0.0, 0.0, 0.0, -1.5, -1.5, 0.0, 0.0, 0.0])
    at = {"dancer_1": early, "dancer_2": early + 0.05, "dancer_3": early + 0.6}
    following = story.Story("sia").play(0, at).play(1, at)
    following.begin(2)
    for index, kind in enumerate((SF, TF, SB, TB)):
        following.tell(story.event("dancer_1", 2, kind, story.nominal[index]))
    following.wait(story.start_s(2) + following.after(2)[4])
    alone = following.after(2)[5:8]
    assert sent(following.wait(story.start_s(2) + following.after(2)[8])) == []
    assert following.after(2)[5:8] == pytest.approx(alone)


def test_a_leader_who_comes_back_within_a_phrase_is_waited_for_in_the_rest_of_it(following, story):
    planned = following.after(2)
    for index, kind in enumerate((SF, TF, SB, TB)):
        following.tell(story.event("dancer_1", 2, kind, story.nominal[index]))
    following.wait(story.start_s(2) + planned[4])
    back = following.tell(story.event("dancer_1", 2, TF, story.nominal[5] + 1.0))
    assert sent(back) == [(5, "dancer_1"), (6, ""), (7, "")]
    assert following.after(2)[6:8] == pytest.approx(planned[6:8])


def test_nothing_is_expected_after_the_clap(following, story):
    for index, kind in enumerate((SF, TF, SB, TB, SF, TF, SB, TB, CLAP)):
        assert sent(following.tell(story.event("dancer_1", 2, kind, story.nominal[index]))) == [(index, "dancer_1")]
    assert following.tell(story.event("dancer_1", 2, SF, story.nominal[8] + 1.0)) == []


def test_a_phrase_begun_too_late_is_made_shorter(story):
    late = np.array([0.0, 0.0, 0.0, 0.0, 1.4, 1.4, 0.0, -0.5, -1.5])
    at = {"dancer_1": late, "dancer_2": late + 0.05, "dancer_3": late + 0.6}
    following = story.Story("sia").play(0, at).play(1, at)
    following.begin(2)
    for index, kind in enumerate((SF, TF, SB, TB)):
        following.tell(story.event("dancer_1", 2, kind, story.nominal[index]))
    begun = following.after(2)[4]
    following.wait(story.start_s(2) + begun)
    rest = following.after(2)[5:8]
    assert rest[-1] == pytest.approx(story.nominal[8] - 1.5 - MIN_PAUSE_S)
    whole = np.diff(story.nominal[4:8] + late[4:8])
    assert (np.diff([begun, *rest]) < whole).all()


def test_a_phrase_that_the_leader_leaves_out_is_completed_before_the_turn(following, story):
    planned = following.after(2)
    begun = planned[4]
    for index, kind in enumerate((SF, TF, SB, TB)):
        following.tell(story.event("dancer_1", 2, kind, story.nominal[index]))
    rest = following.wait(story.start_s(2) + begun)
    assert sent(rest) == [(5, ""), (6, ""), (7, "")]
    stop, back, done = following.after(2)[5:8]
    assert stop - begun == pytest.approx(story.nominal[5] - story.nominal[4], abs=0.05)
    assert stop < back < done < story.nominal[8]
    assert "made without dancer_1" in rest[0].why
    assert sent(following.tell(story.event("dancer_1", 2, SB, story.nominal[6] + 0.1))) == [(6, "dancer_1"), (7, "")]
    assert following.after(2)[7] == pytest.approx(planned[7])  # back again, it has time


def test_the_stop_of_a_followed_start_needs_no_window(story):
    long = np.array([0.0, 2.5, 2.5, 2.5, 2.5, 2.5, 0.0, 0.0, 0.0])
    at = {"dancer_1": long, "dancer_2": long + 0.05, "dancer_3": 0.6}
    following = story.Story("sia").play(0, at).play(1, at)
    following.begin(2)
    assert following.method.follows(2) == ("dancer_1",)
    assert sent(following.tell(story.event("dancer_1", 2, SF, 0.1))) == [(0, "dancer_1")]
    assert sent(following.tell(story.event("dancer_1", 2, TF, story.nominal[1]))) == [(1, "dancer_1")]


def test_timers_do_nothing_while_the_leader_is_followed(following, story):
    for index, kind in enumerate((SF, TF, SB, TB, SF, TF, SB, TB)):
        following.tell(story.event("dancer_1", 2, kind, story.nominal[index]))
    assert following.wait(story.timetable.close_s(2)) == []


def test_the_fallback_comes_at_its_scheduled_time_if_that_is_later(story):
    at = {"dancer_1": -0.7, "dancer_2": -0.7, "dancer_3": 0.7}
    played = story.Story("sia", window_s=0.3).play(0, at).play(1, at)
    mean = -0.7 / 3  # all three lie within one chain of epsilon
    assert played.after(2)[:8] == pytest.approx(story.nominal[:8] + mean - LEAD_S)


def test_after_a_fallback_the_next_step_is_expected(following, story):
    assert following.tell(story.event("dancer_1", 2, SF, 2.1)) == []
    assert sent(following.tell(story.event("dancer_1", 2, TF, 2.2, early=True))) == [(1, "dancer_1")]


def test_a_missed_stop_falls_back_when_the_leader_is_past_it(following, story):
    assert sent(following.tell(story.event("dancer_1", 2, SF, 0.0))) == [(0, "dancer_1")]
    # the stop is lost; the leader, half a second ahead, already goes back
    stop, start = following.tell(story.event("dancer_1", 2, SB, story.nominal[2] - 0.5))
    assert (stop.ordinal, stop.person) == (1, "")
    assert stop.why.startswith("fallback")
    assert (start.ordinal, start.person) == (2, "dancer_1")


def test_a_move_whose_stop_is_detected_first_is_made_late_if_time_is_left(following, story):
    following.tell(story.event("dancer_1", 2, TB, story.nominal[3]))
    now = story.nominal[5] - 0.2
    start, stop = following.tell(story.event("dancer_1", 2, TF, now))
    assert [(one.ordinal, one.person, one.why[:9]) for one in (start, stop)] == [
        (4, "", "made late"), (5, "", "made late")
    ]  # fmt: skip
    assert stop.t_s - start.t_s == pytest.approx(story.nominal[5] - story.nominal[4])
    assert sent(following.tell(story.event("dancer_1", 2, SB, story.nominal[6]))) == [(6, "dancer_1")]


def test_a_move_that_would_not_be_over_in_time_is_cancelled_with_its_stop(following, story):
    following.tell(story.event("dancer_1", 2, TB, story.nominal[3]))
    answers = following.tell(story.event("dancer_1", 2, TF, story.nominal[4] + 1.95))
    assert [type(one) for one in answers] == [CancelCommand, CancelCommand]
    assert [one.ordinal for one in answers] == [4, 5]


def test_the_leaders_missing_time_is_replaced_by_the_schedule(story):
    played = story.Story("sia").play(0, TOGETHER)
    played.play(1, TOGETHER, skip=[("dancer_1", 4)])
    assert played.method.follows(2) == ("dancer_1",)  # tied with dancer_2, and followed before
    scheduled = story.nominal[4] + (0.05 + 0.6) / 2
    assert played.after(2)[4] == pytest.approx(scheduled + 2.0)


def test_a_tie_keeps_the_leader_and_is_logged(story):
    played = story.Story("sia").play(0, {"dancer_1": 1.0, "dancer_2": 0.0, "dancer_3": 0.1})
    assert played.method.follows(1) == ()
    played.play(1, {"dancer_1": 0.0, "dancer_2": 0.0, "dancer_3": 0.0})
    assert played.method.follows(2) == ("dancer_2",)
    assert "tie with dancer_1, dancer_3" in played.plan[2, 0].why


def test_an_iteration_without_events_keeps_leader_and_schedule(story):
    played = story.Story("sia").play(0, TOGETHER)
    played.play(1, {"dancer_1": 1.5, "dancer_2": 0.3, "dancer_3": 0.3})
    assert played.method.follows(2) == ("dancer_2",)
    played.begin(2)
    played.end(2)
    assert played.method.follows(3) == ("dancer_2",)
    played.begin(3)
    assert sent(played.tell(story.event("dancer_2", 3, SF, 0.0, early=True))) == [(0, "dancer_2")]


def test_a_new_leader_is_followed_from_the_close_of_the_window(story):
    played = (
        story.Story("sia").play(0, TOGETHER).play(1, TOGETHER).play(2, {"dancer_1": 2, "dancer_2": 0, "dancer_3": 0})
    )
    # before beat 0 of iteration 3
    assert sent(played.tell(story.event("dancer_2", 3, SF, -0.5, early=True))) == [(0, "dancer_2")]
    assert played.tell(story.event("dancer_1", 3, TF, 2.0, early=True)) == []


def test_a_dance_that_ends_with_a_move_is_completed_without_the_leader(story):
    steps, starts = march().steps(), (4.0, 30.0, 60.0)
    ends = tuple(start + 24.0 for start in starts)
    method = build_method("sia")
    method.reset(MethodContext(("dancer_1", "dancer_2"), steps, 2, 0.5, starts, ends), np.random.default_rng(0))
    for iteration in (0, 1):
        for step in steps:
            for person in ("dancer_1", "dancer_2"):
                t_s = starts[iteration] + 0.5 * step.beat
                method.on_event(Event(person, step.kind, t_s, t_s + 0.02, False, iteration, "north"))
        answers = method.on_iteration_end(iteration, ends[iteration])
    wakes = sorted(answer.t_s for answer in answers if isinstance(answer, SetTimer))
    last = [ordinal for ordinal, _ in sent(method.on_timer(wakes[-1]))] or [
        ordinal for t_s in wakes for ordinal, _ in sent(method.on_timer(t_s))
    ]
    assert last[-1] == steps[-1].ordinal
