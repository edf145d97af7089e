"""Recorded motion of dancers, and figures of how well it follows the plan."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..analysis.motion_metrics import foot_slips, rise_times, timing_errors
from ..core import Array, Cue, Kind, dancer_name

COMPLETION_MARGIN_S = 0.5
"""A move counts as completed if the recording goes on for this long after its planned end [s]."""


@dataclass(frozen=True)
class MotionRecording:
    """Motion of D dancers at N control steps.

    Attributes:
        t_s: (N,) session time [s].
        roots: (N, D, 6) x, y, z of the pelvis [m], yaw, pitch, roll [rad].
        hands_m: (N, D) distance between the hands [m].
        feet_m: (N, D, 2, 2) x and y of the left and right ankle [m].
        tether: (N, D, 5) forces [N] and torques [Nm] of the balance support.
        loads_n: (N, D) force of the floor on the feet [N].
        planned_m: (N, D, 3) planned position of the pelvis [m].
        landing_s: (N, D, 2) planned time until the left and right foot lands; 0 for a standing foot [s].
        weight_n: (D,) weights [N].
        cues: planned moves.
        falls: number of dancers who fell.
    """

    t_s: Array
    roots: Array
    hands_m: Array
    feet_m: Array
    tether: Array
    loads_n: Array
    planned_m: Array
    landing_s: Array
    weight_n: Array
    cues: tuple[Cue, ...]
    falls: int

    def completed_cues(self, dancer: int) -> list[Cue]:
        """Cues of a dancer that were completed before the recording ended."""
        name = dancer_name(dancer)
        end_s = self.t_s[-1]
        return [
            cue for cue in self.cues if cue.dancer == name and cue.t_s + cue.duration_s + COMPLETION_MARGIN_S < end_s
        ]


def motion_figures(recordings: Sequence[MotionRecording]) -> dict[str, float]:
    """Figures over several recordings.

    Returns:
        figures by name. Errors of the pelvis, tether and load on the feet are those of the worst dancer; figures of
        events and of foot slip are pooled over all dancers, and NaN if there is no such event.
    """
    parts = [(recording, dancer) for recording in recordings for dancer in range(len(recording.weight_n))]
    pelvis_m = [np.hypot(*(m.roots[:, d, :2] - m.planned_m[:, d, :2]).T) for m, d in parts]
    tether_n = [float(np.sqrt((m.tether[:, d, :2] ** 2).sum(axis=1).mean())) for m, d in parts]
    load_shares = [float(m.loads_n[:, d].mean() / m.weight_n[d]) for m, d in parts]

    errors: list[tuple[Kind, float]] = []
    for m, d in parts:
        errors += timing_errors(m.t_s, m.roots[:, d], m.hands_m[:, d], m.completed_cues(d))
    claps_s = np.array([error_s for kind, error_s in errors if kind is Kind.CLAP])
    crossings_s = np.array([error_s for kind, error_s in errors if kind is not Kind.CLAP])
    rises_s = np.concatenate([rise_times(m.t_s, m.roots[:, d], m.completed_cues(d)) for m, d in parts])
    slips_m = np.concatenate([foot_slips(m.t_s, m.feet_m[:, d], m.landing_s[:, d]) for m, d in parts])

    return {
        "dances": len(recordings),
        "dances_without_a_fall": sum(recording.falls == 0 for recording in recordings),
        "falls": sum(recording.falls for recording in recordings),
        "pelvis_error_mean_mm": 1e3 * max(float(error_m.mean()) for error_m in pelvis_m),
        "pelvis_error_max_mm": 1e3 * max(float(error_m.max()) for error_m in pelvis_m),
        "tether_rms_n": max(tether_n),
        "feet_load_share": min(load_shares),
        "crossing_bias_ms": 1e3 * _mean(crossings_s),
        "crossing_p95_ms": 1e3 * _absolute_p95(crossings_s),
        "crossings_missing": int(np.isnan(crossings_s).sum()),
        "clap_p95_ms": 1e3 * _absolute_p95(claps_s),
        "claps_missing": int(np.isnan(claps_s).sum()),
        "rise_p95_s": _absolute_p95(rises_s),
        "slip_median_mm": 1e3 * float(np.median(slips_m)) if len(slips_m) else math.nan,
        "slip_p95_mm": 1e3 * _absolute_p95(slips_m),
    }


def _mean(values: Array) -> float:
    """Mean of the values that are not NaN; NaN if there are none."""
    known = values[~np.isnan(values)]
    return float(known.mean()) if len(known) else math.nan


def _absolute_p95(values: Array) -> float:
    """95th percentile of the absolute values that are not NaN; NaN if there are none."""
    known = np.abs(values[~np.isnan(values)])
    return float(np.percentile(known, 95)) if len(known) else math.nan
