"""Figures of trials: errors of visible joints, what is tracked, jitter, events, identities, time."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..assets.names import JOINT_INDEX, JOINTS
from ..config import DetectorConfig, SensorConfig
from ..core import TRACKED, Array, DeviceEvent, Kind, SkeletonFrame, Skeletons
from ..sensors.events.detectors import EventDetector
from .scenes import RATE_HZ
from .trials import WARM_FRAMES, TrialResult

_BASE = JOINT_INDEX["SpineBase"]
_HANDS = [JOINT_INDEX["HandLeft"], JOINT_INDEX["HandRight"]]
_SIDES = np.array(
    [[JOINT_INDEX[f"{name}{side}"] for side in ("Left", "Right")] for name in ("Shoulder", "Hip", "Knee", "Elbow")]
)
MATCH_S = 0.4
ASTRAY_M = 0.15
"""A joint so far from the truth should not be called tracked."""
SEEN_SHARE = 0.9
"""A dancer whose trunk joints are visible in so many frames counts as visible."""


def joint_errors(outcomes: Iterable[TrialResult]) -> dict[str, float]:
    """Median and p95 error of visible joints that have a position [cm], shares tracked and lost, left-right swaps.

    ``astray`` is the share of all tracked joints, whether visible or not, that are off by more than `ASTRAY_M`;
    ``astray_visible`` that of the visible ones.
    """
    found, state, seen, swapped, hidden, claimed = [], [], [], [], [], []
    for one in outcomes:
        part = slice(WARM_FRAMES, None)
        error = np.linalg.norm(one.found[part] - one.true[part], axis=3)
        visible = one.visible[part]
        found.append(error[visible])
        state.append(one.state[part][visible])
        hidden.append(error[~visible])
        claimed.append(error[~visible & (one.state[part] == TRACKED)])
        seen.append(np.isfinite(error[visible]))
        ways = [(joints[part][:, :, _SIDES[:, 0]] - joints[part][:, :, _SIDES[:, 1]])[..., [0, 2]]
                for joints in (one.found, one.true)]  # fmt: skip
        swapped.append(((ways[0] * ways[1]).sum(axis=3).sum(axis=2) < 0).ravel())
    error, known, tracked = np.concatenate(found), np.concatenate(seen), np.concatenate(state) == TRACKED
    lost, claims = np.concatenate(hidden), np.concatenate([error[tracked], *claimed])
    return {
        "median_cm": 100 * float(np.median(error[known])),
        "p95_cm": 100 * float(np.percentile(error[known], 95)),
        "tracked": float(tracked.mean()),
        "astray": float((claims > ASTRAY_M).mean()),
        "astray_visible": float((error[tracked] > ASTRAY_M).mean()),
        "lost": float(1.0 - known.mean()),
        "swapped": float(np.concatenate(swapped).mean()),
        "hidden_median_cm": 100 * float(np.nanmedian(lost)) if np.isfinite(lost).any() else math.nan,
    }


def errors_by_joint(outcomes: Iterable[TrialResult]) -> dict[str, tuple[float, float, float]]:
    """Joint -> median and p95 error where visible [cm], share tracked."""
    outcomes = list(outcomes)
    away = [np.linalg.norm(one.found - one.true, axis=3)[WARM_FRAMES:] for one in outcomes]
    error = np.concatenate([one.reshape(-1, 25) for one in away])
    visible = np.concatenate([one.visible[WARM_FRAMES:].reshape(-1, 25) for one in outcomes])
    state = np.concatenate([one.state[WARM_FRAMES:].reshape(-1, 25) for one in outcomes])
    out = {}
    for index, name in enumerate(JOINTS):
        rows = visible[:, index] & np.isfinite(error[:, index])
        if rows.any():
            values = 100 * error[rows, index]
            tracked = float((state[visible[:, index], index] == TRACKED).mean())
            out[name] = (float(np.median(values)), float(np.percentile(values, 95)), tracked)
    return out


def depth_noise_cm(outcomes: Iterable[TrialResult]) -> tuple[float, float]:
    """Frame-to-frame s.d. of the depth error, median over visible dancers: SpineBase, and the early events' joints."""
    rows: list[float] = []
    upper: list[float] = []
    names = [JOINT_INDEX[name] for name in ("SpineMid", "Neck", "ShoulderLeft", "ShoulderRight")]
    for one in outcomes:
        off = (one.found - one.true)[WARM_FRAMES:, :, :, 2]
        steps = np.diff(off, axis=0)
        seen = one.visible[WARM_FRAMES:, :, _BASE].mean(axis=0) > SEEN_SHARE
        rows += [float(np.nanmedian(np.abs(steps[:, k, _BASE])) / 0.6745) for k in np.flatnonzero(seen)]
        upper += [float(np.nanmedian(np.abs(steps[:, k, names])) / 0.6745) for k in np.flatnonzero(seen)]
    return 100 * float(np.median(rows)), 100 * float(np.median(upper))


