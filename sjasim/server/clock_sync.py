"""Estimation of a client's clock from exchanges of four time stamps, of which the quickest carry the most weight.

The device clock is modelled as ``t_device = t + offset + drift (t - origin)`` with session time ``t``. The error of
one exchange is half the difference of its two one-way delays, so it never exceeds half of the round trip. A constant
asymmetry of the link cannot be observed and biases the offset by half of it.

Source: mills1991 (four time stamps, minimum-delay filter); the drift comes from a weighted least-squares line instead.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from typing import NamedTuple

from ..core import SyncReply

BUCKET_SIZE = 8
"""Number of consecutive exchanges of which only the quickest is kept: 2 s at 4 Hz."""

MAX_KEPT = 16
"""Number of kept exchanges that the line is fitted to: about half a minute at 4 Hz."""

MIN_KEPT = 3
"""Number of kept exchanges from which the clock counts as settled. Before, every exchange is used."""

MIN_KEPT_FOR_SPREAD = 8
"""Number of kept exchanges from which the spread of their round trips bounds the error of the estimate."""

DRIFT_SD = 2e-4
"""Prior standard deviation of the drift (assumed; the quartz of a PC has 5e-5).

It keeps the noise of the first few seconds from looking like a large drift.
"""

DELAY_FLOOR_S = 0.002
"""Extra delay that even the quickest exchange is assumed to have [s] (assumed); it keeps weights finite."""

LONG_GAP_S = 6.0
"""Time without an exchange from which the uncertainty of the drift is added before a jump is reported [s]."""

MARGIN_S = 0.005
"""Smallest deviation beyond the bound of the delays that counts as a jump of the clock [s]."""

MAX_DRIFT = 1e-3
"""Largest relative rate error of a clock; bounds the estimate and the error that it gains per second."""


class Sample(NamedTuple):
    """One clock exchange.

    Attributes:
        t_s: session time of its middle [s].
        offset_s: device clock minus session clock [s].
        round_trip_s: round trip time without the device's own processing [s].
    """

    t_s: float
    offset_s: float
    round_trip_s: float


class ClockSync:
    """Estimate of one client's clock; unlocked until the first exchange."""

    __slots__ = (
        "_bucket", "_centroid", "_drift", "_kept", "_offset_s", "_origin_s", "_quickest", "_round_trip_s",
    )  # fmt: skip

    def __init__(self) -> None:
        self._kept: deque[Sample] = deque(maxlen=MAX_KEPT)
        self._bucket: list[Sample] = []
        self._quickest = Sample(0.0, 0.0, math.inf)
        """The quickest exchange of the present bucket."""
        self._origin_s = 0.0
        self._offset_s = 0.0
        self._drift = 0.0
        self._centroid = (0.0, 0.0)
        """Weighted mean of the samples' times and offsets, through which the fitted line goes [s]."""
        self._round_trip_s = math.inf

    @property
    def locked(self) -> bool:
        """Whether there is an estimate."""
        return bool(self._kept or self._bucket)

    @property
    def settled(self) -> bool:
        """Whether there have been enough exchanges since the start or the last jump."""
        return len(self._kept) >= MIN_KEPT

    @property
    def offset_s(self) -> float:
        """Device clock minus session clock at the time of the last exchange [s]."""
        return self._offset_s

    @property
    def drift(self) -> float:
        """Relative rate error; near 0 until the exchanges span about ten seconds, see `DRIFT_SD`."""
        return self._drift

    @property
    def round_trip_s(self) -> float:
        """Shortest round trip among the samples held [s]; infinite while unlocked."""
        return self._round_trip_s

    def session_time(self, t_device_s: float) -> float:
        """Session time of a device time by the present estimate [s]; the device time itself while unlocked."""
        return self._origin_s + (t_device_s - self._offset_s - self._origin_s) / (1.0 + self._drift)

    def add(self, reply: SyncReply, t_arrival_s: float) -> float:
        """Update the estimate with an exchange.

        An exchange with a negative round trip is impossible, for instance one during which the clock jumped. It is
        ignored.

        Args:
            reply: what the client sent back.
            t_arrival_s: session time of its arrival [s].

        Returns:
            0, or the size of a jump of the clock [s]. A jump is reported when the exchange is farther from the
            estimate than delays can explain; all earlier exchanges are then discarded.
        """
        round_trip = (t_arrival_s - reply.t_server_send_s) - (reply.t_device_send_s - reply.t_device_receive_s)
        if round_trip < -MARGIN_S:
            return 0.0
        # Rounding and the clock's drift during the exchange can make a very short round trip slightly negative.
        round_trip = max(round_trip, 0.0)
        offset = (reply.t_device_receive_s - reply.t_server_send_s + reply.t_device_send_s - t_arrival_s) / 2
        middle = (reply.t_server_send_s + t_arrival_s) / 2
        sample = Sample(middle, offset, round_trip)

        jump = self._detect_jump(sample)
        if jump:
            self._kept.clear()
            self._bucket.clear()
            self._drift = 0.0

        is_quickest = not self._bucket or round_trip < self._quickest.round_trip_s
        self._bucket.append(sample)
        if is_quickest:
            self._quickest = sample

        # A slower exchange in a settled bucket is not used, so the line stays as it is.
        if is_quickest or not self.settled:
            self._fit_line()
        mean_t, mean_offset = self._centroid
        self._origin_s = middle
        self._offset_s = mean_offset + self._drift * (middle - mean_t)

        if len(self._bucket) >= BUCKET_SIZE:
            self._kept.append(self._quickest)
            self._bucket.clear()
        return jump

    def _detect_jump(self, sample: Sample) -> float:
        """Distance of an exchange from the estimate if delays cannot explain it [s], else 0.

        Exchange and estimate are each wrong by at most half of their round trip beyond the shortest possible one.
        With many kept exchanges the shortest of them stands for that; with few, the whole round trips bound the error.
        """
        if not self.locked:
            return 0.0
        age = sample.t_s - self._origin_s
        change = sample.offset_s - (self._offset_s + self._drift * age)

        if len(self._kept) >= MIN_KEPT_FOR_SPREAD:
            slowest = max([kept.round_trip_s for kept in self._kept])
            uncertainty = max(sample.round_trip_s - self._round_trip_s, 0.0) / 2 + slowest - self._round_trip_s
        else:
            uncertainty = (sample.round_trip_s + self._round_trip_s) / 2

        bound = uncertainty + MARGIN_S + (0.0 if age < LONG_GAP_S else MAX_DRIFT * age)
        return change if abs(change) > bound else 0.0

    def _fit_line(self) -> None:
        """Fit a weighted line to the exchanges held, with a Gaussian prior on its slope, the drift."""
        samples = [*self._kept, *((self._quickest,) if self.settled else self._bucket)]
        quickest = min([sample.round_trip_s for sample in samples])
        weights = _weights(samples, quickest)

        weight = mean_t = mean_offset = 0.0
        for w, sample in zip(weights, samples, strict=True):
            weight += w
            mean_t += w * sample.t_s
            mean_offset += w * sample.offset_s
        mean_t /= weight
        mean_offset /= weight

        covariance = 0.0
        variance = 1.0 / DRIFT_SD**2
        for w, sample in zip(weights, samples, strict=True):
            variance += w * (sample.t_s - mean_t) ** 2
            covariance += w * (sample.t_s - mean_t) * (sample.offset_s - mean_offset)

        # No quartz is worse; a larger estimate is noise.
        self._drift = max(-MAX_DRIFT, min(MAX_DRIFT, covariance / variance))
        self._centroid = (mean_t, mean_offset)
        self._round_trip_s = quickest


def _weights(samples: Sequence[Sample], quickest_s: float) -> list[float]:
    """Inverse variances of the samples' offsets [1/s^2].

    The offset error is uniform over plus and minus half of the extra delay, whose variance is its square over 12.
    """
    return [12.0 / (DELAY_FLOOR_S + sample.round_trip_s - quickest_s) ** 2 for sample in samples]
