"""The compiled occlusion test, applied to points of several owners from a sensor at any position."""

from __future__ import annotations

import numpy as np

from sjasim.core import Solids
from sjasim.sensors.raycast.occlusion import PROJECTED_COLUMNS, mark_occluded, project_geoms


def occluded(
    origin: np.ndarray, points: np.ndarray, owners: np.ndarray, body_depth_m: np.ndarray, geoms: Solids
) -> np.ndarray:
    """Return (N,) whether something occludes each of the points (N, 3) from a sensor that faces their middle."""
    view = points.mean(axis=0) - origin
    left = np.cross([0.0, 0.0, 1.0], view)
    axes = np.array([axis / np.linalg.norm(axis) for axis in (left, np.cross(view, left), view)])
    sensor = np.concatenate([axes.ravel(), origin])
    projected = np.empty((len(geoms.rows), PROJECTED_COLUMNS))
    project_geoms(sensor, *geoms, projected)

    local = (points - origin) @ axes.T
    assert (local[:, 2] > 0.0).all()
    visible = np.ones(len(points), dtype=bool)
    for owner in np.unique(owners):
        rows = np.flatnonzero(owners == owner)
        marks = visible[rows]
        mark_occluded(local[rows], owner, body_depth_m[rows], geoms.rows, geoms.shape, projected, marks)
        visible[rows] = marks
    return ~visible
