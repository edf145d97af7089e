"""The reward by hand: what each term pays, and that its sum ranks as the measures do."""

from __future__ import annotations

import itertools
import math
from types import SimpleNamespace

import gymnasium as gym
import numpy as np
import pytest
from gymnasium import error
from sjasim_envs.reward import RewardConfig, Scorer

from sjasim.choreography.layout import layout
from sjasim.choreography.timetable import timetable
from sjasim.config import SessionConfig
from sjasim.core import Event, Kind
from sjasim.core.method_io import MethodContext
from sjasim.core.session_log import AgentEvent

from .dancers import Oracle, dance, idle, leave_be

CONFIG = SessionConfig(method="agent", iterations=2)
TABLE = timetable(CONFIG)
STEPS = TABLE.choreography.steps()
CAST = ("dancer_1", "dancer_2", "dancer_3")
CLOSE_S = TABLE.close_s(1)


class Story:
    """A session told by hand."""

    def __init__(self, **weights):
        numbers = range(3)
        starts, ends = (tuple(at(i) for i in numbers) for at in (TABLE.start_s, TABLE.close_s))
        self.pose, self.touching = (0.0, 0.0), False
        room = layout(CONFIG)
        physics = SimpleNamespace(
            contacts=SimpleNamespace(robot_touches_dancer=lambda: self.touching),
            robot_pose=lambda: (room.robot[0] + self.pose[0], room.robot[1] + self.pose[1], math.pi / 2),
        )
        self.session = SimpleNamespace(
            context=MethodContext(CAST, STEPS, 2, 60 / 118, starts, ends), config=CONFIG, timetable=TABLE, layout=room,
            events=[], followed=[], world=SimpleNamespace(robot_events=[]), time_s=starts[1],
        )  # fmt: skip
        self.scorer = Scorer(self.session, physics, RewardConfig.from_mapping(weights))

    def dancers(self, late_s=(0.0, 0.0, 0.0), step=0, iteration=1, early=False):
        for person, late in zip(CAST, late_s, strict=True):
            if late is not None:
                t_s = TABLE.time_s(iteration, STEPS[step].beat) + late
                kind = STEPS[step].kind
                self.session.events.append(Event(person, kind, t_s, t_s + 0.1, early, iteration, "north"))

    def robot(self, late_s=0.0, step=0, iteration=1):
        kind = Kind.TURN if STEPS[step].kind is Kind.CLAP else STEPS[step].kind
        t_s = TABLE.time_s(iteration, STEPS[step].beat) + late_s
        self.session.world.robot_events.append(AgentEvent(iteration, "robot", kind, t_s))

    def after(self, seconds=0.0, until=None):
        self.session.time_s = self.session.time_s + seconds if until is None else until
        info = self.scorer.update(self.session.time_s)
        terms = self.scorer.terms.items()
        return {name.removeprefix("reward_"): value for name, value in terms if value}, info


@pytest.mark.parametrize(("off_s", "paid"), [(0.0, 1.0), (0.25, 0.75), (-0.25, 0.75), (1.5, -0.5), (3.0, -1.0)])
@pytest.mark.parametrize("step", [0, 3, 8])
def test_an_event_is_worth_what_it_is_off_the_dancers_mean(off_s, paid, step):
    story = Story()
    story.dancers((0.1, 0.2, 0.3), step)
    story.robot(0.2 + off_s, step)
    assert story.after()[0] == {"timing": pytest.approx(paid)}
    assert story.after()[0] == {}


def test_it_is_paid_when_robot_and_all_dancers_are_known():
    story = Story()
    story.robot(0.1)
    story.dancers((0.0, 0.0, None))
    story.dancers((0.0, 0.0, 0.0), early=True)
    assert story.after()[0] == {}
    story.dancers((None, None, 0.0))
    assert story.after()[0] == {"timing": pytest.approx(0.9)}


