"""Words that every room uses: arrays, names, moves, events, states of a joint."""

from __future__ import annotations

from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


IntArray = NDArray[np.int64]


BoolArray = NDArray[np.bool_]


ROBOT = "robot"
"""The robot's name wherever an agent is named; dancers are ``dancer_1``, ``dancer_2``, ..."""


def dancer_name(index: int) -> str:
    """Name of the dancer with this index, counted from 0: ``dancer_name(0) == "dancer_1"``."""
    return f"dancer_{index + 1}"


class Move(StrEnum):
    """What a dancer or the robot can be asked to do."""

    FORWARD = "forward"
    BACKWARD = "backward"
    STOP = "stop"
    CLAP = "clap"
    TURN = "turn"
    DRIVE = "drive"
    """The robot only, and only from outside the score: a speed and a yaw rate of the driver's choice."""


class Kind(StrEnum):
    """What can be seen to happen. A robot's turn counts as its clap in every synchrony measure.

    Source: iqbal2016, section IV-B.
    """

    START_FORWARD = "start_forward"
    STOP_FORWARD = "stop_forward"
    START_BACKWARD = "start_backward"
    STOP_BACKWARD = "stop_backward"
    CLAP = "clap"
    TURN = "turn"


SYNCHRONY_KINDS = (
    Kind.START_FORWARD,
    Kind.STOP_FORWARD,
    Kind.START_BACKWARD,
    Kind.STOP_BACKWARD,
    Kind.CLAP,
)
"""The five kinds that enter the synchrony measures."""


class TrackingState(StrEnum):
    """How a skeleton's joint is known; the numbers in `Skeletons.state` are the codes below, in this order."""

    NOT_TRACKED = "not_tracked"
    INFERRED = "inferred"
    TRACKED = "tracked"


NOT_TRACKED, INFERRED, TRACKED = 0, 1, 2
