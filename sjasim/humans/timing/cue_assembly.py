"""Cues from event times: what a dancer's moves need besides a time for each event, whatever the timing model."""

from __future__ import annotations

import numpy as np

from ...choreography.score import MOVE_EVENTS
from ...choreography.timetable import Timetable
from ...core import Array, BoolArray, Cue, Move, dancer_name

MIN_MOVE_S = 0.8
"""Shortest move forward or backward [s] (assumed)."""

MIN_HOLD_S = 0.15
"""Shortest hold between two moves [s] (assumed)."""

TURN_AFTER_CLAP_S = 0.25
"""Time from a dancer's clap to its turn [s] (assumed)."""


def shortest_after_s(ordinal: int) -> float:
    """Least time from an event of the score to a dancer's next one [s].

    Starts and stops alternate, so that an even ordinal begins a move and an odd one a hold.

    Args:
        ordinal: number of the event within its iteration.
    """
    return MIN_MOVE_S if ordinal % 2 == 0 else MIN_HOLD_S


def ordered_times_s(planned_s: Array, free_s: Array) -> Array:
    """(D, E) planned event times, delayed so that no move and no hold is shorter than people can make it [s].

    Args:
        planned_s: (D, E) times that dancers plan for the events of an iteration.
        free_s: (D,) earliest time of each dancer's first event.
    """
    times_s = np.array(planned_s, dtype=np.float64)
    earliest_s = np.array(free_s, dtype=np.float64)
    for ordinal in range(times_s.shape[1]):
        times_s[:, ordinal] = np.maximum(times_s[:, ordinal], earliest_s)
        earliest_s = times_s[:, ordinal] + shortest_after_s(ordinal)
    return times_s


def performed_cues(
    timetable: Timetable, iteration: int, times_s: Array, lapses: BoolArray
) -> tuple[tuple[Cue, ...], ...]:
    """Cues of each dancer for a whole iteration, without the moves that a dancer leaves out.

    Args:
        timetable: the dance in session time.
        iteration: index of the iteration.
        times_s: (D, E) ordered times of the events.
        lapses: (D, E) whether a dancer would leave out an event's move; see `performs`.
    """
    moves = range(len(timetable.choreography.moves))
    return tuple(
        tuple(
            move_cue(timetable, iteration, index, dancer, own_s)
            for index in moves
            if performs(timetable, index, lapses[dancer])
        )
        for dancer, own_s in enumerate(times_s)
    )


def performs(timetable: Timetable, index: int, lapses: BoolArray) -> bool:
    """Whether a dancer performs a move: everybody performs the turn, and a lapse at a clap leaves it out.

    Whoever leaves out a move forward leaves out the move backward as well, and so stays on the slot.

    Args:
        timetable: the dance in session time.
        index: index of the move in the score.
        lapses: (E,) the dancer's lapses in the iteration.
    """
    moves = timetable.choreography.moves
    move = moves[index].move
    if move is Move.TURN:
        return True

    if move is Move.BACKWARD:
        earlier = [other for other in range(index) if moves[other].move is Move.FORWARD]
        if not earlier:
            return True
        index = earlier[-1]
    return not lapses[timetable.choreography.first_ordinal(index)]


def move_cue(timetable: Timetable, iteration: int, index: int, dancer: int, times_s: Array) -> Cue:
    """Cue of a dancer for a move of the score.

    Args:
        timetable: the dance in session time.
        iteration: index of the iteration.
        index: index of the move in the score.
        dancer: index of the dancer.
        times_s: (E,) times of the dancer's events, of which those of the move count; a turn follows its clap.
    """
    item = timetable.choreography.moves[index]
    first = timetable.choreography.first_ordinal(index)
    t_s = float(times_s[first])
    duration_s = 0.0

    if item.move is Move.TURN:
        end_s = timetable.time_s(iteration, item.beat + item.beats)
        t_s += TURN_AFTER_CLAP_S
        duration_s = end_s - timetable.time_s(iteration, item.beat)
    elif len(MOVE_EVENTS[item.move]) == 2:
        duration_s = float(times_s[first + 1]) - t_s

    return Cue(dancer_name(dancer), item.move, iteration, first, item.beat, t_s, duration_s)
