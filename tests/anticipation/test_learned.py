"""A learned policy as a method: its file, its features, its actions."""

import heapq
import itertools

import numpy as np
import pytest

from sjasim.anticipation.method import build_method
from sjasim.anticipation.observation import MOVES, EventFeatures
from sjasim.anticipation.policy_network import PolicyNetwork
from sjasim.anticipation.step_selection import MAX_EARLY_BEATS, StepSelector
from sjasim.core import Event, Kind
from sjasim.core.errors import ConfigError
from sjasim.core.method_io import ROBOT_MOVES, CancelCommand, ScheduleCommand, SetTimer

from ..contracts.test_anticipation import STEPS, context
from .policies import WIDTH, write

PLAN = context()


@pytest.fixture
def policy(tmp_path):
    return write(tmp_path / "policy.npz")


def dance(method, plan):
    """Play a dance without noise; (session time, action) in order."""
    told = [(plan.iteration_start_s[i], 0, method.on_iteration_start, (i, plan.iteration_start_s[i])) for i in range(5)]
    told += [(plan.window_end_s[i], 1, method.on_iteration_end, (i, plan.window_end_s[i])) for i in range(5)]
    for i, step, person in itertools.product(range(5), STEPS, plan.cast):
        t_s = plan.iteration_start_s[i] + step.beat * plan.beat_s
        told.append((t_s + 0.02, 2, method.on_event, (Event(person, step.kind, t_s, t_s + 0.02, False, i, "north"),)))
    agenda = [(t_s, rank, number, hook, given) for number, (t_s, rank, hook, given) in enumerate(told)]
    heapq.heapify(agenda)
    out = []
    while agenda:
        t_s, _, _, hook, given = heapq.heappop(agenda)
        for answer in hook(*given):
            out.append((t_s, answer))
            if isinstance(answer, SetTimer):
                heapq.heappush(agenda, (answer.t_s, 3, len(told) + len(out), method.on_timer, (answer.t_s,)))
    return out


def start(policy, plan):
    method = build_method("learned", {"policy": policy})
    method.reset(plan, np.random.default_rng(0))
    return method


def test_a_file_of_another_kind_is_refused_without_advice_to_load_it(tmp_path):
    (tmp_path / "notes.md").write_text("# Notes")
    with pytest.raises(ConfigError, match="it is none"):
        build_method("learned", {"policy": str(tmp_path / "notes.md")})


def test_it_sends_every_step_once_and_reset_forgets_everything(policy):
    plan = context()
    answers = dance(start(policy, plan), plan)
    own = [answer for _, answer in answers if isinstance(answer, ScheduleCommand)]
    assert not any(isinstance(answer, CancelCommand) for _, answer in answers)
    keys = [(answer.iteration, answer.ordinal) for answer in own]
    assert keys == [(iteration, ordinal) for iteration in range(1, 5) for ordinal in range(len(STEPS))]
    method = start(policy, plan)
    assert dance(method, plan) == answers
    method.reset(plan, np.random.default_rng(0))
    assert dance(method, plan) == answers


def test_the_policy_is_evaluated_at_the_rate_of_its_training(policy):
    plan = context()
    wakes = sorted({answer.t_s for _, answer in dance(start(policy, plan), plan) if isinstance(answer, SetTimer)})
    assert np.diff(wakes) == pytest.approx(0.1)


@pytest.mark.parametrize(
    ("changes", "says"),
    [({"w1": None}, "b1|w1|fit|scores"), ({"mean": np.zeros(3)}, "operands|shape|policy"), ({"step_hz": 0}, "policy"),
     ({"b1": np.full(4, np.nan)}, "finite"), ({"w1": np.zeros((5, 8)), "b1": np.zeros(5)}, "4 finite scores")],
)  # fmt: skip
def test_a_wrong_file_is_refused(tmp_path, changes, says):
    with pytest.raises(ConfigError, match=says):
        build_method("learned", {"policy": write(tmp_path / "wrong.npz", **changes)})


def test_no_file_is_refused(tmp_path):
    with pytest.raises(ConfigError, match="trained policy"):
        build_method("learned")
    with pytest.raises(ConfigError, match=r"missing\.npz"):
        build_method("learned", {"policy": str(tmp_path / "missing.npz")})


def test_a_policy_of_other_people_is_refused(policy):
    with pytest.raises(ConfigError, match="features"):
        start(policy, context(("dancer_1", "dancer_2")))


def test_scores_are_those_of_a_two_layer_network(tmp_path):
    network = PolicyNetwork.read(write(tmp_path / "policy.npz", clip=0.5))
    x = np.linspace(-1, 1, WIDTH)
    (w0, b0), (w1, b1) = network.layers
    assert network.scores(x) == pytest.approx(w1 @ np.tanh(w0 @ np.clip(x, -0.5, 0.5) + b0) + b1)


