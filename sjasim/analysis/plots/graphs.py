"""Group topology graphs of all iterations."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...core import ROBOT, Array
from ...record.rerun.explanation import Graph
from .figure import agent_colour, empty_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def graphs_figure(iterations: Sequence[Graph]) -> Figure:
    """Group topology graph of every iteration: the wider a line, the more synchronous its pair."""
    columns = min(4, max(1, len(iterations)))
    lines = -(-max(1, len(iterations)) // columns)

    # The title needs a width of 6.4.
    figure = empty_figure(max(6.4, 2.7 * columns + 0.4), 3.2 * lines)
    panels = np.atleast_1d(figure.subplots(lines, columns, squeeze=False)).ravel()
    for axes in panels:
        axes.set_axis_off()
    for axes, graph in zip(panels, iterations, strict=False):
        _draw_graph(axes, graph)
    figure.suptitle("Synchrony of pairs in each iteration (Q, 0 to 1); arrow: whom the robot followed", fontsize=10)
    return figure


def _draw_graph(axes: Axes, graph: Graph) -> None:
    """Draw one topology graph; agents stand on a circle."""
    angles = np.pi / 2 + 2 * np.pi * np.arange(len(graph.agents)) / len(graph.agents)
    positions: Array = np.stack([np.cos(angles), np.sin(angles)], axis=1)

    for i in range(len(positions)):
        for j in range(i):
            weight = float(graph.pairs[i, j])
            ends = zip(positions[i], positions[j], strict=True)
            axes.plot(*ends, color="0.6", linewidth=0.3 + 6 * weight, zorder=1)
            # Labels stand off the middle of a line, where the diagonals cross.
            x, y = (0.66 * positions[i] + 0.34 * positions[j]).tolist()
            box = {"facecolor": "white", "edgecolor": "none", "pad": 0.8}
            axes.text(x, y, f"{weight:.2f}", fontsize=7, ha="center", va="center", zorder=4, bbox=box)

    if graph.follows:
        robot = positions[graph.agents.index(ROBOT)]
        followed = positions[graph.agents.index(graph.follows)]
        tip = tuple(robot + 0.86 * (followed - robot))
        style = {"arrowstyle": "-|>", "color": "#E69F00", "linewidth": 2.5}
        axes.annotate("", xy=tip, xytext=tuple(robot), arrowprops=style, zorder=2)

    for position, agent in zip(positions, graph.agents, strict=True):
        axes.plot(*position, "o", color=agent_colour(agent), markersize=15, zorder=3)
        axes.text(1.62 * position[0], 1.32 * position[1], agent, ha="center", va="center", fontsize=8)
    axes.set(xlim=(-2.1, 2.1), ylim=(-1.6, 1.6), aspect="equal")
    axes.set_title(f"iteration {graph.iteration}: GSI {graph.gsi_full_edges:.2f} (full edges)", fontsize=9)
