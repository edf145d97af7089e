"""Ratings of simulated participants: perception, votes, and agreement with the measured synchrony."""

from __future__ import annotations

import numpy as np
import pytest

from sjasim.analysis.ratings import Perception, _majority, group_ratings, impressions_of, rating_figures
from sjasim.analysis.study_summary import study_summary
from sjasim.analysis.study_tables import StudyTables
from sjasim.core.errors import ConfigError

from .synthetic_study import as_tables, iteration_row, nested_study, paper_table, session_row

EXACT = Perception(noise_s=0.0, memory_noise=0.0)
METHODS = ("eca", "sia")


def study_of(late_s: dict[str, tuple[float, float, float]], gsi=(0.4, 0.5), missed=0) -> StudyTables:
    """One group; the robot claps at each condition by these times after the three dancers, who clap 0.3 s apart."""
    rows = {"sessions": [], "iterations": [], "events": []}
    for number, (method, own) in enumerate(late_s.items()):
        rows["sessions"].append(session_row(number, 0, 1, number + 1, method, gsi[number], missed=missed))
        rows["iterations"].append(iteration_row(number, 1, gsi[number], missed=missed))
        for index, late in enumerate(own):
            for dancer in (1, 2, 3):
                rows["events"].append((number, 1, dancer, "clap", 10.0 * index + 0.3 * (dancer - 2)))
            rows["events"].append((number, 1, 0, "turn", 10.0 * index + late))
    return as_tables(rows)


def first_session(tables):
    """Events of session 0."""
    own = tables.events["session"] == 0
    return {name: column[own] for name, column in tables.events.items()}


def test_the_impression_is_the_share_of_steps_in_time_with_the_dancer_itself():
    tables = study_of({"eca": (0.0, 0.2, 0.9), "sia": (0.0, 0.0, 0.0)})
    found = impressions_of(first_session(tables), 0, EXACT, np.random.default_rng(0))
    # Dancer 1 claps .3 s early, dancer 3 .3 s late; the robot is within .25 s of dancer 3 once.
    assert found == pytest.approx([0.0, 2 / 3, 1 / 3])


def test_steps_that_the_robot_missed_are_not_in_time():
    tables = study_of({"eca": (0.0, 0.0, 0.0), "sia": (0.0, 0.0, 0.0)}, missed=3)
    assert impressions_of(first_session(tables), 3, EXACT, np.random.default_rng(0))[1] == pytest.approx(0.5)
    assert group_ratings(tables, METHODS, EXACT)[0].ratings["eca"] == (1, 3, 1)


def test_a_dancer_without_a_detected_event_perceives_nothing_in_time():
    tables = study_of({"eca": (0.0, 0.2, 0.9), "sia": (0.0, 0.0, 0.0)})
    kept = ~((tables.events["session"] == 1) & (tables.events["agent"] == 3))
    events = {name: column[kept] for name, column in tables.events.items()}
    (rating,) = group_ratings(StudyTables(tables.sessions, tables.iterations, tables.steps, events), METHODS, EXACT)
    assert rating.ratings == {"eca": (1, 4, 2), "sia": (1, 5, 1)}


def test_two_of_three_dancers_decide_and_ratings_are_from_1_to_5():
    tables = study_of({"eca": (0.0, 0.2, 0.9), "sia": (0.3, 0.3, -0.3)})
    rating = group_ratings(tables, METHODS, EXACT)[0]
    assert rating.ratings == {"eca": (1, 4, 2), "sia": (2, 1, 4)}
    assert (rating.rated, rating.measured, rating.matches) == ("sia", "sia", True)
    reverse = group_ratings(study_of({"eca": (0.0, 0.2, 0.9), "sia": (0.3, 0.3, -0.3)}, gsi=(0.5, 0.4)), METHODS, EXACT)
    assert not reverse[0].matches


def test_without_a_majority_or_a_difference_nothing_matches():
    same = group_ratings(study_of({"eca": (0.0, 0.1, 0.2), "sia": (0.0, 0.1, 0.2)}), METHODS, EXACT)[0]
    assert (same.rated, same.matches) == ("", False)
    equal = group_ratings(study_of({"eca": (0.9, 0.9, 0.9), "sia": (0.0,) * 3}, gsi=(0.4, 0.4)), METHODS, EXACT)[0]
    assert (equal.rated, equal.measured, equal.matches) == ("", "", False)


def test_half_of_the_dancers_are_no_majority():
    assert _majority(np.array([0.4, 0.6]), np.array([0.6, 0.4]), METHODS) == ""
    assert _majority(np.array([0.4, 0.6, 0.5]), np.array([0.6, 0.4, 0.6]), METHODS) == "sia"
    assert _majority(np.array([0.4, 0.6, 0.5]), np.array([0.6, 0.4, 0.5]), METHODS) == ""


def test_perfect_timing_is_rated_5_and_none_1():
    tables = study_of({"eca": (0.0, 0.0, 0.0), "sia": (3.0, 3.0, 3.0)})
    rating = group_ratings(tables, METHODS, Perception(window_s=0.5, noise_s=0.0, memory_noise=0.0))[0]
    assert rating.ratings == {"eca": (5, 5, 5), "sia": (1, 1, 1)}


def test_people_who_perceive_well_call_the_better_timed_session_more_synchronous():
    tables = nested_study(np.random.default_rng(2), groups=60, effect_s=1.0)
    share = {
        name: np.mean([rating.rated == "eca" for rating in group_ratings(tables, METHODS, perception)])
        for name, perception in (("sharp", Perception(noise_s=0.02)), ("blind", Perception(memory_noise=10.0)))
    }
    assert share["sharp"] > 0.9
    # Impressions are cut at 0 and 1, so that blind people often are undecided.
    assert share["blind"] < 0.6


def test_ratings_depend_on_the_seed_alone():
    tables = nested_study(np.random.default_rng(3), groups=6)
    assert group_ratings(tables, METHODS) == group_ratings(tables, METHODS)
    assert group_ratings(tables, METHODS) != group_ratings(tables, METHODS, seed=1)


def test_figures_of_a_study_count_the_groups_that_match():
    tables = nested_study(np.random.default_rng(4), groups=7)
    figures = rating_figures(tables, METHODS)
    ratings = group_ratings(tables, METHODS)
    assert (figures["matches"], figures["groups"]) == (sum(rating.matches for rating in ratings), 7)
    assert [row["rated"] for row in figures["by_group"]] == [rating.rated for rating in ratings]
    assert all(1 <= rating <= 5 for row in figures["by_group"] for own in row["ratings"].values() for rating in own)
    assert study_summary(tables)["ratings"] == figures
    assert rating_figures(tables, ("sia",)) is None
    assert rating_figures(paper_table(), METHODS) is None


def test_studies_without_events_or_conditions_are_refused():
    with pytest.raises(ConfigError, match="kept its events"):
        group_ratings(paper_table(), METHODS)
    with pytest.raises(ConfigError, match="two conditions that one group danced"):
        group_ratings(nested_study(np.random.default_rng(0), groups=2), ("eca", "none"))
    with pytest.raises(ConfigError, match=r"perception\.noise_s"):
        Perception(noise_s=-1.0)
