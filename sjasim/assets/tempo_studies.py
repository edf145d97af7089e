"""Values that three studies of spontaneous tempo report, and the spontaneous periods of their participants.

Periods are those of spontaneous performance, from one tone to the next. Values, standard errors and periods are read
from the studies' figures, as roman2023 gives them.

Source: roman2023.
"""

from __future__ import annotations

from collections.abc import Mapping

PACED_PERIODS_MS = (
    250.0, 260.0, 300.0, 310.0, 325.0, 340.0, 345.0, 350.0, 380.0, 400.0,
    410.0, 430.0, 440.0, 450.0, 460.0, 465.0, 475.0, 480.0, 600.0, 650.0,
)  # fmt: skip
"""Spontaneous periods of 20 musicians who played with a metronome. Source: scheurich2018."""

PACED_ASYNCHRONY_MS: Mapping[float, tuple[float, float]] = {
    0.70: (10.5, 1.0),
    0.85: (7.5, 1.0),
    1.15: (-3.5, 1.5),
    1.30: (-6.5, 2.0),
}
"""Metronome's period over the spontaneous one -> mean asynchrony less that at the spontaneous rate, its standard error.

Source: scheurich2018.
"""

UNPACED_PERIODS_MS = (
    320.0, 350.0, 355.0, 359.0, 382.0, 390.0, 390.0, 415.0, 418.0, 430.0, 435.0, 438.0,
    439.0, 439.0, 443.0, 445.0, 455.0, 457.0, 462.0, 470.0, 475.0, 525.0, 572.0, 665.0,
)  # fmt: skip
"""Spontaneous periods of 24 pianists who played without a metronome. Source: zamm2018."""

UNPACED_CHANGES_MS: Mapping[str, tuple[float, ...]] = {
    "faster": (
        -130.0, -155.0, -85.0, -115.0, -120.0, -195.0, -130.0, -145.0, -185.0, -205.0, -125.0, -215.0,
        -205.0, -235.0, -135.0, -155.0, -100.0, -210.0, -205.0, -225.0, -220.0, -265.0, -210.0, -435.0,
    ),
    "fast": (
        -95.0, -95.0, -40.0, -55.0, -70.0, -150.0, -75.0, -120.0, -110.0, -120.0, -60.0, -125.0,
        -120.0, -195.0, -85.0, -75.0, -45.0, -110.0, -100.0, -100.0, -80.0, -165.0, -120.0, -320.0,
    ),
    "slow": (
        190.0, 195.0, 65.0, 95.0, 110.0, 215.0, 85.0, 70.0, 220.0, 85.0, 15.0, 145.0,
        155.0, 220.0, 55.0, 95.0, 65.0, 125.0, 130.0, 160.0, 110.0, 175.0, 70.0, 320.0,
    ),
    "slower": (
        250.0, 280.0, 480.0, 340.0, 320.0, 520.0, 260.0, 300.0, 495.0, 330.0, 50.0, 330.0,
        280.0, 420.0, 365.0, 215.0, 145.0, 495.0, 205.0, 570.0, 230.0, 780.0, 120.0, 705.0,
    ),
}  # fmt: skip
"""Rate of a performance -> difference of each pianist's first period from the spontaneous one. Source: zamm2018."""

UNPACED_SLOPE_MS: Mapping[str, tuple[float, float]] = {
    "faster": (0.075, 0.015),
    "fast": (0.030, 0.015),
    "slow": (-0.020, 0.020),
    "slower": (-0.195, 0.030),
}
"""Rate -> mean change of the interval per tone less that at the spontaneous rate, its standard error.

Source: zamm2018.
"""

DUET_PERIODS_MS: Mapping[str, tuple[tuple[float, float], ...]] = {
    "matching": (
        (269.0, 278.0), (280.0, 289.0), (350.0, 359.0), (343.0, 352.0), (373.0, 380.0),
        (376.0, 384.0), (398.0, 407.0), (420.0, 429.0), (433.0, 440.0), (451.0, 460.0),
    ),
    "mismatching": (
        (180.0, 310.0), (210.0, 340.0), (215.0, 330.0), (220.0, 380.0), (280.0, 410.0),
        (310.0, 460.0), (330.0, 462.0), (350.0, 470.0), (340.0, 500.0), (420.0, 520.0),
    ),
}  # fmt: skip
"""Kind of pair -> spontaneous periods of the two pianists of each of 10 duets. Source: zamm2016."""

DUET_ASYNCHRONY_MS: Mapping[str, tuple[tuple[float, float], ...]] = {
    "matching": ((17.5, 0.8), (16.5, 0.6), (16.3, 0.7), (17.2, 1.0)),
    "mismatching": ((24.7, 2.3), (21.5, 1.5), (21.0, 1.5), (21.9, 1.5)),
}
"""Kind of pair -> mean absolute asynchrony in each repetition of the melody, its standard error. Source: zamm2016."""

DUET_METRONOME_MS = 400.0
"""Period of the metronome that sets the tempo of a duet. Source: zamm2016."""
