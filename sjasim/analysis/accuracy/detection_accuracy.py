"""Accuracy of detectors and robot over many sessions: missed, false and delayed events, by kind, row and occlusion."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...choreography.timetable import Timetable, timetable
from ...config.toml_file import from_plain
from ...core import Array, Kind
from ...core.session_log import AgentEvent, SessionLog
from ..component_quality import MATCH_WITHIN_S, execution_delays
from ..event_matching import match_times
from ..ground_truth_events import VISIBILITY_WINDOW_S, dancer_events

EARLY_MATCH_WITHIN_S = 0.8
"""Largest distance between an early event and the true one that it announces [s].

It is wider than for regular events, since early events come up to 0.5 s ahead.
"""

BANDS = ("visible", "partly", "hidden")
"""Occlusion bands: all, some or none of the joints that an event needs were visible around it.

The joints are those that the sensor in front of the dancers could see.
"""

QUANTILES = tuple(float(share) for share in np.linspace(0.0, 1.0, 21))
"""Shares at which distributions of errors are given."""

ALL = "all"
"""Value of a column in rows that aggregate over all values of the column."""


@dataclass(frozen=True, slots=True)
class Outcome:
    """A true event, logged or missed, or a false logged event.

    Attributes:
        sensing: ``joints`` or ``depth``.
        kind: kind of the event.
        early: whether it is an early event; its error is negative if it precedes the true event.
        row: ``front`` or ``back``: whether the dancer stands nearer to the sensor than the middle of the group.
        band: one of `BANDS`.
        true: whether it happened.
        logged: whether it was logged.
        error_s: logged minus true time [s]; NaN unless it happened and was logged.
    """

    sensing: str
    kind: Kind
    early: bool
    row: str
    band: str
    true: bool
    logged: bool
    error_s: float = float("nan")


@dataclass(frozen=True, slots=True)
class Execution:
    """A command to the robot.

    Attributes:
        kind: the robot's event that the command asks for.
        delay_s: time from sending to the event [s]; NaN if it did not follow.
    """

    kind: Kind
    delay_s: float


def event_outcomes(log: SessionLog) -> list[Outcome]:
    """Outcomes of all true and all logged events of the dancers in a session."""
    config = from_plain(log.config)
    table = timetable(config)
    true_events = dancer_events(log.truth, log.cues, table)
    agents = sorted({event.agent for event in true_events})

    found: list[Outcome] = []
    for agent, early in itertools.product(agents, (False, True)):
        visibility = _Visibility(log.truth, table, agent)
        for kind in Kind:
            # Detectors report no turns, and claps are not announced.
            if kind is Kind.TURN or (early and kind is Kind.CLAP):
                continue
            true = [event for event in true_events if (event.agent, event.kind) == (agent, kind)]
            logged_s = [item.t_s for item in log.events if (item.person, item.kind, item.early) == (agent, kind, early)]
            for place, is_true, is_logged, error_s in _compare(true, logged_s, kind, early, visibility):
                found.append(Outcome(config.sensing, kind, early, *place, is_true, is_logged, error_s))
    return found


def command_executions(log: SessionLog) -> list[Execution]:
    """All commands of a session, each with the delay of the robot's event."""
    table = timetable(from_plain(log.config))
    return [Execution(kind, delay_s) for kind, delay_s in execution_delays(log.commands, log.robot_events, table)]


def detector_rows(outcomes: Iterable[Outcome]) -> list[dict[str, Any]]:
    """Table of `detection_figures` by sensing route, kind, early or regular, row and occlusion band.

    Rows with `ALL` in a column sum over it.
    """
    groups: dict[tuple[str, str, bool, str, str], list[Outcome]] = {}
    for outcome in outcomes:
        kinds = (outcome.kind.value, ALL)
        rows = (outcome.row, ALL)
        bands = (outcome.band, ALL)
        for kind, row, band in itertools.product(kinds, rows, bands):
            groups.setdefault((outcome.sensing, kind, outcome.early, row, band), []).append(outcome)

    names = ("sensing", "kind", "early", "row", "occlusion")
    return [dict(zip(names, key, strict=True)) | detection_figures(groups[key]) for key in sorted(groups)]


def detection_figures(outcomes: Sequence[Outcome]) -> dict[str, Any]:
    """Number, recall, precision, and bias, standard deviation and 95th percentile of the errors [s] of some outcomes.

    A figure without any event to compute it from is None.
    """
    true = sum(outcome.true for outcome in outcomes)
    logged = sum(outcome.logged for outcome in outcomes)
    error = _errors(outcomes)
    return {
        "n": true,
        "logged": logged,
        "recall": len(error) / true if true else None,
        "precision": len(error) / logged if logged else None,
        "bias_s": float(error.mean()) if len(error) else None,
        "sd_s": float(error.std()) if len(error) else None,
        "p95_s": float(np.percentile(np.abs(error), 95)) if len(error) else None,
    }


