"""Values that the published study reports: group synchrony by group and iteration, and the robot's timing.

Nine groups of three people danced four iterations with the robot under each method.

Source: iqbal2016, sections VI-A and VI-B.
"""

from __future__ import annotations

from collections.abc import Mapping

GSI: Mapping[str, tuple[tuple[float, float, float, float], ...]] = {
    "eca": (
        (0.39, 0.30, 0.15, 0.33),
        (0.28, 0.39, 0.63, 0.54),
        (0.37, 0.48, 0.59, 0.37),
        (0.30, 0.37, 0.37, 0.28),
        (0.31, 0.39, 0.52, 0.30),
        (0.50, 0.41, 0.40, 0.33),
        (0.41, 0.42, 0.35, 0.52),
        (0.78, 0.40, 0.41, 0.41),
        (0.56, 0.35, 0.42, 0.46),
    ),
    "sia": (
        (0.40, 0.26, 0.63, 0.52),
        (0.66, 0.37, 0.51, 0.71),
        (0.40, 0.52, 0.62, 0.55),
        (0.20, 0.38, 0.30, 0.28),
        (0.24, 0.44, 0.59, 0.46),
        (0.43, 0.45, 0.32, 0.46),
        (0.25, 0.29, 0.66, 0.68),
        (0.32, 0.48, 0.72, 0.56),
        (0.35, 0.34, 0.46, 0.59),
    ),
}
"""Method -> group synchronisation index of each group in iterations 1 to 4.

Source: iqbal2016, table I.
"""

GSI_GROUP_MEANS: Mapping[str, tuple[float, ...]] = {
    "eca": (0.29, 0.46, 0.45, 0.33, 0.38, 0.41, 0.42, 0.50, 0.45),
    "sia": (0.45, 0.56, 0.52, 0.29, 0.43, 0.41, 0.47, 0.52, 0.44),
}
"""Method -> mean index of each group as printed; it agrees with the mean of `GSI` up to rounding.

Source: iqbal2016, table I.
"""

ITERATIONS_WON = (22, 36)
"""Iterations in which the index is higher under SIA than under ECA, and number of iterations."""

GROUPS_WON = (7, 9)
"""Groups whose mean index is higher under SIA than under ECA, and number of groups."""

RATINGS_AGREE = (7, 9)
"""Groups in which two of three dancers rated that session as more synchronous which had the higher index."""

TA_MEAN_S: Mapping[str, float] = {"eca": 0.70, "sia": 0.54}
"""Method -> mean timing appropriateness [s]."""

TA_SD_S: Mapping[str, float] = {"eca": 0.50, "sia": 0.59}
"""Method -> standard deviation of timing appropriateness [s]."""

TA_SHARE_WITHIN: Mapping[str, Mapping[float, float]] = {
    "eca": {1.2: 0.8188, 1.6: 0.90},
    "sia": {0.8: 0.8165, 1.2: 0.9082},
}
"""Method -> distance from the ideal time [s] -> share of the robot's events within it."""

TA_BIN_S = 0.1
"""Width of the bins of the published histograms of timing appropriateness [s]."""

TA_LAST_EDGE_S = 2.5
"""End of the last bin of the published histograms [s]."""

WILCOXON_Z = -4.399
"""Statistic of the signed rank test on the timing appropriateness of the two methods."""

WILCOXON_R = -0.18
"""Effect size of that test."""
