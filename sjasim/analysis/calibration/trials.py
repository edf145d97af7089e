"""From event tables to performances that a fit understands: which events belong together, and how late each was."""

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
from .timing_fit import FitError, TappingTrials, mean_seen

FARTHEST_S = 2.0
"""Beyond this median distance from the score a table's times are not on the dance's clock."""

MOST_UNEVEN = 1.25
"""In free time, people whose tempi differ by more than this factor have no events in common (assumed)."""

LOOSEST = 0.12
"""In free time, dancers farther apart than this share of the time between two events may not be together at all: those
who do not hear one another are .14 to .18 apart, groups that couple less than .12 (measured on generated ones)."""

FEWEST_GAPS = 5
"""Fewer times between two events do not make a tempo: a step left out would be taken for another one (assumed)."""

Trials = dict[tuple[str, int], dict[str, list[TableEvent]]]
"""(session, iteration) -> agent -> events."""


def arrange_trials(events: Sequence[TableEvent], timetable: Timetable | None) -> TappingTrials:
    """Arrange the dancers' events by step of the dance or, in free time, by what happened together.

    Early events and the robot's are left aside, and dancers' turns where the dance is known, for they follow the clap.
    With a timetable every event goes to the step of its kind that is nearest; without one, events of a kind belong
    together while they are of different dancers and lie within half of the usual time between two of one dancer's.

    Args:
        events: rows of one table.
        timetable: the dance, if its music was kept to; else None.

    Raises:
        FitError: sessions have different numbers of dancers, or not 2 to 8, or times are off the dance's clock, or
            in free time the dancers' tempi differ too much.
    """
    trials: Trials = defaultdict(lambda: defaultdict(list))
    for event in events:
        aside = event.kind is Kind.TURN and timetable is not None
        if event.agent != ROBOT and not event.early and not aside:
            trials[event.session, event.iteration][event.agent].append(event)
    casts = _casts(trials)
    names = sorted({session for session, _ in trials})
    rows = [
        _free(trial, casts[session]) if timetable is None else _scored(trial, casts[session], timetable, iteration)
        for (session, iteration), trial in trials.items()
    ]
    longest = max(len(row) for row in rows)
    late_s = np.full((len(rows), longest, rows[0].shape[1]), np.nan)
    for place, row in zip(late_s, rows, strict=True):
        place[: len(row)] = row
    if timetable is not None and not float(np.nanmedian(np.abs(late_s))) <= FARTHEST_S:
        raise FitError(
            f"events lie {np.nanmedian(np.abs(late_s)):.1f} s from the score on average, not within {FARTHEST_S:g} s: "
            "give the dance's own options (dance.bpm, dance.lead_in_s, ...), or fit in free time"
        )
    told = sum(len(found) for trial in trials.values() for found in trial.values())
    return TappingTrials(
        agents=_agents(casts),
        late_s=late_s,
        session=np.array([names.index(session) for session, _ in trials]),
        music=timetable is not None,
        phrases=() if timetable is None else phrases(timetable.choreography),
        unused=told - int(np.isfinite(late_s).sum()),
        warnings=_loose(trials, casts) if timetable is None else (),
    )


def concatenate_trials(parts: Sequence[TappingTrials]) -> TappingTrials:
    """TappingTrials of several tables as those of several sessions.

    Raises:
        FitError: they are of groups of different sizes, or of different dances.
    """
    sizes = {len(part.agents) for part in parts}
    if len(sizes) > 1:
        raise FitError(f"the tables are of groups of {', '.join(map(str, sorted(sizes)))} dancers: fit them one by one")
    if len({part.phrases for part in parts}) > 1:
        raise FitError("the tables are of different dances: fit them one by one")
    longest = max(part.late_s.shape[1] for part in parts)
    short = [((0, 0), (0, longest - part.late_s.shape[1]), (0, 0)) for part in parts]
    wide = [np.pad(part.late_s, pad, constant_values=np.nan) for part, pad in zip(parts, short, strict=True)]
    first = np.cumsum([0, *(int(part.session.max()) + 1 for part in parts[:-1])])
    session = np.concatenate([part.session + at for part, at in zip(parts, first, strict=True)])
    late_s = np.concatenate(wide)
    warnings = tuple(dict.fromkeys(doubt for part in parts for doubt in part.warnings))
    return replace(
        parts[0], late_s=late_s, session=session, unused=sum(part.unused for part in parts), warnings=warnings
    )


def phrases(choreography: Choreography) -> tuple[tuple[int, ...], ...]:
    """Events that people leave out together: forward and backward, or a clap."""
    out: list[list[int]] = []
    for step in choreography.steps():
        if step.kind in (Kind.START_FORWARD, Kind.CLAP) or not out:
            out.append([])
        out[-1].append(step.ordinal)
    return tuple(tuple(phrase) for phrase in out)