def test_at_the_end_of_the_iteration_those_count_who_danced_and_the_rest_is_missed():
    story = Story()
    story.robot(0.5)
    story.dancers((0.0, 0.2, None))
    assert story.after(until=CLOSE_S)[0] == {}
    terms, info = story.after(until=CLOSE_S + 0.6)
    assert terms == {"timing": pytest.approx(0.6), "missed": -8.0}
    assert info["iteration_done"] == 1
    assert info["robot_missed"] == 8
    assert info["event_errors_s"][0] == pytest.approx(0.4)
    assert info["ta_mean_s"] == pytest.approx(0.4)
    assert np.isnan(info["event_errors_s"][1:]).all()
    assert story.after(1.0) == ({}, {})


def test_what_nobody_danced_is_worth_nothing_to_a_robot_that_did():
    story = Story(missed=0.0)
    story.robot()
    assert story.after(until=CLOSE_S + 0.6)[0] == {}


def test_events_too_many_and_events_of_the_rehearsal_are_spurious():
    story = Story(spurious=0.25)
    story.dancers()
    story.robot()
    story.robot(0.4)
    story.robot(iteration=0)
    assert story.after()[0] == {"timing": pytest.approx(1.0), "spurious": -0.5}


def test_touching_and_leaving_the_lane_cost_by_the_second():
    story = Story(collision=2.0, drift=1.0, lane_m=0.1)
    story.pose = (0.0, 0.5)  # north is ahead: the end of a move
    assert story.after(0.5)[0] == {}
    story.pose, story.touching = (0.3, 0.2), True
    assert story.after(0.5)[0] == {"collision": -1.0, "drift": pytest.approx(-0.1)}
    story.pose, story.touching = (0.0, -1.1), False
    assert story.after(0.1)[0] == {"drift": pytest.approx(-0.1)}


def test_weights_are_checked():
    for given in ({"timing": -1.0}, {"worst_s": "2"}, {"bonus": 1.0}, {"missed": True}):
        with pytest.raises(error.Error, match=f"reward.{next(iter(given))}"):
            RewardConfig.from_mapping(given)


GROUPS = (0, 6101, 6102, 6103)


def danced(name, seed):
    """Return, mean timing error and synchrony of one policy; all meet the same people in the same performance.

    Errors count as far as they do in the reward: of somebody seconds behind nobody can say who met them better.
    """
    method = {"method": name} if name in ("sia", "eca") else {}
    env = gym.make("sjasim/Dance-v0", iterations=3, performance="one", disable_env_checker=True, **method)
    total, rows = dance(env, {"oracle": Oracle, "idle": idle}.get(name, leave_be), seed=seed)
    errors = np.minimum(np.abs([row["event_errors_s"] for row in rows]), RewardConfig().worst_s)
    ta_s = np.nanmean(errors) if np.isfinite(errors).any() else np.inf
    return total, ta_s, np.mean([row["gsi_full_edges"] for row in rows])


ALIKE_S = 0.1
"""Two policies whose mean errors are nearer than this may rank either way: a missed step costs but has no error."""


@pytest.mark.slow
@pytest.mark.parametrize("seed", GROUPS)
def test_the_sum_ranks_as_timing_appropriateness_and_synchrony_do(seed):
    """An oracle earns most, who stands still least, and between them who is nearer to the dancers earns more."""
    rows = {name: danced(name, seed) for name in ("oracle", "sia", "eca", "idle")}
    for (one, own), (other, its) in itertools.combinations(rows.items(), 2):
        if abs(own[1] - its[1]) > ALIKE_S:
            assert (own[0] > its[0]) == (own[1] < its[1]), (one, other)
    by_return = sorted(rows, key=lambda name: -rows[name][0])
    assert (by_return[0], by_return[-1]) == ("oracle", "idle")
    assert rows["oracle"][2] > max(rows[name][2] for name in ("sia", "eca"))
