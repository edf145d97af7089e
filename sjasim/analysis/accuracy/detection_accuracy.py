"""The report card of detectors and robot over many sessions: what they miss, invent and delay, and where."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...choreography.timetable import Timetable, timetable
from ...config import SessionConfig
from ...config.toml_file import from_plain
from ...core import Array, Kind
from ...core.session_log import AgentEvent, SessionLog
from ..component_quality import WITHIN_S, robot_gaps
from ..event_matching import matched
from ..ground_truth_events import SEEN_AROUND_S, dancer_events

EARLY_WITHIN_S = 0.8
"""An early event and the true one that it foretells are no farther apart: early events come up to .5 s ahead."""

BANDS = ("visible", "partly", "hidden")
"""How much of the joints that an event needs the sensor that dancers face saw around it: all, some, none."""

QUANTILES = tuple(float(share) for share in np.linspace(0.0, 1.0, 21))
"""Shares at which the distributions of errors are given."""

ALL = "all"


@dataclass(frozen=True, slots=True)
class Outcome:
    """What became of one event.

    Attributes:
        sensing: ``joints`` or ``depth``.
        kind: what happened.
        early: whether it is told of in advance; then the error is how long before the true one.
        row: ``front`` or ``back``: whether the dancer stands nearer to the sensor than the middle of the group.
        band: one of `BANDS`.
        true: whether it happened.
        error_s: logged - true; NaN unless it happened and was logged.
        logged: whether a method was told of it.
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
    """What became of one command: its step's kind, and how long after sending the robot's event came (NaN: never)."""

    kind: Kind
    delay_s: float


def event_outcomes(log: SessionLog) -> list[Outcome]:
    """Every true and every logged event of the dancers in a session."""
    config = from_plain(log.config)
    table = timetable(config)
    true = dancer_events(log.truth, log.cues, table)
    found: list[Outcome] = []
    for agent, early in itertools.product(sorted({event.agent for event in true}), (False, True)):
        place = _Place(log.truth, table, agent)
        for kind in Kind:
            if kind is Kind.TURN or (early and kind is Kind.CLAP):
                continue
            happened = [event for event in true if (event.agent, event.kind) == (agent, kind)]
            told = [one.t_s for one in log.events if (one.person, one.kind, one.early) == (agent, kind, early)]
            found += _compared(config, kind, early, happened, told, place)
    return found


def _compared(
    config: SessionConfig, kind: Kind, early: bool, happened: Sequence[AgentEvent], told: Sequence[float],
    place: _Place,
) -> list[Outcome]:  # fmt: skip
    """One dancer's events of one kind: matched one to one."""
    times, really = np.array(told), np.array([event.t_s for event in happened])
    rows, columns = matched(times, really, EARLY_WITHIN_S if early else WITHIN_S)
    partner = dict(zip(columns.tolist(), rows.tolist(), strict=True))
    found = []
    for index, event in enumerate(happened):
        error = times[partner[index]] - event.t_s if index in partner else float("nan")
        row, band = place.at(event.t_s, kind)
        found.append(Outcome(config.sensing, kind, early, row, band, True, index in partner, float(error)))
    for index in sorted(set(range(len(told))) - set(rows.tolist())):
        row, band = place.at(told[index], kind)
        found.append(Outcome(config.sensing, kind, early, row, band, False, True))
    return found


class _Place:
    """Where one dancer stood, and how well they were seen."""

    def __init__(self, truth: Mapping[str, NDArray[np.generic]], table: Timetable, agent: str) -> None:
        columns = {name: np.asarray(column, dtype=np.float64) for name, column in truth.items()}
        mine = columns["dancer"] == int(agent.rpartition("_")[2]) - 1
        self._mine = {name: column[mine] for name, column in columns.items()}
        self._all, self._table = columns, table

    def at(self, t_s: float, kind: Kind) -> tuple[str, str]:
        """Row and occlusion band at a time."""
        times = self._mine["t_s"]
        here = min(int(np.searchsorted(times, t_s)), len(times) - 1)
        everybody = self._all["t_s"] == times[here]
        heading = self._table.heading_rad(self._table.iteration_at(t_s))
        ahead = np.array([np.cos(heading), np.sin(heading)])
        middle = np.array([self._all["x_m"][everybody].mean(), self._all["y_m"][everybody].mean()])
        place = np.array([self._mine["x_m"][here], self._mine["y_m"][here]])
        near = (times >= t_s - SEEN_AROUND_S) & (times <= t_s + SEEN_AROUND_S)
        share = np.nan_to_num(self._mine["hands_seen" if kind is Kind.CLAP else "spine_seen"][near])
        band = BANDS[0] if share.size and share.min() >= 1.0 else BANDS[1] if share.any() else BANDS[2]
        return "front" if float((place - middle) @ ahead) >= 0.0 else "back", band


