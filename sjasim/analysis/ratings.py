"""Ratings of the robot's synchrony by simulated participants, and whether they agree with the measured synchrony.

The study asked each dancer to rate from 1 to 5 how synchronous the robot was with the others, and took for the more
synchronous session of a group the one on which two of three dancers agreed. In 7 of 9 groups that was the session with
the higher group synchronisation index.

How people came to their ratings is not published, and neither is their spread. This model states one way, and every
number in it is assumed:

- A dancer compares each event of the robot with its own nearest event of the same kind, with perceptual noise, and
  finds it in time or not. A step that the robot misses is not in time.
- The impression of a session is the share of steps in time, with noise of memory.
- The rating divides impressions from 0 to 1 into five equal parts. Of two sessions with the same rating, a dancer calls
  that one more synchronous of which the impression is better, since the questionnaire asked for one of them.

Source: iqbal2016, sections V and VI (the questionnaire and its result).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields

import numpy as np

from ..core import Array, BoolArray, IntArray, Kind
from ..core.clock import stream
from ..core.errors import ConfigError
from .study_tables import Columns, StudyTables

HIGHEST_RATING = 5
"""Best rating; the worst is 1. Source: iqbal2016."""


@dataclass(frozen=True, slots=True)
class Perception:
    """How dancers perceive the robot's timing; all values are assumed.

    Attributes:
        window_s: largest perceived distance of the robot's event from the dancer's own that is in time [s]; the window
            of the synchrony index.
        noise_s: standard deviation of the perceived distance [s].
        memory_noise: standard deviation of the impression of a session, as a share of its steps.
    """

    window_s: float = 0.25
    noise_s: float = 0.10
    memory_noise: float = 0.05

    def __post_init__(self) -> None:
        for item in fields(self):
            value = getattr(self, item.name)
            if not 0.0 <= value <= 10.0:
                raise ConfigError(f"perception.{item.name}", value, "a number from 0 to 10")


@dataclass(frozen=True, slots=True)
class GroupRating:
    """What one group rated, and what was measured.

    Attributes:
        study: replication of the study.
        group: the group.
        ratings: condition -> rating of each dancer.
        rated: condition that most dancers call more synchronous; "" if no majority agrees.
        measured: condition with the higher group synchronisation index; "" if they are equal.
    """

    study: int
    group: int
    ratings: Mapping[str, tuple[int, ...]]
    rated: str
    measured: str

    @property
    def matches(self) -> bool:
        """Whether the group's rating is the measured one; an undecided group does not match."""
        return self.rated != "" and self.rated == self.measured


def group_ratings(
    tables: StudyTables, conditions: tuple[str, str], perception: Perception | None = None, seed: int = 0
) -> list[GroupRating]:
    """Simulate the ratings of every group that danced both conditions.

    Args:
        tables: the study, with its events.
        conditions: names of the two conditions with a robot that dancers compare.
        perception: how they perceive; None for the default.
        seed: seed of the perceptual noise, which is a stream of its own for each study and group.

    Raises:
        ConfigError: the study has kept no events, or no group danced both conditions.
    """
    perception = perception or Perception()
    if len(tables.events["session"]) == 0:
        raise ConfigError("events", 0, "a study that has kept its events; ratings need them")

    sessions = _sessions_by_group(tables, conditions)
    if not sessions:
        raise ConfigError("conditions", conditions, "two conditions that one group danced")

    events = _events_by_session(tables)
    missed = np.asarray(tables.sessions["robot_missed"], dtype=np.int64).tolist()
    found = []
    for (study, group), pair in sorted(sessions.items()):
        rng = stream(seed, "ratings", str(study), str(group))
        pair_events = [events[tables.sessions["session"][row]] for row in pair]
        # A dancer of whom no event was detected in one of the sessions rates it all the same.
        dancers = max(int(np.max(session["agent"], initial=0)) for session in pair_events)
        impressions = [
            impressions_of(session, missed[row], perception, rng, dancers)
            for session, row in zip(pair_events, pair, strict=True)
        ]
        gsi = [float(tables.sessions["gsi"][row]) for row in pair]
        found.append(
            GroupRating(
                study=study,
                group=group,
                ratings={name: _ratings(own) for name, own in zip(conditions, impressions, strict=True)},
                rated=_majority(impressions[0], impressions[1], conditions),
                measured=_larger(gsi[0], gsi[1], conditions),
            )
        )
    return found


def rating_figures(tables: StudyTables, conditions: Sequence[str], seed: int = 0) -> dict[str, object] | None:
    """Simulated ratings of a study: each group's, and in how many groups they match the measured synchrony.

    Args:
        tables: one study.
        conditions: conditions with a robot, of which the first two are compared.
        seed: seed of the perceptual noise.

    Returns:
        ``conditions``, ``matches`` and ``groups``; ``by_group`` with the ratings of each dancer and the sessions that
        are ``rated`` and ``measured`` as more synchronous. None without events, or without a group that danced two
        conditions.
    """
    if len(conditions) < 2 or len(tables.events["session"]) == 0:
        return None

    pair = (conditions[0], conditions[1])
    if not _sessions_by_group(tables, pair):
        return None
    ratings = group_ratings(tables, pair, seed=seed)
    return {
        "conditions": list(pair),
        "matches": sum(rating.matches for rating in ratings),
        "groups": len(ratings),
        "by_group": [
            {
                "study": rating.study,
                "group": rating.group,
                "ratings": {name: list(own) for name, own in rating.ratings.items()},
                "rated": rating.rated,
                "measured": rating.measured,
            }
            for rating in ratings
        ],
    }


