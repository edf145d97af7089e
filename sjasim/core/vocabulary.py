"""Array types, names of agents, and enumerations of moves, kinds of events and tracking states."""

from __future__ import annotations

from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

ROBOT = "robot"
"""Name of the robot in all data. Dancers are ``dancer_1``, ``dancer_2``, ..."""


def dancer_name(index: int) -> str:
    """Return the name of the dancer with an index from 0: ``dancer_name(0) == "dancer_1"``."""
    return f"dancer_{index + 1}"


class Move(StrEnum):
    """Moves of a dancer or of the robot."""

    FORWARD = "forward"
    BACKWARD = "backward"
    STOP = "stop"
    CLAP = "clap"
    TURN = "turn"
    DRIVE = "drive"
    """Motion of the robot with a given speed and yaw rate; scores do not contain it."""


class Kind(StrEnum):
    """Kinds of events. Synchrony measures treat TURN, which the robot performs where dancers clap, as CLAP.

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
"""The five kinds for which synchrony is measured."""


class TrackingState(StrEnum):
    """Tracking state of a joint, as in the Kinect SDK. `Skeletons.state` contains the codes 0, 1, 2 in this order."""

    NOT_TRACKED = "not_tracked"
    INFERRED = "inferred"
    TRACKED = "tracked"


NOT_TRACKED = 0
INFERRED = 1
TRACKED = 2
