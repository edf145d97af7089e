"""Array types, names of agents, moves, kinds of events, tracking states of a joint."""

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
    """Moves of a dancer or of the robot."""

    FORWARD = "forward"
    BACKWARD = "backward"
    STOP = "stop"
    CLAP = "clap"
    TURN = "turn"
    DRIVE = "drive"
    """Any speed and yaw rate; a move of the robot only, which the score does not contain."""


class Kind(StrEnum):
    """Kinds of events that sensors detect. The robot's turn counts as its clap in every synchrony measure.

    Source: iqbal2016, section II-B for the human events.
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
"""The five kinds that synchrony measures use."""


class TrackingState(StrEnum):
    """How the position of a joint is known. `Skeletons.state` has the codes below, in this order."""

    NOT_TRACKED = "not_tracked"
    INFERRED = "inferred"
    TRACKED = "tracked"


NOT_TRACKED = 0
INFERRED = 1
TRACKED = 2
