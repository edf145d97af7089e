"""A policy with hand-made weights."""

import numpy as np

from sjasim.anticipation.observation import MOVES, EventFeatures
from sjasim.core.method_io import ROBOT_MOVES

from ..contracts.test_anticipation import STEPS, context

WIDTH = len(EventFeatures(context()).row(0.0, 0, 0.0))


def write(path, lead=0.5, **changes):
    """Write a policy that chooses each move from ``lead`` beats before its beat, whatever the dancers do."""
    changing = len(STEPS) - 1
    moves = [MOVES.index(ROBOT_MOVES[step.kind]) for step in STEPS]
    w0, w1 = np.zeros((changing, WIDTH)), np.zeros((4, changing))
    w0[:, 0] = 1e4  # of the beat over 40: a switch
    for k in range(changing):
        w1[moves[k], k], w1[moves[k + 1], k] = -1.0, 1.0
    arrays = {
        "mean": np.zeros(WIDTH), "std": np.ones(WIDTH), "clip": 10.0, "step_hz": 10,
        "w0": w0, "b0": -1e4 * (np.array([step.beat for step in STEPS[1:]]) - lead) / 40.0,
        "w1": w1, "b1": np.eye(4)[moves[0]] + np.eye(4)[moves[-1]],
    }  # fmt: skip
    np.savez(path, **{key: value for key, value in {**arrays, **changes}.items() if value is not None})
    return str(path)
