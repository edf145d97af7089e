"""Arranges event tables for a fit: which events belong together, and how late each dancer was."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ...anticipation.timing_appropriateness import match_to_steps
from ...choreography.score import Choreography
from ...choreography.timetable import Timetable
from ...config.session import MAX_DANCERS
from ...core import ROBOT, Array, Kind
from ...core.session_log import TableEvent, natural_order
from .free_time import (
    DancersEvents,
    FreeTrial,
    cluster_trial,
    find_pacers,
    late_at_steady_tempo,
    late_behind_group,
    late_behind_score,
    looseness_warnings,
)
from .tapping_trials import FitError, TappingTrials

FARTHEST_MEDIAN_S = 2.0
"""Median distance of the events from the score beyond which a table's times are not on the dance's clock [s]."""

Trials = dict[tuple[str, int], dict[str, list[TableEvent]]]
"""(session, iteration) -> dancer -> events."""


def arrange_trials(events: Sequence[TableEvent], timetable: Timetable | None, steady: bool = False) -> TappingTrials:
    """Arrange the dancers' events by the steps of the dance or, without music, by closeness in time.

    Early events and the robot's are left out, and so are dancers' turns if the dance is known, since they follow the
    clap. With a timetable, every event goes to the nearest step of its kind. Without one, events of a kind belong
    together if they are of different dancers and lie within half of the usual interval between two events of one
    dancer.

    Args:
        events: rows of one table.
        timetable: timetable of the dance if people kept to its music, else None.
        steady: whether people without music kept a steady tempo in each iteration.

    Raises:
        FitError: sessions have different numbers of dancers, or not 2 to `MAX_DANCERS`; or times are not on the dance's
            clock; or, without music, the dancers' tempi differ too much or are not steady.
    """
    groups = _group_by_trial(events, timetable)
    casts = _casts(groups)
    sessions = sorted({session for session, _ in groups})
    agents = _agents(casts)
    if timetable is None:
        free = [cluster_trial(trial, casts[session]) for (session, _), trial in groups.items()]
        arranged = _without_music(free, agents, steady)
    else:
        late_s = [
            _late_behind_music(trial, casts[session], timetable, iteration)
            for (session, iteration), trial in groups.items()
        ]
        _check_clock(np.concatenate(late_s))
        arranged = TappingTrials(agents, _padded(late_s), np.zeros(len(late_s), int), "music")

    event_count = sum(len(own) for trial in groups.values() for own in trial.values())
    return replace(
        arranged,
        session=np.array([sessions.index(session) for session, _ in groups]),
        phrases=() if timetable is None else phrases(timetable.choreography),
        unused=event_count - int(np.isfinite(arranged.late_s).sum()),
    )


def arrange_times(times_s: Sequence[Array], agents: Sequence[str], *, steady: bool = False) -> TappingTrials:
    """Arrange event times without music that are matched already, such as the onsets of the same notes.

    Each trial counts as a session of its own.

    Args:
        times_s: (E, D) times of each trial's events [s], in order; NaN where a dancer has no event.
        agents: names of the D dancers.
        steady: whether the tempo of each trial is steady, so that the events are one period apart.

    Raises:
        FitError: the tempo is not steady.
    """
    free = [FreeTrial(tuple((Kind.CLAP, k) for k in range(len(own))), np.asarray(own), 0.0) for own in times_s]
    return replace(_without_music(free, tuple(agents), steady), session=np.arange(len(free)))


def _without_music(free: Sequence[FreeTrial], agents: tuple[str, ...], steady: bool) -> TappingTrials:
    """Trials of people without music, all of them of one session."""
    pacers = find_pacers(free)
    behind_score = None if steady else late_behind_score(free)
    if steady:
        late_s = [late_at_steady_tempo(trial) for trial in free]
    elif behind_score is not None:
        late_s = behind_score
    else:
        late_s = [late_behind_group(trial) for trial in free]

    return TappingTrials(
        agents=agents,
        late_s=_padded(late_s),
        session=np.zeros(len(free), int),
        time="steady" if steady else "free",
        pacers=pacers,
        expects_time=steady or behind_score is not None,
        warnings=looseness_warnings(free),
    )


def concatenate_trials(parts: Sequence[TappingTrials]) -> TappingTrials:
    """Concatenate the trials of several tables; their sessions count as different ones.

    Args:
        parts: trials of groups of the same size in the same dance.

    Raises:
        FitError: the groups have different sizes, or danced different dances.
    """
    sizes = {len(part.agents) for part in parts}
    if len(sizes) > 1:
        raise FitError(f"the tables are of groups of {', '.join(map(str, sorted(sizes)))} dancers: fit them one by one")
    if len({part.pacers for part in parts}) > 1:
        raise FitError("a dancer keeps exact time in some tables and not in others: fit them one by one")
    if len({part.phrases for part in parts}) > 1:
        raise FitError("the tables are of different dances: fit them one by one")

    sessions = []
    first_session = 0
    for part in parts:
        sessions.append(part.session + first_session)
        first_session += int(part.session.max()) + 1

    return replace(
        parts[0],
        late_s=_padded([late_s for part in parts for late_s in part.late_s]),
        session=np.concatenate(sessions),
        expects_time=all(part.expects_time for part in parts),
        unused=sum(part.unused for part in parts),
        warnings=tuple(dict.fromkeys(text for part in parts for text in part.warnings)),
    )


def phrases(choreography: Choreography) -> tuple[tuple[int, ...], ...]:
    """Event indices of each phrase, which people omit as a whole: forward and backward together, or a clap."""
    found: list[list[int]] = []
    for step in choreography.steps():
        if step.kind in (Kind.START_FORWARD, Kind.CLAP) or not found:
            found.append([])
        found[-1].append(step.ordinal)
    return tuple(tuple(phrase) for phrase in found)


def _group_by_trial(events: Sequence[TableEvent], timetable: Timetable | None) -> Trials:
    """The events that count, by session and iteration, then by dancer."""
    trials: Trials = defaultdict(lambda: defaultdict(list))
    for event in events:
        follows_clap = event.kind is Kind.TURN and timetable is not None
        if event.agent != ROBOT and not event.early and not follows_clap:
            trials[event.session, event.iteration][event.agent].append(event)
    return trials


def _casts(trials: Trials) -> dict[str, list[str]]:
    """Session -> its dancers. A dancer who is absent from a session counts if all sessions have the same dancers."""
    found: dict[str, set[str]] = defaultdict(set)
    for (session, _), trial in trials.items():
        found[session] |= trial.keys()

    # If one session has everybody, dancers of the other sessions are the same people with absences.
    everybody = set().union(*found.values())
    largest = max((len(cast) for cast in found.values()), default=0)
    if len(everybody) == largest:
        found = dict.fromkeys(found, everybody)

    sizes = {len(cast): session for session, cast in found.items()}
    if len(sizes) > 1:
        sizes_text = ", ".join(f"{session!r} has {size}" for size, session in sizes.items())
        raise FitError(f"sessions must have as many dancers each: {sizes_text}")
    if not 2 <= largest <= MAX_DANCERS:
        raise FitError(f"a group of 2 to {MAX_DANCERS} dancers is needed, not of {largest}")
    return {session: sorted(cast, key=natural_order) for session, cast in found.items()}


def _agents(casts: Mapping[str, list[str]]) -> tuple[str, ...]:
    """The dancers' names, or numbered places if sessions have different dancers."""
    names = {tuple(cast) for cast in casts.values()}
    if len(names) == 1:
        return names.pop()
    return tuple(f"place {k + 1}" for k in range(len(next(iter(names)))))


