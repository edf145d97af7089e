"""Figures of trials: joint errors, tracking, noise, detected events, and identity errors."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ..assets.names import JOINT_INDEX, JOINTS
from ..config import DetectorConfig, SensorConfig
from ..core import TRACKED, Array, DeviceEvent, Kind, SkeletonFrame, Skeletons
from ..sensors.events.detectors import EventDetector
from .scenes import RATE_HZ
from .trials import WARM_FRAMES, TrialResult

MATCH_S = 0.4
"""Largest difference of the times of two events that match."""

ASTRAY_M = 0.15
"""Error above which a joint should not be called tracked."""

VISIBLE_SHARE = 0.9
"""Smallest fraction of frames with visible joints at which a dancer is regarded as visible."""

_BASE = JOINT_INDEX["SpineBase"]
_HANDS = [JOINT_INDEX["HandLeft"], JOINT_INDEX["HandRight"]]
_UPPER_JOINTS = [JOINT_INDEX[name] for name in ("SpineMid", "Neck", "ShoulderLeft", "ShoulderRight")]
_PAIRS = np.array(
    [[JOINT_INDEX[f"{name}{side}"] for side in ("Left", "Right")] for name in ("Shoulder", "Hip", "Knee", "Elbow")]
)
_EVALUATED = slice(WARM_FRAMES, None)
_MEDIAN_OF_ABSOLUTE_NORMAL = 0.6745


def joint_errors(results: Iterable[TrialResult]) -> dict[str, float]:
    """Return errors of the joints of all trials.

    Returns:
        ``median_cm`` and ``p95_cm``: error of visible joints that have a position; ``tracked`` and ``lost``: shares of
        visible joints that are tracked, and that have no position; ``astray``: share of tracked joints, visible or
        not, with an error above `ASTRAY_M`; ``astray_visible``: the same of visible joints; ``swapped``: share of
        frames and dancers whose left and right sides are exchanged; ``hidden_median_cm``: median error of occluded
        joints that have a position, NaN if there are none.
    """
    visible_errors: list[Array] = []
    visible_states: list[NDArray[np.int8]] = []
    occluded_errors: list[Array] = []
    occluded_tracked_errors: list[Array] = []
    swapped: list[NDArray[np.bool_]] = []
    for result in results:
        error_m = np.linalg.norm(result.found[_EVALUATED] - result.true[_EVALUATED], axis=3)
        visible = result.visible[_EVALUATED]
        state = result.state[_EVALUATED]
        visible_errors.append(error_m[visible])
        visible_states.append(state[visible])
        occluded_errors.append(error_m[~visible])
        occluded_tracked_errors.append(error_m[~visible & (state == TRACKED)])
        swapped.append(_sides_are_swapped(result).ravel())

    error_m = np.concatenate(visible_errors)
    known = np.isfinite(error_m)
    tracked = np.concatenate(visible_states) == TRACKED
    occluded_m = np.concatenate(occluded_errors)
    all_tracked_m = np.concatenate([error_m[tracked], *occluded_tracked_errors])
    return {
        "median_cm": 100 * float(np.median(error_m[known])),
        "p95_cm": 100 * float(np.percentile(error_m[known], 95)),
        "tracked": float(tracked.mean()),
        "astray": float((all_tracked_m > ASTRAY_M).mean()),
        "astray_visible": float((error_m[tracked] > ASTRAY_M).mean()),
        "lost": float(1.0 - known.mean()),
        "swapped": float(np.concatenate(swapped).mean()),
        "hidden_median_cm": 100 * float(np.nanmedian(occluded_m)) if np.isfinite(occluded_m).any() else math.nan,
    }


def _sides_are_swapped(result: TrialResult) -> NDArray[np.bool_]:
    """Return (T, D) whether the lines between left and right joints point against the true ones, on the floor."""
    lines = [
        (joints[_EVALUATED][:, :, _PAIRS[:, 0]] - joints[_EVALUATED][:, :, _PAIRS[:, 1]])[..., [0, 2]]
        for joints in (result.found, result.true)
    ]
    return np.asarray((lines[0] * lines[1]).sum(axis=3).sum(axis=2) < 0)


def errors_by_joint(results: Iterable[TrialResult]) -> dict[str, tuple[float, float, float]]:
    """Return the median and the 95th percentile of each joint's error where visible [cm], and the share tracked."""
    results = list(results)
    errors_m = [np.linalg.norm(result.found - result.true, axis=3)[_EVALUATED] for result in results]
    error_m = np.concatenate([error.reshape(-1, 25) for error in errors_m])
    visible = np.concatenate([result.visible[_EVALUATED].reshape(-1, 25) for result in results])
    state = np.concatenate([result.state[_EVALUATED].reshape(-1, 25) for result in results])
    out = {}
    for index, name in enumerate(JOINTS):
        rows = visible[:, index] & np.isfinite(error_m[:, index])
        if rows.any():
            values_cm = 100 * error_m[rows, index]
            tracked = float((state[visible[:, index], index] == TRACKED).mean())
            out[name] = (float(np.median(values_cm)), float(np.percentile(values_cm, 95)), tracked)
    return out


