"""Each term of the reward on scripted events, and the ranking of policies by their return."""

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

from .policies import Oracle, repeat_move, run_episode, stand_still

CONFIG = SessionConfig(method="agent", iterations=2)
TABLE = timetable(CONFIG)
STEPS = TABLE.choreography.steps()
CAST = ("dancer_1", "dancer_2", "dancer_3")
CLOSE_S = TABLE.close_s(1)


class ScriptedSession:
    """A session whose events and robot pose a test sets by hand, and its scorer."""

    def __init__(self, **weights):
        self.pose_m = (0.0, 0.0)
        self.touching = False
        place = layout(CONFIG)
        physics = SimpleNamespace(
            contacts=SimpleNamespace(robot_touches_dancer=lambda: self.touching),
            robot_pose=lambda: (place.robot[0] + self.pose_m[0], place.robot[1] + self.pose_m[1], math.pi / 2),
        )

        iterations = range(CONFIG.iterations + 1)
        starts_s = tuple(TABLE.start_s(iteration) for iteration in iterations)
        ends_s = tuple(TABLE.close_s(iteration) for iteration in iterations)
        self.session = SimpleNamespace(
            context=MethodContext(CAST, STEPS, CONFIG.iterations, 60 / 118, starts_s, ends_s),
            config=CONFIG,
            timetable=TABLE,
            layout=place,
            events=[],
            followed=[],
            world=SimpleNamespace(robot_events=[]),
            time_s=starts_s[1],
        )
        self.scorer = Scorer(self.session, physics, RewardConfig.from_mapping(weights))

    def add_dancer_events(self, late_s=(0.0, 0.0, 0.0), step=0, iteration=1, early=False):
        """Add an event of each dancer at a step, late by some seconds; none for a dancer with None."""
        kind = STEPS[step].kind
        for person, late in zip(CAST, late_s, strict=True):
            if late is not None:
                t_s = TABLE.time_s(iteration, STEPS[step].beat) + late
                self.session.events.append(Event(person, kind, t_s, t_s + 0.1, early, iteration, "north"))

    def add_robot_event(self, late_s=0.0, step=0, iteration=1):
        """Add an event of the robot at a step, late by some seconds."""
        kind = Kind.TURN if STEPS[step].kind is Kind.CLAP else STEPS[step].kind
        t_s = TABLE.time_s(iteration, STEPS[step].beat) + late_s
        self.session.world.robot_events.append(AgentEvent(iteration, "robot", kind, t_s))

    def update(self, seconds=0.0, until_s=None):
        """Let time pass; returns the terms that are not zero, and the figures of a closed iteration."""
        self.session.time_s = self.session.time_s + seconds if until_s is None else until_s
        figures = self.scorer.update(self.session.time_s)
        terms = self.scorer.terms.items()
        return {name.removeprefix("reward_"): value for name, value in terms if value}, figures


@pytest.mark.parametrize(("error_s", "reward"), [(0.0, 1.0), (0.25, 0.75), (-0.25, 0.75), (1.5, -0.5), (3.0, -1.0)])
@pytest.mark.parametrize("step", [0, 3, 8])
def test_timing_decreases_with_the_distance_from_the_dancers_mean_and_is_paid_once(error_s, reward, step):
    scripted = ScriptedSession()
    scripted.add_dancer_events((0.1, 0.2, 0.3), step)
    scripted.add_robot_event(0.2 + error_s, step)
    assert scripted.update()[0] == {"timing": pytest.approx(reward)}
    assert scripted.update()[0] == {}


def test_a_step_is_scored_when_robot_and_all_dancers_have_regular_events():
    scripted = ScriptedSession()
    scripted.add_robot_event(0.1)
    scripted.add_dancer_events((0.0, 0.0, None))
    scripted.add_dancer_events((0.0, 0.0, 0.0), early=True)
    assert scripted.update()[0] == {}
    scripted.add_dancer_events((None, None, 0.0))
    assert scripted.update()[0] == {"timing": pytest.approx(0.9)}


def test_of_several_events_of_a_dancer_the_one_nearest_to_the_beat_counts():
    scripted = ScriptedSession()
    scripted.add_dancer_events((0.5, 0.0, None))
    scripted.add_dancer_events((0.3, None, None))
    scripted.add_dancer_events((0.6, None, 0.0))
    scripted.add_robot_event(0.1)
    assert scripted.update()[0] == {"timing": pytest.approx(1.0)}