class TestStepSelector:
    """The paper's dance: forward at beat 0, stop 4, backward 8, stop 12 and so on, clap and turn at 32."""

    def at(self, beat, iteration=1):
        return PLAN.iteration_start_s[iteration] + beat * PLAN.beat_s

    def test_a_move_stands_for_the_nearest_step_of_its_kind(self):
        steps = StepSelector(PLAN)
        wanted = [(first.beat, MOVES.index(ROBOT_MOVES[first.kind])) for first in STEPS]
        assert [steps.select(self.at(beat + 0.5), move) for beat, move in wanted] == [(1, k) for k in range(len(STEPS))]

    def test_no_step_is_selected_twice_or_behind_another(self):
        steps = StepSelector(PLAN)
        assert steps.select(self.at(STEPS[2].beat), MOVES.index("backward")) == (1, 2)
        assert steps.select(self.at(STEPS[1].beat), MOVES.index("stop")) is None
        assert steps.move == MOVES.index("backward")
        assert steps.select(self.at(STEPS[2].beat), MOVES.index("backward")) is None

    def test_a_move_long_before_its_beat_stands_for_no_step(self):
        steps = StepSelector(PLAN)
        turn = MOVES.index("turn")
        assert steps.select(self.at(STEPS[-1].beat - 1.01 * MAX_EARLY_BEATS), turn) is None
        assert steps.select(self.at(STEPS[-1].beat - 0.99 * MAX_EARLY_BEATS), turn) == (1, len(STEPS) - 1)

    def test_a_move_can_be_stopped_however_late(self):
        steps = StepSelector(PLAN)
        assert steps.select(self.at(0.0), MOVES.index("forward")) == (1, 0)
        assert steps.select(self.at(8.4), MOVES.index("stop")) == (1, 1)
        assert steps.select(self.at(8.6), MOVES.index("backward")) == (1, 2)

    def test_no_step_is_selected_in_the_rehearsal(self):
        assert StepSelector(PLAN).select(self.at(0.0, 0), MOVES.index("forward")) is None


class TestEventFeatures:
    def test_events_age_and_are_forgotten(self):
        features = EventFeatures(plan := context())
        t_s = plan.iteration_start_s[1]
        features.add(Event("dancer_2", Kind.CLAP, t_s, t_s + 0.02, False, 1, "north"))
        features.add(Event("dancer_2", Kind.STOP_FORWARD, t_s + 1, t_s + 1.02, True, 1, "north"))
        features.add(Event("somebody", Kind.CLAP, t_s + 1, t_s + 1, False, 1, "north"))
        ages = self.parts(features, t_s + 3.0)[3]
        assert ages[1, 4, 0] == pytest.approx(3.0)
        assert ages[1, 1, 1] == pytest.approx(2.0)
        assert (ages == 10.0).sum() == ages.size - 2
        assert (self.parts(features, t_s + 30.0)[3] == 10.0).all()

    def test_the_age_of_an_event_in_the_future_is_zero(self):
        """A clock that has jumped may give a time in the future; an age is never negative."""
        features = EventFeatures(context())
        features.add(Event("dancer_1", Kind.CLAP, 9.0, 5.0, False, 1, "north"))
        assert self.parts(features, 6.0)[3][0, 4, 0] == 0.0

    def test_deviations_of_the_last_iteration_are_relative_to_the_music(self):
        features = EventFeatures(plan := context())
        for step in STEPS:
            t_s = plan.iteration_start_s[1] + step.beat * plan.beat_s + 0.25
            features.add(Event("dancer_3", step.kind, t_s, t_s, False, 1, "north"))
        assert not self.parts(features, plan.iteration_start_s[1])[5].any()
        late = self.parts(features, plan.iteration_start_s[2])[5]
        assert late[2] == pytest.approx(0.25, abs=1e-6)
        assert not late[:2].any()

    def test_the_beat_runs_through_the_iteration(self):
        features = EventFeatures(plan := context())
        beat = self.parts(features, plan.iteration_start_s[2] + 10 * plan.beat_s)[0]
        assert beat[0] == pytest.approx(0.25)
        assert beat[1:5] == pytest.approx([1, -1, 0, 0], abs=1e-5)
        times_s = plan.window_end_s[2], plan.window_end_s[2] + 0.01, 1e6
        assert [int(self.parts(features, t_s)[4][0]) for t_s in times_s] == [2, 3, 4]
        assert self.parts(features, 1e6)[0][0] == 2.0

    @staticmethod
    def parts(features, t_s):
        """Beat, move, its age, ages (D, 5, 2), iteration, last iteration (D, K) out of a row."""
        beat, move, sent, ages, iteration, late = np.split(features.row(t_s, 0, t_s), (9, 13, 14, 44, 45))
        return beat, move, sent, ages.reshape(3, 5, 2), iteration, late.reshape(3, -1)

    def test_the_move_in_force_is_one_of_four(self):
        features = EventFeatures(context())
        row = features.row(5.0, MOVES.index("turn"), 3.0)
        assert row[9:14].tolist() == [0.0, 0.0, 0.0, 1.0, 2.0]
