"""The foreground of a depth image: the floor is removed, and points lie where they are."""

from __future__ import annotations

import pytest

from .panels import foreground_of


def test_the_floor_is_removed_and_points_lie_where_they_are():
    assert foreground_of().count == 0

    foreground = foreground_of((0.5, 3.0, 0.4, 1.7))
    points = foreground.point[: foreground.count]
    assert points[:, 2] == pytest.approx(3.0)
    assert points[:, 0].min() == pytest.approx(0.3, abs=0.02)
    assert points[:, 0].max() == pytest.approx(0.7, abs=0.02)
    assert points[:, 1].max() == pytest.approx(1.7, abs=0.02)