def command_executions(log: SessionLog) -> list[Execution]:
    """Every command of a session, with the delay of the robot's event."""
    config = from_plain(log.config)
    return [Execution(kind, gap) for kind, gap in robot_gaps(log.commands, log.robot_events, timetable(config))]


def detector_rows(found: Iterable[Outcome]) -> list[dict[str, Any]]:
    """Figures of every sensing route, kind, early or regular, row and occlusion band; ``all`` sums over one."""
    found = list(found)
    groups: dict[tuple[str, str, bool, str, str], list[Outcome]] = {}
    for one in found:
        kinds, rows, bands = (one.kind.value, ALL), (one.row, ALL), (one.band, ALL)
        for kind, row, band in itertools.product(kinds, rows, bands):
            groups.setdefault((one.sensing, kind, one.early, row, band), []).append(one)
    names = ("sensing", "kind", "early", "row", "occlusion")
    return [dict(zip(names, key, strict=True)) | figures(groups[key]) for key in sorted(groups)]


def figures(found: Sequence[Outcome]) -> dict[str, Any]:
    """Recall, precision, and the errors' bias, s.d. and p95 [s] of some outcomes; null where there is nothing."""
    true, logged = sum(one.true for one in found), sum(one.logged for one in found)
    error = _errors(found)
    return {
        "n": true,
        "logged": logged,
        "recall": len(error) / true if true else None,
        "precision": len(error) / logged if logged else None,
        "bias_s": float(error.mean()) if len(error) else None,
        "sd_s": float(error.std()) if len(error) else None,
        "p95_s": float(np.percentile(np.abs(error), 95)) if len(error) else None,
    }


def distributions(found: Iterable[Outcome], minutes: Mapping[str, float]) -> list[dict[str, Any]]:
    """What a world without sensors draws from: per route, kind, early or regular, and occlusion band.

    Args:
        found: outcomes of many sessions.
        minutes: sensing route -> dancer minutes watched.

    Returns:
        rows with ``miss``, the probability that an event is not logged; ``error_s``, the errors at `QUANTILES`; and
        ``false_per_minute``, of invented events.
    """
    groups: dict[tuple[str, str, bool, str], list[Outcome]] = {}
    for one in found:
        for band in (one.band, ALL):
            groups.setdefault((one.sensing, one.kind.value, one.early, band), []).append(one)
    rows = []
    for key in sorted(groups):
        members, error = groups[key], _errors(groups[key])
        true = sum(one.true for one in members)
        rows.append({
            **dict(zip(("sensing", "kind", "early", "occlusion"), key, strict=True)),
            "n": true,
            "miss": 1.0 - len(error) / true if true else None,
            "error_s": np.quantile(error, QUANTILES).tolist() if len(error) else None,
            "false_per_minute": sum(not one.true for one in members) / minutes[key[0]],
        })  # fmt: skip
    return rows


def robot_rows(found: Iterable[Execution]) -> list[dict[str, Any]]:
    """Delay and jitter (mean and s.d. of command to event) and the share not executed, by kind and over all."""
    found = list(found)
    rows = []
    for kind in (*Kind, None):
        delays = np.array([one.delay_s for one in found if kind is None or one.kind is kind])
        if len(delays):
            done = delays[np.isfinite(delays)]
            rows.append({
                "kind": ALL if kind is None else kind.value,
                "n": len(delays),
                "delay_s": float(done.mean()) if len(done) else None,
                "jitter_s": float(done.std()) if len(done) else None,
                "not_executed": 1.0 - len(done) / len(delays),
                "delay_quantiles_s": np.quantile(done, QUANTILES).tolist() if len(done) else None,
            })  # fmt: skip
    return rows


def _errors(found: Iterable[Outcome]) -> Array:
    error = np.array([one.error_s for one in found], dtype=np.float64)
    return error[np.isfinite(error)]
