"""Colours of dancers and robot in pictures, recordings and plots; colour-blind people can distinguish them.

They are red, green and blue from 0 to 255, from the palette of Okabe and Ito.
"""

from __future__ import annotations

DANCERS = ((213, 94, 0), (0, 158, 115), (0, 114, 178), (204, 121, 167), (230, 159, 0), (86, 180, 233))
"""Colours of the dancers in their order; the seventh dancer has the first colour again."""

ROBOT = (70, 70, 78)
"""Colour of the robot."""


def dancer_colour(index: int) -> tuple[int, int, int]:
    """Colour of the dancer with this index, counted from 0."""
    return DANCERS[index % len(DANCERS)]
