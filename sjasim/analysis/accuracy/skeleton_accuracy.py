"""How far skeletons lie from the truth over whole sessions: what is tracked, where it is, how its errors move."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...assets.names import JOINTS
from ...choreography.timetable import Timetable, timetable
from ...config.toml_file import from_plain
from ...core import INFERRED, TRACKED, Array, BoolArray, IntArray
from ...core.session_log import SessionLog
from .detection_accuracy import ALL, BANDS

ASTRAY_M = 0.15
"""A tracked joint farther than this from the truth is no error of measurement: it is somewhere else."""

LEAST_FRAMES = 60
"""Errors of a joint in fewer frames before one sensor do not tell its constant error from its slow one."""

OUTLIER = 4.0
"""Steps between frames of more than so many robust s.d. are left out: who jumps does not drift."""

ROWS = ("front", "back")

_STARTS = {"head": ("Head", "Neck"), "arms": ("Elbow", "Wrist", "Hand", "Thumb"), "legs": ("Knee", "Ankle", "Foot")}
GROUPS: dict[str, BoolArray] = {
    name: np.array([joint.startswith(starts) for joint in JOINTS]) for name, starts in _STARTS.items()
}
GROUPS["trunk"] = ~np.any(list(GROUPS.values()), axis=0)
"""(25,) which joints each group has; shoulders and hips are the trunk's."""


@dataclass(frozen=True, slots=True)
class JointObservation:
    """One dancer before one sensor, for as long as it was the active one: N frames.

    Attributes:
        sensing: ``joints`` or ``depth``.
        error_m: (N, 25, 3) seen minus true; NaN where a joint is not known.
        state: (N, 25) how it is known.
        row: (N,) places in `ROWS`.
        trunk: (N,) places in `BANDS` by what could be seen of the trunk in the frame; of everything but arms.
        hands: (N,) the same by the hands; of arms.
    """

    sensing: str
    error_m: NDArray[np.float32]
    state: IntArray
    row: IntArray
    trunk: IntArray
    hands: IntArray


def joint_observations(log: SessionLog) -> list[JointObservation]:
    """Everybody before every sensor that was active in a session; frames that it did not take are left out.

    Args:
        log: of a session that was danced in this process: a folder does not keep the joints.
    """
    if log.joints is None or log.skeletons is None:
        return []
    config = from_plain(log.config)
    t_s = np.arange(len(log.joints)) / config.sensors.rate_hz
    taken = np.isfinite(log.skeletons[..., 3]).any(axis=(1, 2))
    since = np.searchsorted([handover.t_s for handover in log.handovers], t_s, side="right")
    truth, table = {name: np.asarray(column, np.float64) for name, column in log.truth.items()}, timetable(config)
    found = []
    for dancer in range(log.joints.shape[1]):
        row, trunk, hands = _places(truth, table, dancer, t_s)
        for sensor in np.unique(since[taken]):
            here = np.flatnonzero(taken & (since == sensor))
            seen, true = log.skeletons[here, dancer], log.joints[here, dancer]
            state = np.nan_to_num(seen[..., 3]).astype(np.int64)
            found.append(
                JointObservation(config.sensing, seen[..., :3] - true, state, row[here], trunk[here], hands[here])
            )
    return found


def _places(truth: dict[str, Array], table: Timetable, dancer: int, t_s: Array) -> tuple[IntArray, IntArray, IntArray]:
    """Row and bands of one dancer at every frame."""
    mine = truth["dancer"] == dancer
    ticks = truth["t_s"][mine]
    at = np.minimum(np.searchsorted(ticks, t_s), len(ticks) - 1)
    heading = np.array([table.heading_rad(table.iteration_at(time)) for time in t_s.tolist()])
    ahead = np.zeros(len(t_s))
    for name, along in (("x_m", np.cos(heading)), ("y_m", np.sin(heading))):
        middle = truth[name].reshape(len(ticks), -1).mean(axis=1)
        ahead += along * (truth[name][mine] - middle)[at]
    return (ahead < 0.0).astype(np.int64), _band(truth["spine_seen"][mine][at]), _band(truth["hands_seen"][mine][at])


