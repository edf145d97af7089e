"""Colours of dancers and robot, the same in pictures, recordings and plots, and told apart by colour-blind eyes.

Red, green, blue from 0 to 255, from the palette of Okabe and Ito.
"""

from __future__ import annotations

DANCERS = ((213, 94, 0), (0, 158, 115), (0, 114, 178), (204, 121, 167), (230, 159, 0), (86, 180, 233))
"""Clothes, lines and lanes of the dancers, in the order of the cast; beyond the sixth they begin anew."""

ROBOT = (70, 70, 78)


def dancer_colour(index: int) -> tuple[int, int, int]:
    """Colour of the dancer with this index, counted from 0."""
    return DANCERS[index % len(DANCERS)]