def distributions(outcomes: Iterable[Outcome], minutes: Mapping[str, float]) -> list[dict[str, Any]]:
    """Distributions from which a simulation without sensors draws, by route, kind, early or regular, and occlusion.

    Args:
        outcomes: outcomes of many sessions.
        minutes: sensing route -> observed time, summed over dancers [min].

    Returns:
        Rows with ``miss``, the probability that an event is not logged; ``error_s``, the errors at `QUANTILES` [s]; and
        ``false_per_minute``, the rate of false events per dancer.
    """
    groups: dict[tuple[str, str, bool, str], list[Outcome]] = {}
    for outcome in outcomes:
        for band in (outcome.band, ALL):
            groups.setdefault((outcome.sensing, outcome.kind.value, outcome.early, band), []).append(outcome)

    rows = []
    for key in sorted(groups):
        sensing = key[0]
        members = groups[key]
        error = _errors(members)
        true = sum(outcome.true for outcome in members)
        rows.append({
            **dict(zip(("sensing", "kind", "early", "occlusion"), key, strict=True)),
            "n": true,
            "miss": 1.0 - len(error) / true if true else None,
            "error_s": np.quantile(error, QUANTILES).tolist() if len(error) else None,
            "false_per_minute": sum(not outcome.true for outcome in members) / minutes[sensing],
        })  # fmt: skip
    return rows


def robot_rows(executions: Iterable[Execution]) -> list[dict[str, Any]]:
    """Table of the robot's delays by kind, and over all kinds; kinds without commands are left out.

    Delay and jitter are mean and standard deviation of the time from command to event [s].
    """
    executions = list(executions)
    rows = []
    for kind in (*Kind, None):
        delays = np.array([item.delay_s for item in executions if kind is None or item.kind is kind])
        if not len(delays):
            continue

        executed = delays[np.isfinite(delays)]
        rows.append({
            "kind": ALL if kind is None else kind.value,
            "n": len(delays),
            "delay_s": float(executed.mean()) if len(executed) else None,
            "jitter_s": float(executed.std()) if len(executed) else None,
            "not_executed": 1.0 - len(executed) / len(delays),
            "delay_quantiles_s": np.quantile(executed, QUANTILES).tolist() if len(executed) else None,
        })  # fmt: skip
    return rows


class _Visibility:
    """Row and occlusion band of one dancer over time.

    Args:
        truth: columns of the ground-truth table.
        table: gives the heading of each iteration.
        agent: the dancer.
    """

    def __init__(self, truth: Mapping[str, NDArray[np.generic]], table: Timetable, agent: str) -> None:
        columns = {name: np.asarray(column, dtype=np.float64) for name, column in truth.items()}
        of_dancer = columns["dancer"] == int(agent.rpartition("_")[2]) - 1
        self._own = {name: column[of_dancer] for name, column in columns.items()}
        self._all = columns
        self._table = table

    def at(self, t_s: float, kind: Kind) -> tuple[str, str]:
        """Row and band at a session time; a clap needs the hands, other kinds the trunk."""
        return self._row(t_s), self._band(t_s, kind)

    def _row(self, t_s: float) -> str:
        times = self._own["t_s"]
        nearest = min(int(np.searchsorted(times, t_s)), len(times) - 1)
        at_time = self._all["t_s"] == times[nearest]

        heading = self._table.heading_rad(self._table.iteration_at(t_s))
        forward = np.array([np.cos(heading), np.sin(heading)])
        centre = np.array([self._all["x_m"][at_time].mean(), self._all["y_m"][at_time].mean()])
        position = np.array([self._own["x_m"][nearest], self._own["y_m"][nearest]])
        return "front" if float((position - centre) @ forward) >= 0.0 else "back"

    def _band(self, t_s: float, kind: Kind) -> str:
        times = self._own["t_s"]
        near = (times >= t_s - VISIBILITY_WINDOW_S) & (times <= t_s + VISIBILITY_WINDOW_S)
        # The share is NaN without an active sensor.
        share = np.nan_to_num(self._own["hands_seen" if kind is Kind.CLAP else "spine_seen"][near])
        if share.size and share.min() >= 1.0:
            return BANDS[0]
        return BANDS[1] if share.any() else BANDS[2]


def _compare(
    true: Sequence[AgentEvent], logged_s: Sequence[float], kind: Kind, early: bool, visibility: _Visibility
) -> list[tuple[tuple[str, str], bool, bool, float]]:
    """Match one dancer's true and logged events of one kind: (row and band, true, logged, error [s]) of each."""
    times = np.array(logged_s)
    within_s = EARLY_MATCH_WITHIN_S if early else MATCH_WITHIN_S
    rows, columns = match_times(times, np.array([event.t_s for event in true]), within_s)
    logged_row = dict(zip(columns.tolist(), rows.tolist(), strict=True))

    found = []
    for index, event in enumerate(true):
        is_logged = index in logged_row
        error_s = float(times[logged_row[index]] - event.t_s) if is_logged else float("nan")
        found.append((visibility.at(event.t_s, kind), True, is_logged, error_s))

    for index in sorted(set(range(len(logged_s))) - set(rows.tolist())):
        found.append((visibility.at(logged_s[index], kind), False, True, float("nan")))
    return found


def _errors(outcomes: Iterable[Outcome]) -> Array:
    """(N,) errors of the events that happened and were logged [s]."""
    error = np.array([outcome.error_s for outcome in outcomes], dtype=np.float64)
    return error[np.isfinite(error)]