def depth_noise_cm(results: Iterable[TrialResult]) -> tuple[float, float]:
    """Return the standard deviation of the depth error's change from frame to frame [cm].

    Returns:
        for SpineBase, and for the joints of early events; medians over all visible dancers.
    """
    base = []
    upper = []
    for result in results:
        depth_error_m = (result.found - result.true)[_EVALUATED, :, :, 2]
        steps_m = np.diff(depth_error_m, axis=0)
        visible = result.visible[_EVALUATED, :, _BASE].mean(axis=0) > VISIBLE_SHARE
        for k in np.flatnonzero(visible):
            # The median ignores the few large steps of joints that are lost and found again.
            base.append(float(np.nanmedian(np.abs(steps_m[:, k, _BASE])) / _MEDIAN_OF_ABSOLUTE_NORMAL))
            upper.append(float(np.nanmedian(np.abs(steps_m[:, k, _UPPER_JOINTS])) / _MEDIAN_OF_ABSOLUTE_NORMAL))
    return 100 * float(np.median(base)), 100 * float(np.median(upper))


@dataclass(slots=True)
class EventCounts:
    """Counts of detected events, compared with those detected on true joints.

    Attributes:
        expected: number of events on true joints.
        missed: number of those without a match.
        false: number of detected events without a match.
        differences_s: differences of the times of matched events.
    """

    expected: int = 0
    missed: int = 0
    false: int = 0
    differences_s: list[float] = field(default_factory=list)

    def add(self, true: Sequence[float], found: Sequence[float]) -> None:
        """Match times of one kind one to one within `MATCH_S`, each true time to the nearest one that is left."""
        left = list(found)
        self.expected += len(true)
        for t_s in true:
            near = [other for other in left if abs(other - t_s) <= MATCH_S]
            if not near:
                self.missed += 1
                continue
            best = min(near, key=lambda other: abs(other - t_s))
            left.remove(best)
            self.differences_s.append(abs(best - t_s))
        self.false += len(left)

    @property
    def p95_ms(self) -> float:
        """95th percentile of the differences [ms]; NaN without matches."""
        return round(1000 * float(np.percentile(self.differences_s, 95)), 1) if self.differences_s else math.nan


def detect_on_skeletons(joints: Array, state: NDArray[np.int8]) -> list[DeviceEvent]:
    """Return the events of one person's skeletons (T, 25, 3) and tracking states (T, 25)."""
    detector = EventDetector(DetectorConfig(), SensorConfig().rate_hz)
    persons = np.zeros(1, dtype=np.int64)
    events: list[DeviceEvent] = []
    for frame in range(len(joints)):
        t_s = frame / RATE_HZ
        skeletons = Skeletons(persons, joints[frame][None], state[frame][None])
        events += detector.update(SkeletonFrame("north", t_s, t_s, t_s, skeletons))
    return events


def event_counts(results: Iterable[TrialResult], *, hidden: bool = False) -> dict[str, EventCounts]:
    """Return counts of regular moves, claps and early events.

    Args:
        results: results of trials.
        hidden: count the dancers that are mostly occluded instead of those that are visible. Moves and early events
            need a visible trunk, claps need visible hands.
    """
    counts = {"moves": EventCounts(), "claps": EventCounts(), "early": EventCounts()}
    for result in results:
        for k in range(result.true.shape[1]):
            state = result.state[_EVALUATED, k]
            true = detect_on_skeletons(result.true[_EVALUATED, k], np.full(state.shape, TRACKED, np.int8))
            found = detect_on_skeletons(result.found[_EVALUATED, k], state)

            visible = result.visible[_EVALUATED, k]
            trunk_visible = visible[:, _BASE].mean() > VISIBLE_SHARE
            hands_visible = visible[:, _HANDS].mean() > VISIBLE_SHARE
            for group, counted in (("moves", trunk_visible), ("claps", hands_visible), ("early", trunk_visible)):
                if counted == hidden:
                    continue
                for kind in Kind:
                    counts[group].add(_times_s(true, group, kind), _times_s(found, group, kind))
    return counts


def _times_s(events: Sequence[DeviceEvent], group: str, kind: Kind) -> list[float]:
    """Return the times of the events of a kind that belong to a group."""
    # Early events are a group of their own, whatever their kind.
    if (group == "claps") != (kind is Kind.CLAP) and group != "early":
        return []
    return [event.t_device_s for event in events if event.kind is kind and event.early == (group == "early")]


def identity_errors(results: Iterable[TrialResult]) -> dict[str, float]:
    """Return identity errors of all trials.

    Returns:
        ``changed``: dancers whose person changed; ``lost_share``: share of frames in which a dancer has no person;
        ``ghost_frames``: frames with a person at no dancer's place.
    """
    changed = 0
    lost = 0
    ghosts = 0
    frames = 0
    for result in results:
        persons = result.person[_EVALUATED]
        frames += persons.size
        lost += int((persons < 0).sum())
        ghosts += int((result.extra_persons[_EVALUATED] > 0).sum())
        for k in range(persons.shape[1]):
            known = persons[persons[:, k] >= 0, k]
            changed += int(len(known) > 0 and (known != known[0]).any())
    return {"changed": changed, "lost_share": lost / max(frames, 1), "ghost_frames": ghosts}
