"""An eye anywhere, looking at points of several owners through the compiled sight."""

from __future__ import annotations

import numpy as np

from sjasim.core import Solids
from sjasim.sensors.raycast.occlusion import PROJECTED_COLUMNS, mark_occluded, project_geoms


def hidden(
    origin: np.ndarray, points: np.ndarray, whose: np.ndarray, flesh_m: np.ndarray, solids: Solids
) -> np.ndarray:
    """(N,) which points (N, 3) something hides; the eye looks at their middle."""
    away = points.mean(axis=0) - origin
    left = np.cross([0.0, 0.0, 1.0], away)
    axes = [axis / np.linalg.norm(axis) for axis in (left, np.cross(away, left), away)]
    eye = np.concatenate([*axes, origin])
    seen = np.empty((len(solids.rows), PROJECTED_COLUMNS))
    project_geoms(eye, *solids, seen)
    local = (points - origin) @ np.array(axes).T
    assert (local[:, 2] > 0.0).all()
    visible = np.ones(len(points), dtype=bool)
    for owner in np.unique(whose):
        rows = np.flatnonzero(whose == owner)
        marks = visible[rows]
        mark_occluded(local[rows], owner, flesh_m[rows], solids.rows, solids.shape, seen, marks)
        visible[rows] = marks
    return ~visible