def impressions_of(
    events: Columns, missed: int, perception: Perception, rng: np.random.Generator, dancers: int = 3
) -> Array:
    """(D,) impression of each dancer of one session: the share of the robot's steps that were in time, 0 to 1.

    Args:
        events: events of the session, as in the table ``events``.
        missed: number of steps that the robot missed.
        perception: how the dancers perceive.
        rng: generator of their noise.
        dancers: number of dancers D; one without an event perceives no step in time.
    """
    agents = np.asarray(events["agent"])
    # The robot turns where the dancers clap.
    kinds = np.where(events["kind"] == str(Kind.TURN), str(Kind.CLAP), events["kind"])
    iterations = np.asarray(events["iteration"], dtype=np.int64)
    labels = 100 * iterations + np.unique(kinds.astype(str), return_inverse=True)[1]
    times_s = np.asarray(events["t_s"], dtype=np.float64)
    of_robot = agents == 0

    steps = int(of_robot.sum()) + missed
    shares = []
    for dancer in range(1, dancers + 1):
        errors_s = _nearest_errors_s(labels, times_s, of_robot, agents == dancer)
        # Noise is symmetric, so that it does not matter which of the two was earlier.
        perceived_s = errors_s + perception.noise_s * rng.standard_normal(len(errors_s))
        in_time = int((np.abs(perceived_s) < perception.window_s).sum())
        share = in_time / steps if steps else 0.0
        shares.append(share + perception.memory_noise * rng.standard_normal())
    return np.asarray(np.clip(shares, 0.0, 1.0), dtype=np.float64)


def _nearest_errors_s(labels: IntArray, times_s: Array, of_robot: BoolArray, of_dancer: BoolArray) -> Array:
    """(N,) distance of the robot's events from the dancer's nearest of the same label; infinite without one [s].

    Args:
        labels: (E,) number of each event's iteration and kind.
        times_s: (E,) times.
        of_robot: (E,) which events are the robot's, N in all.
        of_dancer: (E,) which events are the dancer's.
    """
    apart_s = np.abs(times_s[of_robot, None] - times_s[of_dancer])
    apart_s[labels[of_robot, None] != labels[of_dancer]] = np.inf
    return np.asarray(apart_s.min(axis=1, initial=np.inf))


def _sessions_by_group(tables: StudyTables, conditions: tuple[str, str]) -> dict[tuple[int, int], tuple[int, int]]:
    """(study, group) -> rows of the first session of each condition, for groups that danced both.

    A session that failed has no index, and counts as not danced.
    """
    columns = (tables.sessions[name] for name in ("study", "group", "condition", "gsi"))
    first: dict[tuple[int, int], dict[str, int]] = {}
    for row, (study, group, condition, gsi) in enumerate(zip(*columns, strict=True)):
        if not np.isfinite(gsi):
            continue
        first.setdefault((int(study), int(group)), {}).setdefault(str(condition), row)
    return {
        key: (own[conditions[0]], own[conditions[1]])
        for key, own in first.items()
        if conditions[0] in own and conditions[1] in own
    }


def _events_by_session(tables: StudyTables) -> dict[int, Columns]:
    """Session -> its events, also for sessions without any."""
    # One sort instead of a search of the whole table for each session.
    numbers = np.asarray(tables.events["session"], dtype=np.int64)
    order = np.argsort(numbers, kind="stable")
    sessions = np.asarray(tables.sessions["session"], dtype=np.int64)
    starts = np.searchsorted(numbers[order], sessions, side="left")
    ends = np.searchsorted(numbers[order], sessions, side="right")
    return {
        int(session): {name: column[order[start:end]] for name, column in tables.events.items()}
        for session, start, end in zip(sessions, starts, ends, strict=True)
    }


def _ratings(impressions: Array) -> tuple[int, ...]:
    """Rating of each dancer from 1 to `HIGHEST_RATING`."""
    return tuple(int(rating) for rating in 1 + np.minimum(HIGHEST_RATING * impressions, HIGHEST_RATING - 1).astype(int))


def _majority(first: Array, second: Array, conditions: tuple[str, str]) -> str:
    """The condition that more than half of the dancers call more synchronous; "" if there is none."""
    # A better rating is always a better impression, so that impressions decide equal ratings and agree with others.
    votes = int((first > second).sum()), int((second > first).sum())
    if max(votes) * 2 <= len(first):
        return ""
    return conditions[int(votes[1] > votes[0])]


def _larger(first: float, second: float, conditions: tuple[str, str]) -> str:
    """The condition with the larger value; "" if they are equal or one is missing."""
    if first == second or np.isnan(first) or np.isnan(second):
        return ""
    return conditions[int(second > first)]
