"""Configuration of the network: delays and losses of messages."""

from __future__ import annotations

from dataclasses import dataclass

from .checks import within


@dataclass(frozen=True, slots=True)
class NetworkConfig:
    """The local network between sensor clients, server and robot.

    Attributes:
        latency_s: smallest one-way delay [s].
        jitter_s: mean of the exponentially distributed delay that is added to the latency [s].
        packet_loss: probability that a message is lost.
        uplink_asymmetry_s: additional delay from client to server only [s]. It biases clock synchronisation by half of
            its value.
        sync_hz: clock exchanges per second and client [Hz].
        heartbeat_hz: rate at which the server repeats the robot's current command [Hz].
    """

    latency_s: float = 0.015
    jitter_s: float = 0.005
    packet_loss: float = 0.001
    uplink_asymmetry_s: float = 0.0
    sync_hz: int = 4
    heartbeat_hz: int = 5

    def __post_init__(self) -> None:
        within("network.latency_s", self.latency_s, 0.0, 2.0)
        within("network.jitter_s", self.jitter_s, 0.0, 2.0)
        within("network.packet_loss", self.packet_loss, 0.0, 0.9)
        within("network.uplink_asymmetry_s", self.uplink_asymmetry_s, 0.0, 1.0)
        within("network.sync_hz", self.sync_hz, 1, 50)
        within("network.heartbeat_hz", self.heartbeat_hz, 2, 50)
