"""Detection of links that lose packets, from the share of clock requests that are not answered."""

from __future__ import annotations

from collections import deque

from ..core.session_log import Notice

TIMEOUT_S = 1.0
"""A clock request that is not answered within this time counts as lost [s]."""

WINDOW = 40
"""Number of the latest clock requests that are evaluated: 10 s at 4 Hz."""

MIN_REQUESTS = 20
"""Smallest number of clock requests that is evaluated."""

LOSS_ALARM = 0.10
"""Share of lost clock requests from which a link is reported; packet loss is about half of it, since a request and its
reply can both be lost. False-alarm rate on a link with 0.2 % loss: about 1e-4 per window (assumed)."""


class LinkMonitor:
    """Counts the answered clock requests of one client and reports a link with high packet loss.

    A link is reported once when its loss rises to `LOSS_ALARM`, and again only after it has fallen below half of that.
    While the client is dead its link is not evaluated.

    Args:
        sensor: name of the client's sensor.
    """

    __slots__ = ("_answered", "_is_lossy", "_pending_s", "_sensor")

    def __init__(self, sensor: str) -> None:
        self._sensor = sensor
        self._pending_s: deque[float] = deque()
        self._answered: deque[bool] = deque(maxlen=WINDOW)
        self._is_lossy = False

    def request_sent(self, t_s: float) -> None:
        """Record that a clock request was sent at session time ``t_s``."""
        self._pending_s.append(t_s)

    def reply_received(self, t_send_s: float) -> None:
        """Record the reply to the clock request that was sent at session time ``t_send_s``.

        A reply after the timeout is ignored: its request already counts as lost.
        """
        if t_send_s in self._pending_s:
            self._pending_s.remove(t_send_s)
            self._answered.append(True)

    def check_loss(self, t_s: float, *, alive: bool) -> list[Notice]:
        """Evaluate the link at session time ``t_s``; one notice if its loss has become high, else none.

        Args:
            t_s: session time [s].
            alive: whether the client is alive.
        """
        while self._pending_s and t_s - self._pending_s[0] > TIMEOUT_S:
            self._pending_s.popleft()
            self._answered.append(False)

        # Requests to a dead client say nothing about its link.
        if not alive:
            self._answered.clear()
        count = len(self._answered)
        if count < MIN_REQUESTS:
            return []

        lost = self._answered.count(False)
        if self._is_lossy or lost < LOSS_ALARM * count:
            # Hysteresis: the alarm is armed again only below half of the threshold.
            self._is_lossy &= lost >= LOSS_ALARM / 2 * count
            return []

        self._is_lossy = True
        return [Notice(t_s, self._sensor, f"link loses packets: {lost} of the last {count} clock exchanges")]
