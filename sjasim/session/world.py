"""Protocol of a world: the dancers, robot and sensors of a session, simulated or real, seen from the session loop.

A world implements `World` and registers a factory under the name that ``config.fidelity`` gives. The session sends it
messages for its devices (`World.deliver`), lets it run (`World.advance`), and takes the messages that the devices
send. Methods never see a world.
"""

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
"""A message to a device: the robot's commands, and clock requests and orders for the sensor clients."""

UplinkMessage = DeviceEvent | ClientStatus | SyncReply | RobotState
"""A message from a device: events, status reports and clock replies of the sensor clients, and the robot's odometry."""


class Recorder(Protocol):
    """Ground truth of a session, as columns and arrays; a world without ground truth returns empty ones."""

    def truth(self) -> dict[str, NDArray[np.generic]]:
        """Columns of equal length, one row for each logged tick and dancer."""
        ...

    def odometry(self) -> dict[str, Array]:
        """Columns of equal length, one row for each odometry sample."""
        ...

    def joints(self) -> NDArray[np.float32]:
        """(F, D, 25, 3) true joint positions in the world at frame rate [m]."""
        ...

    def skeletons(self) -> NDArray[np.float32]:
        """(F, D, 25, 4) joint positions that the active sensor estimated, in the world [m], and tracking states."""
        ...


class World(Protocol):
    """Dancers, robot and sensors of one session.

    Attributes:
        continuous: whether the devices report all the time: status, clocks, odometry. The devices of a world that is
            not continuous send events and little else, with session time as their clock. The session then neither
            exchanges clocks nor repeats orders and commands, and nobody counts as dead because of silence.
        active: name of the sensor whose skeletons and visibility are recorded; the session sets it.
        end_s: session time at which the dance is over [s].
        cues: what the dancers have planned so far.
        notices: what has gone wrong so far.
        watchers: functions that are called with the session time at every frame. They observe and change nothing.
    """

    continuous: bool
    active: str
    end_s: float
    cues: list[Cue]
    notices: list[Notice]
    watchers: list[Callable[[float], None]]

    @property
    def robot_events(self) -> list[AgentEvent]:
        """What the robot has done so far, from its odometry."""
        ...

    @property
    def recorder(self) -> Recorder:
        """The ground truth recorded so far."""
        ...

    @property
    def time_s(self) -> float:
        """Session time that has been reached [s]."""
        ...

    def next_instant_s(self, t_s: float) -> float:
        """First instant of the world's clock that is not before a session time [s].

        The session processes what is due at such instants only, so that its outcome does not depend on how it is
        divided into calls. A simulated world returns a tick of its physics; a world without ticks returns ``t_s``.
        """
        ...

    def deliver(self, now_s: float, t_arrival_s: float, message: DownlinkMessage) -> SyncReply | None:
        """Hand a message to the device that it is for.

        Args:
            now_s: instant at which the session processes the message; not after the world's own time, and after the
                last control step or frame of the devices.
            t_arrival_s: session time at which the message arrived, for time stamps.
            message: what arrived.

        Returns:
            the device's immediate reply, sent at ``now_s``, or None.
        """
        ...

    def latest_frame(self, sensor: str) -> SkeletonFrame | None:
        """The last frame that a sensor's client has processed; None before the first."""
        ...

    def advance(self, until_s: float) -> list[UplinkMessage]:
        """Run the devices that are due now, then go on to the next instant at which a device is due.

        Args:
            until_s: session time to reach at most. A device that is due then runs in the next call.

        Returns:
            what the devices sent at the instant at which the call began.
        """
        ...