@dataclass(slots=True)
class EventCounts:
    """Events against those on true joints.

    Attributes:
        expected: events on true joints.
        missed: those without a partner.
        false: events without a partner.
        off_s: distances of the pairs.
    """

    expected: int = 0
    missed: int = 0
    false: int = 0
    off_s: list[float] | None = None

    def add(self, true: Sequence[float], found: Sequence[float]) -> None:
        """Match two rows of times one to one within `MATCH_S`."""
        left = list(found)
        self.expected += len(true)
        self.off_s = self.off_s or []
        for t_s in true:
            near = [other for other in left if abs(other - t_s) <= MATCH_S]
            if not near:
                self.missed += 1
                continue
            best = min(near, key=lambda other: abs(other - t_s))
            left.remove(best)
            self.off_s.append(abs(best - t_s))
        self.false += len(left)

    @property
    def p95_ms(self) -> float:
        """95th percentile of the distances [ms]."""
        return round(1000 * float(np.percentile(self.off_s, 95)), 1) if self.off_s else math.nan


def detected(joints: Array, state: NDArray[np.int8]) -> list[DeviceEvent]:
    """Events of one person's skeletons (T, 25, 3) and states (T, 25), by the clients' own detectors."""
    detectors = EventDetector(DetectorConfig(), SensorConfig().rate_hz)
    persons = np.zeros(1, dtype=np.int64)
    out: list[DeviceEvent] = []
    for tick in range(len(joints)):
        t_s = tick / RATE_HZ
        skeletons = Skeletons(persons, joints[tick][None], state[tick][None])
        out += detectors.update(SkeletonFrame("north", t_s, t_s, t_s, skeletons))
    return out


def event_counts(outcomes: Iterable[TrialResult], *, hidden: bool = False) -> dict[str, EventCounts]:
    """Tallies of regular moves, claps and early events of dancers that are visible (or, on request, are not).

    A clap needs both hands, and so does its tally; moves need the trunk.
    """
    out = {"moves": EventCounts(), "claps": EventCounts(), "early": EventCounts()}
    for one in outcomes:
        for k in range(one.true.shape[1]):
            part = slice(WARM_FRAMES, None)
            true = detected(one.true[part, k], np.full(one.state[part, k].shape, TRACKED, np.int8))
            found = detected(one.found[part, k], one.state[part, k])
            torso = one.visible[part, k, _BASE].mean() > SEEN_SHARE
            hands = one.visible[part, k][:, _HANDS].mean() > SEEN_SHARE
            for group, seen in (("moves", torso), ("claps", hands), ("early", torso)):
                if seen != hidden:
                    for kind in Kind:
                        out[group].add(_times(true, group, kind), _times(found, group, kind))
    return out


def _times(seen: Sequence[DeviceEvent], group: str, kind: Kind) -> list[float]:
    if (group == "claps") != (kind is Kind.CLAP) and group != "early":
        return []
    return [event.t_device_s for event in seen if event.kind is kind and event.early == (group == "early")]


def identity_errors(outcomes: Iterable[TrialResult]) -> dict[str, float]:
    """Dancers whose identity changed, frames of dancers without a person, frames with a person at nobody's place."""
    changed = lost = ghosts = frames = 0
    for one in outcomes:
        names = one.name[WARM_FRAMES:]
        frames += names.size
        lost += int((names < 0).sum())
        ghosts += int((one.strangers[WARM_FRAMES:] > 0).sum())
        for k in range(names.shape[1]):
            known = names[names[:, k] >= 0, k]
            changed += int(len(known) > 0 and (known != known[0]).any())
    return {"changed": changed, "lost_share": lost / max(frames, 1), "ghost_frames": ghosts}
