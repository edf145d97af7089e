"""The protocol of a world: what stands between the robot's commands and the events that a session is told of."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ..core import (
    Array,
    ClientOrder,
    ClientStatus,
    Cue,
    DeviceEvent,
    MoveCommand,
    RobotState,
    SkeletonFrame,
    SyncReply,
    SyncRequest,
)
from ..core.session_log import AgentEvent, Notice

DownlinkMessage = MoveCommand | SyncRequest | ClientOrder
"""What arrives at a world's devices."""
UplinkMessage = DeviceEvent | ClientStatus | SyncReply | RobotState
"""What a world's devices send."""


class Recorder(Protocol):
    """Ground truth of a session, as columns and arrays; empty where a world has none."""

    def truth(self) -> dict[str, NDArray[np.generic]]:
        """One row for each tick and dancer."""
        ...

    def odometry(self) -> dict[str, Array]:
        """One row for each odometry sample."""
        ...

    def joints(self) -> NDArray[np.float32]:
        """(F, D, 25, 3) true joints at frame rate [m]."""
        ...

    def skeletons(self) -> NDArray[np.float32]:
        """(F, D, 25, 4) estimated joints in the world [m] and their tracking states."""
        ...


class World(Protocol):
    """Dancers, robot and sensors: the part of a session that methods never see.

    Attributes:
        active: name of the sensor whose skeletons and view are recorded; the session keeps it up to date.
        end_s: session time at which the dance is over.
        cues: what the dancers planned so far.
        robot_events: what the robot did so far.
        notices: what went wrong so far.
        watchers: functions that are called with the session time at every frame. They observe and change nothing.
    """

    active: str
    end_s: float
    cues: list[Cue]
    robot_events: list[AgentEvent]
    notices: list[Notice]
    watchers: list[Callable[[float], None]]

    @property
    def recorder(self) -> Recorder:
        """The ground truth."""
        ...

    @property
    def time_s(self) -> float:
        """Session time that has been reached [s]."""
        ...

    def next_instant_s(self, t_s: float) -> float:
        """The first instant that is not before a time: all that happens in a session happens at instants [s]."""
        ...

    def deliver(self, now_s: float, t_arrival_s: float, message: DownlinkMessage) -> SyncReply | None:
        """Hand a message to the device that it is for.

        Args:
            now_s: the instant at which it is dealt with: not after the present, and after the devices' last turn.
            t_arrival_s: session time at which it arrived, and was stamped.
            message: what arrived.

        Returns:
            the device's answer, sent at ``now_s``.
        """
        ...

    def latest_frame(self, sensor: str) -> SkeletonFrame | None:
        """The last frame that a sensor's client has processed; None before the first."""
        ...

    def advance(self, until_s: float) -> list[UplinkMessage]:
        """Give devices whose turn it is their turn, then go on to the next turn of any.

        Args:
            until_s: session time to reach at most; a turn that is due then is left to the next call.

        Returns:
            what the devices sent at the instant at which the call began.
        """
        ...