def test_a_closed_iteration_scores_incomplete_steps_and_charges_missed_ones():
    scripted = ScriptedSession()
    scripted.add_robot_event(0.5)
    scripted.add_dancer_events((0.0, 0.2, None))
    assert scripted.update(until_s=CLOSE_S)[0] == {}
    terms, figures = scripted.update(until_s=CLOSE_S + 0.6)
    assert terms == {"timing": pytest.approx(0.6), "missed": -8.0}
    assert figures["iteration_done"] == 1
    assert figures["robot_missed"] == 8
    assert figures["event_errors_s"][0] == pytest.approx(0.4)
    assert figures["ta_mean_s"] == pytest.approx(0.4)
    assert np.isnan(figures["event_errors_s"][1:]).all()
    assert scripted.update(1.0) == ({}, {})


def test_a_step_that_no_dancer_danced_earns_nothing():
    scripted = ScriptedSession(missed=0.0)
    scripted.add_robot_event()
    assert scripted.update(until_s=CLOSE_S + 0.6)[0] == {}


def test_a_second_event_of_a_step_and_an_event_of_the_rehearsal_are_spurious():
    scripted = ScriptedSession(spurious=0.25)
    scripted.add_dancer_events()
    scripted.add_robot_event()
    scripted.add_robot_event(0.4)
    scripted.add_robot_event(iteration=0)
    assert scripted.update()[0] == {"timing": pytest.approx(1.0), "spurious": -0.5}


def test_contact_and_distance_from_the_lane_cost_by_the_second():
    scripted = ScriptedSession(collision=2.0, drift=1.0, lane_m=0.1)
    scripted.pose_m = (0.0, 0.5)  # the lane extends to the north, by the length of a move
    assert scripted.update(0.5)[0] == {}
    scripted.pose_m = (0.3, 0.2)
    scripted.touching = True
    assert scripted.update(0.5)[0] == {"collision": -1.0, "drift": pytest.approx(-0.1)}
    scripted.pose_m = (0.0, -1.1)
    scripted.touching = False
    assert scripted.update(0.1)[0] == {"drift": pytest.approx(-0.1)}


@pytest.mark.parametrize("weights", [{"timing": -1.0}, {"worst_s": "2"}, {"bonus": 1.0}, {"missed": True}], ids=str)
def test_a_weight_that_is_not_allowed_is_named(weights):
    with pytest.raises(error.Error, match=f"reward.{next(iter(weights))}"):
        RewardConfig.from_mapping(weights)


SEEDS = (0, 6101, 6102, 6103)

EQUAL_S = 0.1
"""Policies whose mean errors differ by less may rank either way: a missed step costs, but has no error [s]."""


def evaluate(name, seed):
    """Return, mean timing error and synchrony of a policy; all policies meet the same people in one performance.

    Errors are limited as in the reward, which cannot rank policies that are seconds late.
    """
    method = {"method": name} if name in ("sia", "eca") else {}
    policy = {"oracle": Oracle, "idle": stand_still}.get(name, repeat_move)
    env = gym.make("sjasim/Dance-v0", iterations=3, performance="one", disable_env_checker=True, **method)
    total, rows = run_episode(env, policy, seed=seed)
    errors_s = np.minimum(np.abs([row["event_errors_s"] for row in rows]), RewardConfig().worst_s)
    mean_error_s = np.nanmean(errors_s) if np.isfinite(errors_s).any() else np.inf
    return total, mean_error_s, np.mean([row["gsi_full_edges"] for row in rows])


@pytest.mark.slow
@pytest.mark.parametrize("seed", SEEDS)
def test_the_return_ranks_policies_as_timing_appropriateness_and_synchrony_do(seed):
    """An oracle earns most, a robot that stands earns least, and between them the smaller error earns more."""
    rows = {name: evaluate(name, seed) for name in ("oracle", "sia", "eca", "idle")}
    for (one, first), (other, second) in itertools.combinations(rows.items(), 2):
        if abs(first[1] - second[1]) > EQUAL_S:
            assert (first[0] > second[0]) == (first[1] < second[1]), (one, other)
    by_return = sorted(rows, key=lambda name: -rows[name][0])
    assert (by_return[0], by_return[-1]) == ("oracle", "idle")
    assert rows["oracle"][2] > max(rows[name][2] for name in ("sia", "eca"))