def _late_behind_music(trial: DancersEvents, cast: Sequence[str], table: Timetable, iteration: int) -> Array:
    """(E, D) lateness behind the music [s]."""
    steps = table.choreography.steps()
    expected_s = np.array([table.time_s(iteration, step.beat) for step in steps])
    columns = []
    for agent in cast:
        own = trial.get(agent, ())
        times_s = [event.t_s for event in own]
        kinds = [event.kind for event in own]
        columns.append(match_to_steps(times_s, kinds, steps, expected_s))
    return np.asarray(np.stack(columns, axis=1) - expected_s[:, None])


def _padded(rows: Sequence[Array]) -> Array:
    """(N, E, D) trials, with NaN after the events of the shorter ones."""
    most_events = max(len(row) for row in rows)
    return np.array([np.pad(row, ((0, most_events - len(row)), (0, 0)), constant_values=np.nan) for row in rows])


def _check_clock(late_s: Array) -> None:
    """Raise `FitError` if the events are too far from the score."""
    median_s = np.nanmedian(np.abs(late_s))
    if not float(median_s) <= FARTHEST_MEDIAN_S:
        raise FitError(
            f"events lie {median_s:.1f} s from the score on average, not within {FARTHEST_MEDIAN_S:g} s: "
            "give the dance's own options (dance.bpm, dance.lead_in_s, ...), or fit in free time"
        )
