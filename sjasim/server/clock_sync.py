"""How far a client's clock is from the server's: exchanges of four time stamps, the quickest of which count.

A reading is modelled as ``t_device = t + offset + drift (t - origin)``. The error of one exchange is half the
difference of its two one-way delays, so it never exceeds half the round trip; a constant asymmetry of the link
cannot be seen from inside and biases the offset by half of it.

Source: mills1991 (four time stamps, minimum-delay filter), with a least-squares line for the drift.
"""

from __future__ import annotations

import math
from collections import deque

from ..core import SyncReply

BUCKET = 8
"""LinkMonitor among which the quickest is kept: 2 s at 4 Hz."""

KEPT = 16
"""Quickest exchanges the line is fitted to: about half a minute at 4 Hz."""

FEW = 3
"""With fewer buckets than these every exchange counts, and the clock is not yet settled."""

MANY = 8
"""With so many buckets their round trips tell how far the estimate can be wrong."""

DRIFT_SD = 2e-4
"""What is expected of a drift before any exchange (s.d.; assumed: a PC's quartz has 5e-5): a few seconds of exchanges,
whose own error looks like a larger drift, do not say much against it."""

DELAY_FLOOR_S = 0.002
"""By how much the quickest exchange of all is still thought to be delayed [s]; assumed."""

LONG_GAP_S = 6.0
"""After so long without an exchange the clock's drift is allowed for before a jump is called one [s]."""

MARGIN_S = 0.005
"""What a jump must exceed beyond the delay bound [s]."""

MAX_DRIFT = 1e-3
"""Relative rate error no clock exceeds: what an old estimate may have gone wrong by per second."""

Sample = tuple[float, float, float]
"""Session time of the exchange's middle [s], offset [s], round trip [s]."""


class ClockSync:
    """Estimate of one client's clock.

    Until the first exchange it is unlocked and a device time means nothing.
    """

    __slots__ = ("_best", "_drift", "_mean", "_offset_s", "_origin_s", "_quickest", "_recent", "_round_trip_s")

    def __init__(self) -> None:
        self._best: deque[Sample] = deque(maxlen=KEPT)
        self._recent: list[Sample] = []
        self._quickest: Sample = (0.0, 0.0, math.inf)
        self._origin_s = 0.0
        self._offset_s = 0.0
        self._drift = 0.0
        self._mean = (0.0, 0.0)
        self._round_trip_s = math.inf

    @property
    def locked(self) -> bool:
        """Whether there is an estimate."""
        return bool(self._best or self._recent)

    @property
    def settled(self) -> bool:
        """Whether it has had exchanges enough since it began or jumped."""
        return len(self._best) >= FEW

    @property
    def offset_s(self) -> float:
        """Device clock minus session clock, at the time of the last exchange [s]."""
        return self._offset_s

    @property
    def drift(self) -> float:
        """Relative rate error; near 0 until the exchanges span some ten seconds (`DRIFT_SD`)."""
        return self._drift

    @property
    def round_trip_s(self) -> float:
        """Quickest round trip among the samples held [s]; infinite while unlocked."""
        return self._round_trip_s

    def session_time(self, t_device_s: float) -> float:
        """Session time of a device time, by the present estimate [s]."""
        return self._origin_s + (t_device_s - self._offset_s - self._origin_s) / (1.0 + self._drift)

    def add(self, reply: SyncReply, t_arrival_s: float) -> float:
        """Take in an exchange.

        Args:
            reply: what the client sent back.
            t_arrival_s: session time of its arrival.

        Returns:
            0, or the size of the jump the clock has made [s]: the exchange then lies so far from the estimate that
            no delay can explain it, and everything older is forgotten. An impossible exchange (negative round
            trip, as one that spans the jump) is ignored.
        """
        delay = (t_arrival_s - reply.t_server_send_s) - (reply.t_device_send_s - reply.t_device_receive_s)
        if delay < -MARGIN_S:
            return 0.0
        delay = max(delay, 0.0)
        offset = (reply.t_device_receive_s - reply.t_server_send_s + reply.t_device_send_s - t_arrival_s) / 2
        middle = (reply.t_server_send_s + t_arrival_s) / 2
        jump = self._jump(middle, offset, delay)
        if jump:
            self._best.clear()
            self._recent.clear()
            self._drift = 0.0
        sample = (middle, offset, delay)
        quicker = not self._recent or delay < self._quickest[2]
        self._recent.append(sample)
        if quicker:
            self._quickest = sample
        if quicker or not self.settled:
            self._fit()
        mean_t, mean_o = self._mean
        self._origin_s = middle
        self._offset_s = mean_o + self._drift * (middle - mean_t)
        if len(self._recent) >= BUCKET:
            self._best.append(self._quickest)
            self._recent.clear()
        return jump

    def _jump(self, middle: float, offset: float, delay: float) -> float:
        """How far an exchange lies from the estimate, if no delays can explain it, else 0.

        Neither errs by more than half of what its exchanges took longer than the quickest possible, which is a little
        less than the quickest that is held; while few are held, by half of all that they took.
        """
        if not self.locked:
            return 0.0
        age = middle - self._origin_s
        change = offset - (self._offset_s + self._drift * age)
        if len(self._best) >= MANY:
            slowest = max([held for _, _, held in self._best])
            unsure = max(delay - self._round_trip_s, 0.0) / 2 + slowest - self._round_trip_s
        else:
            unsure = (delay + self._round_trip_s) / 2
        bound = unsure + MARGIN_S + (0.0 if age < LONG_GAP_S else MAX_DRIFT * age)
        return change if abs(change) > bound else 0.0

    def _fit(self) -> None:
        """A line through the quickest exchanges, whose slope is a quartz's unless they say otherwise.

        The error of an exchange with so much more delay than need be is spread evenly over half that to both sides;
        a slow one therefore weighs little.
        """
        samples = [*self._best, *((self._quickest,) if self.settled else self._recent)]
        quickest = min([delay for _, _, delay in samples])
        weight = mean_t = mean_o = 0.0
        weights = []
        for time, offset, delay in samples:
            w = 12.0 / (DELAY_FLOOR_S + delay - quickest) ** 2
            weights.append(w)
            weight += w
            mean_t += w * time
            mean_o += w * offset
        mean_t /= weight
        mean_o /= weight
        across, along = 0.0, 1.0 / DRIFT_SD**2
        for w, (time, offset, _) in zip(weights, samples, strict=True):
            along += w * (time - mean_t) ** 2
            across += w * (time - mean_t) * (offset - mean_o)
        self._drift = max(-MAX_DRIFT, min(MAX_DRIFT, across / along))
        self._mean = mean_t, mean_o
        self._round_trip_s = quickest
