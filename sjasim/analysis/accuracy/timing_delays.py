"""Delays of detection and execution behind the dancers' plans, for the event-level world, measured in physics.

`detection_accuracy` compares logged events with what bodies truly did. This module compares them with what the dancers
planned, because the event-level world knows plans only: its delays contain the error of the motion as well.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...choreography.timetable import timetable
from ...config import SessionConfig
from ...config.toml_file import from_plain
from ...core import Array, Event, Kind, dancer_name
from ...core.session_log import SessionLog
from ..component_quality import execution_delays, mean_delay_s
from ..event_matching import match_times

MATCH_WITHIN_S = 0.8
"""Largest distance between a logged event and the planned one that it is matched with [s]."""

QUANTILE_COUNT = 21
"""Number of quantiles with which a distribution is described, the smallest and the largest value included."""

START_OF = {Kind.STOP_FORWARD: Kind.START_FORWARD, Kind.STOP_BACKWARD: Kind.START_BACKWARD}
"""Stop of a move -> its start."""

DIGITS = 4
"""Decimals of the delays [s]."""


@dataclass(frozen=True, slots=True)
class DelayObservation:
    """One event that should have been logged, one false event, or one command to the robot.

    Attributes:
        table: ``regular``, ``early`` or ``robot``.
        kind: kind of the event.
        delay_s: delay behind the plan, or behind the arrival of the command [s]; NaN if the event is missing.
        is_false: whether this is an event without a plan.
    """

    table: str
    kind: Kind
    delay_s: float
    is_false: bool = False


def delay_observations(log: SessionLog) -> list[DelayObservation]:
    """Observations of one session of the physics.

    A stop is observed only if the start of its move was logged, and an early stop only if the dancer has made such a
    move before in full, because detectors need its duration.
    """
    config = from_plain(log.config)
    found: list[DelayObservation] = []
    for index in range(config.dancers):
        found += _of_dancer(log, dancer_name(index))

    network_s = mean_delay_s(config.network) - config.network.uplink_asymmetry_s
    for kind, delay_s in execution_delays(log.commands, log.robot_events, timetable(config)):
        found.append(DelayObservation("robot", kind, delay_s - network_s))
    return found


def delay_table(observations: Iterable[DelayObservation], minutes: float) -> dict[str, dict[str, Any]]:
    """Statistics of some observations: table -> kind -> ``missed``, ``delay_s`` and ``false_per_minute``.

    Args:
        observations: observations of sessions with the same sensing and layout.
        minutes: observed time, summed over dancers [min].
    """
    groups: dict[tuple[str, str], list[DelayObservation]] = {}
    for item in observations:
        groups.setdefault((item.table, item.kind.value), []).append(item)

    found: dict[str, dict[str, Any]] = {}
    for table, kind in sorted(groups):
        members = groups[table, kind]
        delay_s = np.array([item.delay_s for item in members if not item.is_false])
        logged = delay_s[np.isfinite(delay_s)]
        if not len(logged):
            continue

        row: dict[str, Any] = {
            "n": len(delay_s),
            "missed": round(1.0 - len(logged) / len(delay_s), DIGITS),
            "delay_s": np.quantile(logged, np.linspace(0.0, 1.0, QUANTILE_COUNT)).round(DIGITS).tolist(),
        }
        if table != "robot":
            row["false_per_minute"] = round(sum(item.is_false for item in members) / minutes, DIGITS)
        found.setdefault(table, {})[kind] = row
    return found


def statistics_tables(logs: Sequence[tuple[SessionConfig, Sequence[DelayObservation], float]]) -> dict[str, Any]:
    """Content of a file of timing statistics: sensing -> layout -> tables of `delay_table`, and the robot's.

    Args:
        logs: configuration, observations and simulated time [s] of each session.
    """
    places = sorted({(config.sensing, config.layout) for config, _, _ in logs})
    content: dict[str, Any] = {}
    for sensing, layout in places:
        own = [item for item in logs if (item[0].sensing, item[0].layout) == (sensing, layout)]
        minutes = sum(config.dancers * sim_s for config, _, sim_s in own) / 60.0
        sensed = (item for _, observations, _ in own for item in observations if item.table != "robot")
        content.setdefault(sensing, {})[layout] = delay_table(sensed, minutes)

    executed = [item for _, observations, _ in logs for item in observations if item.table == "robot"]
    content["robot"] = delay_table(executed, 1.0).get("robot", {})
    return content


def _of_dancer(log: SessionLog, dancer: str) -> list[DelayObservation]:
    """Observations of one dancer."""
    planned = [event for cue in log.cues if cue.dancer == dancer for event in cue.events()]
    kinds = sorted({kind for kind, _ in planned})
    logged = {
        early: [event for event in log.events if (event.person, event.early) == (dancer, early)]
        for early in (False, True)
    }
    matched = {(kind, early): _match(planned, logged[early], kind) for kind, early in itertools.product(kinds, logged)}

    found: list[DelayObservation] = []
    known_moves: set[Kind] = set()
    seen = dict.fromkeys(kinds, 0)
    start_missed = False
    for kind, _ in planned:
        place = seen[kind]
        seen[kind] += 1
        regular_s = matched[kind, False][0][place]
        early_s = matched[kind, True][0][place]

        is_stop = kind in START_OF
        if not (is_stop and start_missed):
            found.append(DelayObservation("regular", kind, regular_s))
            if kind is not Kind.CLAP and (not is_stop or kind in known_moves):
                found.append(DelayObservation("early", kind, early_s))
        if is_stop and not start_missed and np.isfinite(regular_s):
            known_moves.add(kind)
        start_missed = not is_stop and bool(np.isnan(regular_s))

    for (kind, early), (_, false_count) in matched.items():
        table = "early" if early else "regular"
        found += [DelayObservation(table, kind, float("nan"), is_false=True)] * false_count
    return found


def _match(planned: Sequence[tuple[Kind, float]], logged: Sequence[Event], kind: Kind) -> tuple[Array, int]:
    """(N,) delay of the logged event of each planned one of a kind [s], NaN without one, and the number of others."""
    planned_s = np.array([t_s for other, t_s in planned if other is kind])
    logged_s = np.array([event.t_s for event in logged if event.kind is kind])
    rows, columns = match_times(logged_s, planned_s, MATCH_WITHIN_S)

    delay_s = np.full(len(planned_s), np.nan)
    delay_s[columns] = logged_s[rows] - planned_s[columns]
    return delay_s, len(logged_s) - len(rows)
