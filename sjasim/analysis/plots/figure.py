"""What all figures share: an empty figure, and the colours of agents and sessions."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...assets.colours import ROBOT as ROBOT_COLOUR
from ...assets.colours import dancer_colour
from ...core import ROBOT

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SESSION_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7")
"""Colours of the sessions that a figure compares, in their order; colour-blind people can distinguish them."""

Colour = tuple[float, ...]
"""Red, green and blue from 0 to 1."""


def agent_colour(agent: str) -> Colour:
    """Colour of a dancer or the robot."""
    value = ROBOT_COLOUR if agent == ROBOT else dancer_colour(int(agent.rpartition("_")[2]) - 1)
    return tuple(part / 255 for part in value)


def empty_figure(width: float, height: float) -> Figure:
    """A figure that is independent of pyplot's state and of window systems; size in inches."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure as MatplotlibFigure

    figure = MatplotlibFigure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure
