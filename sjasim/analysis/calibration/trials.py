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
from .tapping_trials import FitError, TappingTrials, finite_mean

FARTHEST_MEDIAN_S = 2.0
"""Median distance of the events from the score beyond which a table's times are not on the dance's clock [s]."""

LARGEST_TEMPO_RATIO = 1.25
"""In free time, ratio of two dancers' tempi beyond which their events do not correspond one to one (assumed)."""

LOOSEST_SHARE = 0.12
"""In free time, distance of dancers, over the time between two events, beyond which they may not be together at all.

Dancers who do not hear one another are 0.14 to 0.18 apart, groups with weak coupling less than 0.12 (measured on
simulated groups).
"""

FEWEST_INTERVALS = 5
"""Fewest intervals between a dancer's events that give a tempo (assumed).

With fewer intervals, one omitted step would look like another tempo.
"""

DancersEvents = Mapping[str, Sequence[TableEvent]]
"""Dancer -> events of one trial."""

Trials = dict[tuple[str, int], dict[str, list[TableEvent]]]
"""(session, iteration) -> dancer -> events."""


def arrange_trials(events: Sequence[TableEvent], timetable: Timetable | None) -> TappingTrials:
    """Arrange the dancers' events by the steps of the dance or, in free time, by closeness in time.

    Early events and the robot's are left out, and so are dancers' turns if the dance is known, since they follow the
    clap. With a timetable, every event goes to the nearest step of its kind. Without one, events of a kind belong
    together if they are of different dancers and lie within half of the usual interval between two events of one
    dancer.

    Args:
        events: rows of one table.
        timetable: timetable of the dance if people kept to its music, else None.

    Raises:
        FitError: sessions have different numbers of dancers, or not 2 to `MAX_DANCERS`; or times are not on the dance's
            clock; or, in free time, the dancers' tempi differ too much.
    """
    trials = _group_by_trial(events, timetable)
    casts = _casts(trials)
    sessions = sorted({session for session, _ in trials})
    rows = [
        _late_in_free_time(trial, casts[session])
        if timetable is None
        else _late_behind_music(trial, casts[session], timetable, iteration)
        for (session, iteration), trial in trials.items()
    ]

    most_events = max(len(row) for row in rows)
    late_s = np.full((len(rows), most_events, rows[0].shape[1]), np.nan)
    for target, row in zip(late_s, rows, strict=True):
        target[: len(row)] = row
    if timetable is not None:
        _check_clock(late_s)

    event_count = sum(len(own) for trial in trials.values() for own in trial.values())
    return TappingTrials(
        agents=_agents(casts),
        late_s=late_s,
        session=np.array([sessions.index(session) for session, _ in trials]),
        music=timetable is not None,
        phrases=() if timetable is None else phrases(timetable.choreography),
        unused=event_count - int(np.isfinite(late_s).sum()),
        warnings=_looseness_warnings(trials, casts) if timetable is None else (),
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
    if len({part.phrases for part in parts}) > 1:
        raise FitError("the tables are of different dances: fit them one by one")

    most_events = max(part.late_s.shape[1] for part in parts)
    padded = []
    sessions = []
    first_session = 0
    for part in parts:
        missing = most_events - part.late_s.shape[1]
        padded.append(np.pad(part.late_s, ((0, 0), (0, missing), (0, 0)), constant_values=np.nan))
        sessions.append(part.session + first_session)
        first_session += int(part.session.max()) + 1

    return replace(
        parts[0],
        late_s=np.concatenate(padded),
        session=np.concatenate(sessions),
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


def _late_in_free_time(trial: DancersEvents, cast: Sequence[str]) -> Array:
    """(E, D) lateness behind the mean of the events that belong together [s], in order of time."""
    rows = [row for kind in Kind for row in _clusters(trial, cast, kind)]
    times_s = np.array(sorted(rows, key=np.nanmean)).reshape(-1, len(cast))
    return np.asarray(times_s - finite_mean(times_s, 1)[:, None])


def _check_clock(late_s: Array) -> None:
    """Raise `FitError` if the events are too far from the score."""
    median_s = np.nanmedian(np.abs(late_s))
    if not float(median_s) <= FARTHEST_MEDIAN_S:
        raise FitError(
            f"events lie {median_s:.1f} s from the score on average, not within {FARTHEST_MEDIAN_S:g} s: "
            "give the dance's own options (dance.bpm, dance.lead_in_s, ...), or fit in free time"
        )


def _usual_interval_s(trial: DancersEvents, kind: Kind) -> float:
    """Usual time between two events of a kind of one dancer [s]; infinite if no dancer has two.

    Raises:
        FitError: the dancers' tempi differ by more than `LARGEST_TEMPO_RATIO`.
    """
    times = {agent: [event.t_s for event in own if event.kind is kind] for agent, own in trial.items()}
    intervals = {agent: float(np.median(np.diff(own))) for agent, own in times.items() if len(own) > 1}
    if not intervals:
        return np.inf

    reliable = {agent: interval for agent, interval in intervals.items() if len(times[agent]) > FEWEST_INTERVALS}
    if reliable:
        slowest = max(reliable, key=lambda agent: reliable[agent])
        fastest = min(reliable, key=lambda agent: reliable[agent])
        if reliable[slowest] > LARGEST_TEMPO_RATIO * reliable[fastest]:
            tempi = f"every {reliable[fastest]:.2f} s, {slowest}'s every {reliable[slowest]:.2f} s"
            raise FitError(f"{fastest}'s {kind} comes {tempi}: they do not correspond one to one, and are not fitted")

    return float(np.median(list(intervals.values())))


def _clusters(trial: DancersEvents, cast: Sequence[str], kind: Kind) -> list[Array]:
    """(D,) times of the events of a kind that belong together [s], for each such cluster; NaN for an absent dancer."""
    events = sorted((event for own in trial.values() for event in own if event.kind is kind), key=lambda e: e.t_s)
    window_s = 0.5 * _usual_interval_s(trial, kind)

    clusters: list[Array] = []
    first_s = -np.inf
    for event in events:
        column = cast.index(event.agent)
        if not clusters or event.t_s - first_s > window_s or np.isfinite(clusters[-1][column]):
            clusters.append(np.full(len(cast), np.nan))
            first_s = event.t_s
        clusters[-1][column] = event.t_s
    return clusters


def _looseness_warnings(trials: Trials, casts: Mapping[str, list[str]]) -> tuple[str, ...]:
    """A warning if dancers are so far apart that the assignment of events, and with it the coupling, may be chance."""
    distances = []
    for (session, _), trial in trials.items():
        for kind in Kind:
            times_s = np.array(_clusters(trial, casts[session], kind)).reshape(-1, len(casts[session]))
            distances.append(((times_s - finite_mean(times_s, 1)[:, None]) / _usual_interval_s(trial, kind)).ravel())

    share = float(np.sqrt(finite_mean(np.concatenate(distances) ** 2, 0)))
    if not share > LOOSEST_SHARE:
        return ()
    distance = f"dancers are {share:.2f} of the time between two events apart, not within {LOOSEST_SHARE:g}"
    return (f"{distance}: which events belong together may be chance, and coupling with it",)