def _band(share: Array) -> IntArray:
    """Places in `BANDS` of shares that are seen; what nobody watches is hidden."""
    return np.where(share >= 1.0, 0, np.where(share > 0.0, 1, 2)).astype(np.int64)


def joint_rows(found: Iterable[JointObservation]) -> list[dict[str, Any]]:
    """Figures of every sensing route, group of joints, row and occlusion band; ``all`` sums over one."""
    routes: dict[str, list[JointObservation]] = {}
    for one in found:
        routes.setdefault(one.sensing, []).append(one)
    cells = itertools.product(sorted(routes), (ALL, *sorted(GROUPS)), (ALL, *ROWS), (ALL, *BANDS))
    names = ("sensing", "joints", "row", "occlusion")
    return [dict(zip(names, cell, strict=True)) | figures(routes[cell[0]], *cell[1:]) for cell in cells]


def figures(found: Sequence[JointObservation], group: str = ALL, row: str = ALL, band: str = ALL) -> dict[str, Any]:
    """Of one route's joint_observations, of one cell of the card; null where it has nothing to go by.

    Returns:
        ``n`` joints in frames; shares ``tracked`` and ``inferred`` of them; of the tracked ones ``median_m``, ``p95_m``
        of their distance to the truth and ``astray``, the share farther than `ASTRAY_M`; ``bias_m``, r.m.s. per axis
        of each joint's mean error; ``drift_m``, r.m.s. about it; ``correlation`` of that from frame to frame; and
        ``inferred_m``, r.m.s. error per axis of inferred joints.
    """
    joints = np.flatnonzero(GROUPS[group]) if group != ALL else np.arange(len(JOINTS))
    parts: list[list[Array]] = [[np.zeros(0)] for _ in range(6)]
    states, far, guessed, means, drifts, steps = parts
    for one, joint in itertools.product(found, joints.tolist()):
        kept = _kept(one, joint, row, band)
        state, error = one.state[kept, joint], one.error_m[kept, joint].astype(np.float64)
        tracked = error[state == TRACKED]
        states.append(state.astype(np.float64))
        far.append(np.sqrt((tracked**2).sum(axis=1)))
        guessed.append(error[state == INFERRED].ravel())
        if len(tracked) >= LEAST_FRAMES:
            means.append(tracked.mean(axis=0))
            drifts.append((tracked - means[-1]).ravel())
            steps.append(np.diff(tracked, axis=0).ravel())
    return _summed(*(np.concatenate(part) for part in parts))


def _kept(one: JointObservation, joint: int, row: str, band: str) -> BoolArray:
    """(N,) the frames of a cell."""
    bands = one.hands if GROUPS["arms"][joint] else one.trunk
    kept = np.ones(len(one.state), dtype=bool)
    if row != ALL:
        kept &= one.row == ROWS.index(row)
    if band != ALL:
        kept &= bands == BANDS.index(band)
    return kept


def _summed(state: Array, far: Array, guessed: Array, means: Array, drifts: Array, steps: Array) -> dict[str, Any]:
    drift, usual = _rms(drifts), np.zeros(0)
    if len(steps):
        usual = steps[np.abs(steps) <= OUTLIER * 1.4826 * np.median(np.abs(steps))]
    step = _rms(usual)
    return {
        "n": len(state),
        "tracked": float((state == TRACKED).mean()) if len(state) else None,
        "inferred": float((state == INFERRED).mean()) if len(state) else None,
        "median_m": float(np.median(far)) if len(far) else None,
        "p95_m": float(np.percentile(far, 95)) if len(far) else None,
        "astray": float((far > ASTRAY_M).mean()) if len(far) else None,
        "bias_m": _rms(means),
        "drift_m": drift,
        "correlation": max(0.0, 1.0 - step**2 / (2.0 * drift**2)) if drift and step is not None else None,
        "inferred_m": _rms(guessed),
    }


def _rms(values: Array) -> float | None:
    return float(np.sqrt(np.mean(values**2))) if len(values) else None
