"""Accuracy of estimated skeletons over many sessions: tracking shares, position errors, and their course in time."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping, Sequence
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

OUTLIER_M = 0.15
"""Error beyond which a tracked joint is on another object or body part, not measured imprecisely [m]."""

LEAST_FRAMES = 60
"""Smallest number of frames of a joint before one sensor that separates its constant from its slow error."""

OUTLIER_STEP = 4.0
"""Changes of the error between frames beyond this many robust standard deviations are jumps, not drift."""

MAD_TO_SD = 1.4826
"""Standard deviation of a normal distribution over its median absolute deviation."""

ROWS = ("front", "back")

_NAME_PREFIXES = {
    "head": ("Head", "Neck"), "arms": ("Elbow", "Wrist", "Hand", "Thumb"), "legs": ("Knee", "Ankle", "Foot"),
}  # fmt: skip

GROUPS: dict[str, BoolArray] = {
    name: np.array([joint.startswith(prefixes) for joint in JOINTS]) for name, prefixes in _NAME_PREFIXES.items()
}
GROUPS["trunk"] = ~np.any(list(GROUPS.values()), axis=0)
"""Group -> (25,) whether each joint belongs to it; shoulders and hips belong to the trunk."""


@dataclass(frozen=True, slots=True)
class JointObservation:
    """One dancer before one sensor, in the N frames in which that sensor was active.

    Attributes:
        sensing: ``joints`` or ``depth``.
        error_m: (N, 25, 3) estimated minus true position [m]; NaN where a joint is not known.
        state: (N, 25) tracking state.
        row: (N,) index into `ROWS`.
        trunk: (N,) index into `BANDS` by the visibility of the trunk; it applies to all joints but the arms.
        hands: (N,) index into `BANDS` by the visibility of the hands; it applies to the arms.
    """

    sensing: str
    error_m: NDArray[np.float32]
    state: IntArray
    row: IntArray
    trunk: IntArray
    hands: IntArray


@dataclass(frozen=True, slots=True)
class _Cell:
    """Values of one cell of the table, gathered over joints and observations.

    Attributes:
        state: tracking state of each joint in each frame.
        distance_m: distance of tracked joints from the truth [m].
        inferred_m: errors of inferred joints, per axis [m].
        mean_m: mean error of each joint before each sensor, per axis [m].
        deviation_m: deviations from it, per axis and frame [m].
        step_m: changes of the error from frame to frame, per axis [m].
    """

    state: Array
    distance_m: Array
    inferred_m: Array
    mean_m: Array
    deviation_m: Array
    step_m: Array


def joint_observations(log: SessionLog) -> list[JointObservation]:
    """Observations of every dancer before every sensor that was active in a session.

    Frames without a skeleton are left out. A log without joints or skeletons, as `record.session_folder.read` gives it,
    has no observations.
    """
    if log.joints is None or log.skeletons is None:
        return []

    config = from_plain(log.config)
    table = timetable(config)
    truth = {name: np.asarray(column, np.float64) for name, column in log.truth.items()}
    t_s = np.arange(len(log.joints)) / config.sensors.rate_hz
    processed = np.isfinite(log.skeletons[..., 3]).any(axis=(1, 2))
    # Number of handovers so far, which changes whenever another sensor becomes active.
    period = np.searchsorted([handover.t_s for handover in log.handovers], t_s, side="right")

    found = []
    for dancer in range(log.joints.shape[1]):
        row, trunk, hands = _rows_and_bands(truth, table, dancer, t_s)
        for number in np.unique(period[processed]):
            frames = np.flatnonzero(processed & (period == number))
            estimated = log.skeletons[frames, dancer]
            observation = JointObservation(
                sensing=config.sensing,
                error_m=estimated[..., :3] - log.joints[frames, dancer],
                state=np.nan_to_num(estimated[..., 3]).astype(np.int64),
                row=row[frames],
                trunk=trunk[frames],
                hands=hands[frames],
            )
            found.append(observation)
    return found


def joint_rows(observations: Iterable[JointObservation]) -> list[dict[str, Any]]:
    """Table of `joint_figures` by sensing route, group of joints, row and occlusion band.

    Rows with `ALL` in a column sum over it.
    """
    routes: dict[str, list[JointObservation]] = {}
    for observation in observations:
        routes.setdefault(observation.sensing, []).append(observation)

    cells = itertools.product(sorted(routes), (ALL, *sorted(GROUPS)), (ALL, *ROWS), (ALL, *BANDS))
    names = ("sensing", "joints", "row", "occlusion")
    return [dict(zip(names, cell, strict=True)) | joint_figures(routes[cell[0]], *cell[1:]) for cell in cells]


def joint_figures(
    observations: Sequence[JointObservation], group: str = ALL, row: str = ALL, band: str = ALL
) -> dict[str, Any]:
    """Accuracy of some joints in some frames.

    Args:
        observations: of one sensing route.
        group: key of `GROUPS`, or `ALL`.
        row: one of `ROWS`, or `ALL`.
        band: one of `BANDS`, or `ALL`.

    Returns:
        ``n``, the number of joints in frames, and the shares of them that are ``tracked`` and ``inferred``. Of tracked
        joints: ``median_m`` and ``p95_m`` of the distance to the truth; ``astray``, the share farther than
        `OUTLIER_M`; ``bias_m``, root mean square per axis of each joint's mean error; ``drift_m``, root mean square
        deviation from it; ``correlation`` of that deviation from frame to frame. ``inferred_m``: root mean square
        error per axis of inferred joints. A figure without data is None.
    """
    cell = _gather(observations, group, row, band)
    state = cell.state
    distance_m = cell.distance_m
    drift_m = _rms(cell.deviation_m)
    return {
        "n": len(state),
        "tracked": float((state == TRACKED).mean()) if len(state) else None,
        "inferred": float((state == INFERRED).mean()) if len(state) else None,
        "median_m": float(np.median(distance_m)) if len(distance_m) else None,
        "p95_m": float(np.percentile(distance_m, 95)) if len(distance_m) else None,
        "astray": float((distance_m > OUTLIER_M).mean()) if len(distance_m) else None,
        "bias_m": _rms(cell.mean_m),
        "drift_m": drift_m,
        "correlation": _frame_correlation(cell.step_m, drift_m),
        "inferred_m": _rms(cell.inferred_m),
    }


def _rows_and_bands(
    truth: Mapping[str, Array], table: Timetable, dancer: int, t_s: Array
) -> tuple[IntArray, IntArray, IntArray]:
    """(N,) row, and (N,) occlusion bands of trunk and hands, of one dancer at every frame."""
    of_dancer = truth["dancer"] == dancer
    truth_s = truth["t_s"][of_dancer]
    nearest = np.minimum(np.searchsorted(truth_s, t_s), len(truth_s) - 1)

    heading = np.array([table.heading_rad(table.iteration_at(time)) for time in t_s.tolist()])
    ahead_m = np.zeros(len(t_s))
    for name, direction in (("x_m", np.cos(heading)), ("y_m", np.sin(heading))):
        centre = truth[name].reshape(len(truth_s), -1).mean(axis=1)
        ahead_m += direction * (truth[name][of_dancer] - centre)[nearest]

    row = (ahead_m < 0.0).astype(np.int64)
    return row, _band(truth["spine_seen"][of_dancer][nearest]), _band(truth["hands_seen"][of_dancer][nearest])


def _band(visible_share: Array) -> IntArray:
    """Indices into `BANDS`; a share that is NaN, without an active sensor, is hidden."""
    return np.where(visible_share >= 1.0, 0, np.where(visible_share > 0.0, 1, 2)).astype(np.int64)


def _gather(observations: Sequence[JointObservation], group: str, row: str, band: str) -> _Cell:
    """Values of one cell; arguments as in `joint_figures`."""
    joints = np.flatnonzero(GROUPS[group]) if group != ALL else np.arange(len(JOINTS))
    nothing = [np.zeros(0)]
    cell: dict[str, list[Array]] = {name: list(nothing) for name in _Cell.__dataclass_fields__}

    for observation, joint in itertools.product(observations, joints.tolist()):
        frames = _frames(observation, joint, row, band)
        state = observation.state[frames, joint]
        error = observation.error_m[frames, joint].astype(np.float64)
        tracked = error[state == TRACKED]

        cell["state"].append(state.astype(np.float64))
        cell["distance_m"].append(np.sqrt((tracked**2).sum(axis=1)))
        cell["inferred_m"].append(error[state == INFERRED].ravel())
        # In few frames, the slow error does not average out of the mean.
        if len(tracked) >= LEAST_FRAMES:
            mean = tracked.mean(axis=0)
            cell["mean_m"].append(mean)
            cell["deviation_m"].append((tracked - mean).ravel())
            cell["step_m"].append(np.diff(tracked, axis=0).ravel())

    return _Cell(**{name: np.concatenate(parts) for name, parts in cell.items()})


def _frames(observation: JointObservation, joint: int, row: str, band: str) -> BoolArray:
    """(N,) whether each frame belongs to a cell of the table."""
    bands = observation.hands if GROUPS["arms"][joint] else observation.trunk
    included = np.ones(len(observation.state), dtype=bool)
    if row != ALL:
        included &= observation.row == ROWS.index(row)
    if band != ALL:
        included &= bands == BANDS.index(band)
    return included


def _frame_correlation(step_m: Array, drift_m: float | None) -> float | None:
    """Correlation of the slow error between frames: 1 - var(step) / (2 var(deviation)), at least 0."""
    regular = np.zeros(0)
    if len(step_m):
        limit = OUTLIER_STEP * MAD_TO_SD * np.median(np.abs(step_m))
        regular = step_m[np.abs(step_m) <= limit]

    step = _rms(regular)
    if not drift_m or step is None:
        return None
    return max(0.0, 1.0 - step**2 / (2.0 * drift_m**2))


def _rms(values: Array) -> float | None:
    """Root mean square; None without values."""
    return float(np.sqrt(np.mean(values**2))) if len(values) else None
