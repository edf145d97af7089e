"""Parts of a session that follow from its configuration: the method's context, the iteration boundaries, the links."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from typing import NamedTuple

from ..choreography.timetable import Timetable
from ..config import FAULTS, SessionConfig
from ..core import ROBOT, RobotState, dancer_name
from ..core.clock import stream
from ..core.errors import ConfigError
from ..core.link import Link, LinkQuality, MessageQueue
from ..core.method_io import MethodContext
from .world import DownlinkMessage, UplinkMessage


class Boundary(NamedTuple):
    """Beginning or end of an iteration, for which a hook of the method is called.

    Attributes:
        t_s: session time [s].
        iteration: which iteration; 0 is the rehearsal.
        starts: True at the iteration's beat 0, False at the end of its window.
    """

    t_s: float
    iteration: int
    starts: bool


def iteration_boundaries(timetable: Timetable) -> deque[Boundary]:
    """Return all boundaries of a dance in order of time, followed by one at infinity.

    The boundary at infinity is never reached. With it, callers need not test for an empty queue.
    """
    iterations = range(timetable.first, timetable.last + 1)
    starts = [Boundary(timetable.start_s(iteration), iteration, True) for iteration in iterations]
    ends = [Boundary(timetable.close_s(iteration), iteration, False) for iteration in iterations]
    never = Boundary(math.inf, timetable.last + 1, False)

    return deque([*sorted(starts + ends), never])


def method_context(config: SessionConfig, timetable: Timetable) -> MethodContext:
    """Return the context that the session's method receives before the dance."""
    iterations = range(config.iterations + 1)

    return MethodContext(
        cast=tuple(dancer_name(index) for index in range(config.dancers)),
        steps=timetable.choreography.steps(),
        iterations=config.iterations,
        beat_s=60.0 / config.dance.bpm,
        iteration_start_s=tuple(timetable.start_s(iteration) for iteration in iterations),
        window_end_s=tuple(timetable.close_s(iteration) for iteration in iterations),
        tempo=timetable.tempo.shifted(timetable.lead_in_s),
        tau_s=config.synchrony.tau_s,
    )


def check_fault_targets(config: SessionConfig, sensors: Sequence[str]) -> None:
    """Check that every fault of the configuration names a dancer, sensor or robot of the session.

    Raises:
        ConfigError: a fault's target does not exist, or is not of the kind that the fault applies to.
    """
    dancers = [dancer_name(index) for index in range(config.dancers)]

    for index, fault in enumerate(config.faults):
        allowed = {"dancer": dancers, "robot": [ROBOT]}.get(FAULTS[fault.kind], sensors)
        if fault.target not in allowed:
            raise ConfigError(f"faults[{index}].target", fault.target, f"for {fault.kind} one of {', '.join(allowed)}")


class SessionLinks:
    """The network between the server and its devices: an uplink and a downlink for each sensor client and the robot.

    Every link draws its delays and losses from a random stream of its own, so that more traffic on one link leaves
    the others as they are.

    Args:
        config: the session's; ``config.network`` sets latency, jitter and packet loss.
        sensors: names of the sensors.

    Attributes:
        uplink: messages under way to the server.
        downlink: messages under way to the devices.
    """

    def __init__(self, config: SessionConfig, sensors: Sequence[str]) -> None:
        network = config.network
        down = LinkQuality(network.latency_s, network.jitter_s, network.packet_loss)
        up = LinkQuality(network.latency_s + network.uplink_asymmetry_s, network.jitter_s, network.packet_loss)

        self.uplink = MessageQueue[UplinkMessage]()
        self.downlink = MessageQueue[DownlinkMessage]()

        seed = config.seed
        devices = (*sensors, ROBOT)
        self._up = {name: Link(up, stream(seed, "link", name, "up"), self.uplink) for name in devices}
        self._down = {name: Link(down, stream(seed, "link", name, "down"), self.downlink) for name in devices}

    def send_up(self, t_s: float, message: UplinkMessage) -> None:
        """Send a device's message to the server at session time ``t_s``."""
        sender = ROBOT if isinstance(message, RobotState) else message.sensor
        self._up[sender].send(t_s, message)

    def send_down(self, t_s: float, device: str, message: DownlinkMessage) -> None:
        """Send a message of the server to a device at session time ``t_s``."""
        self._down[device].send(t_s, message)
