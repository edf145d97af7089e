"""The network, the clocks, and the measure of synchrony."""

from __future__ import annotations

from dataclasses import dataclass

from .checks import within


@dataclass(frozen=True, slots=True)
class NetworkConfig:
    """The local network between clients, server and robot.

    Attributes:
        latency_s: shortest one-way delay.
        jitter_s: mean of the exponential delay on top of it.
        loss: probability that a message never arrives.
        uplink_extra_s: additional delay from client to server only; an asymmetric link biases every clock exchange.
        sync_hz: clock exchanges per second and client.
        heartbeat_hz: how often the server repeats the robot's current command.
    """

    latency_s: float = 0.015
    jitter_s: float = 0.005
    loss: float = 0.001
    uplink_extra_s: float = 0.0
    sync_hz: int = 4
    heartbeat_hz: int = 5

    def __post_init__(self) -> None:
        within("network.latency_s", self.latency_s, 0.0, 2.0)
        within("network.jitter_s", self.jitter_s, 0.0, 2.0)
        within("network.loss", self.loss, 0.0, 0.9)
        within("network.uplink_extra_s", self.uplink_extra_s, 0.0, 1.0)
        within("network.sync_hz", self.sync_hz, 1, 50)
        within("network.heartbeat_hz", self.heartbeat_hz, 2, 50)


@dataclass(frozen=True, slots=True)
class ClockConfig:
    """The clients' clocks.

    Attributes:
        offset_s: largest initial offset against the server, drawn evenly to both sides.
        drift: largest relative rate error, drawn evenly to both sides (a PC's quartz: some 50e-6).
    """

    offset_s: float = 0.5
    drift: float = 50e-6

    def __post_init__(self) -> None:
        within("clocks.offset_s", self.offset_s, 0.0, 3600.0)
        within("clocks.drift", self.drift, 0.0, 1e-3)


@dataclass(frozen=True, slots=True)
class SynchronyConfig:
    """The synchrony measures.

    Attributes:
        tau_s: window of an event pair (iqbal2016: .25 s).
        one_to_one: match events one to one, which bounds Q by 1; the paper's own equation does not.
    """

    tau_s: float = 0.25
    one_to_one: bool = False

    def __post_init__(self) -> None:
        within("synchrony.tau_s", self.tau_s, 0.001, 5.0)