def _casts(trials: Trials) -> dict[str, list[str]]:
    """Session -> its dancers; a dancer who is absent from one session counts if all sessions share one cast."""
    found: dict[str, set[str]] = defaultdict(set)
    for (session, _), trial in trials.items():
        found[session] |= trial.keys()
    together = set().union(*found.values())
    largest = max((len(cast) for cast in found.values()), default=0)
    if len(together) == largest:
        found = dict.fromkeys(found, together)
    sizes = {len(cast): session for session, cast in found.items()}
    if len(sizes) > 1:
        told = ", ".join(f"{session!r} has {size}" for size, session in sizes.items())
        raise FitError(f"sessions must have as many dancers each: {told}")
    if not 2 <= largest <= MAX_DANCERS:
        raise FitError(f"a group of 2 to {MAX_DANCERS} dancers is needed, not of {largest}")
    return {session: sorted(cast, key=natural_order) for session, cast in found.items()}


def _agents(casts: Mapping[str, list[str]]) -> tuple[str, ...]:
    """The dancers' names, or their places where every session has its own people."""
    names = {tuple(cast) for cast in casts.values()}
    return names.pop() if len(names) == 1 else tuple(f"place {k + 1}" for k in range(len(next(iter(names)))))


def _scored(trial: Mapping[str, Sequence[TableEvent]], cast: Sequence[str], table: Timetable, iteration: int) -> Array:
    """(E, D) lateness behind the music [s]."""
    steps = table.choreography.steps()
    expected = np.array([table.time_s(iteration, step.beat) for step in steps])
    columns = []
    for agent in cast:
        own = trial.get(agent, ())
        columns.append(match_to_steps([event.t_s for event in own], [event.kind for event in own], steps, expected))
    return np.asarray(np.stack(columns, axis=1) - expected[:, None])


def _free(trial: Mapping[str, Sequence[TableEvent]], cast: Sequence[str]) -> Array:
    """(E, D) lateness behind the mean of what happened together [s], in order of time."""
    rows = [row for kind in Kind for row in _clusters(trial, cast, kind)]
    times = np.array(sorted(rows, key=np.nanmean)).reshape(-1, len(cast))
    return np.asarray(times - mean_seen(times, 1)[:, None])


def _usual_gap(trial: Mapping[str, Sequence[TableEvent]], kind: Kind) -> float:
    """Usual time between two events of a kind of one dancer [s]; a tempo must be much the same for all of them."""
    times = {agent: [event.t_s for event in own if event.kind is kind] for agent, own in trial.items()}
    gaps = {agent: float(np.median(np.diff(own))) for agent, own in times.items() if len(own) > 1}
    if not gaps:
        return np.inf
    tempi = {agent: gap for agent, gap in gaps.items() if len(times[agent]) > FEWEST_GAPS}
    slowest, fastest = (extreme(tempi, key=lambda agent: tempi[agent], default="") for extreme in (max, min))
    if tempi and tempi[slowest] > MOST_UNEVEN * tempi[fastest]:
        told = f"every {tempi[fastest]:.2f} s, {slowest}'s every {tempi[slowest]:.2f} s"
        raise FitError(f"{fastest}'s {kind} comes {told}: they do not go together one to one, and are not fitted")
    return float(np.median(list(gaps.values())))


def _clusters(trial: Mapping[str, Sequence[TableEvent]], cast: Sequence[str], kind: Kind) -> list[Array]:
    events = sorted((event for own in trial.values() for event in own if event.kind is kind), key=lambda e: e.t_s)
    window = 0.5 * _usual_gap(trial, kind)
    out: list[Array] = []
    first_s = -np.inf
    for event in events:
        place = cast.index(event.agent)
        if not out or event.t_s - first_s > window or np.isfinite(out[-1][place]):
            out.append(np.full(len(cast), np.nan))
            first_s = event.t_s
        out[-1][place] = event.t_s
    return out


def _loose(trials: Trials, casts: Mapping[str, list[str]]) -> tuple[str, ...]:
    """A doubt if dancers lie so far apart that which events belong together is chance, and coupling with it."""
    apart = []
    for (session, _), trial in trials.items():
        for kind in Kind:
            rows = np.array(_clusters(trial, casts[session], kind)).reshape(-1, len(casts[session]))
            apart.append(((rows - mean_seen(rows, 1)[:, None]) / _usual_gap(trial, kind)).ravel())
    share = float(np.sqrt(mean_seen(np.concatenate(apart) ** 2, 0)))
    if not share > LOOSEST:
        return ()
    told = f"dancers are {share:.2f} of the time between two events apart, not within {LOOSEST:g}"
    return (f"{told}: which events belong together may be chance, and coupling with it",)
