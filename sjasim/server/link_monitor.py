"""Which clock exchanges come back: the server's only way to see that a link loses packets."""

from __future__ import annotations

from collections import deque

from ..core.session_log import Notice

ANSWER_S = 1.0
"""An exchange that is not answered within this time is lost."""

COUNTED = 40
"""Latest exchanges that are judged: 10 s at 4 Hz."""

LEAST = 20
"""Fewer exchanges are not judged."""

LOSSY = 0.10
"""Share of lost exchanges from which a link is reported; one way that is some 5 % of its packets. A well link's .2 %
comes near it in one window of ten thousand (assumed)."""


class LinkMonitor:
    """The exchanges with one client, and what they say of its link.

    A link that begins to lose packets is reported once, and again only after it has been well (less than half of
    `LOSSY`) meanwhile. A dead client says nothing about its link.

    Args:
        sensor: whose.
    """

    __slots__ = ("_answered", "_asked_s", "_lossy", "_sensor")

    def __init__(self, sensor: str) -> None:
        self._sensor = sensor
        self._asked_s: deque[float] = deque()
        self._answered: deque[bool] = deque(maxlen=COUNTED)
        self._lossy = False

    def asked(self, t_s: float) -> None:
        """A request was sent at session time ``t_s``."""
        self._asked_s.append(t_s)

    def answered(self, t_send_s: float) -> None:
        """The request sent at ``t_send_s`` was answered."""
        if t_send_s in self._asked_s:
            self._asked_s.remove(t_send_s)
            self._answered.append(True)

    def judge(self, t_s: float, *, alive: bool) -> list[Notice]:
        """What is to be reported at session time ``t_s``."""
        while self._asked_s and t_s - self._asked_s[0] > ANSWER_S:
            self._asked_s.popleft()
            self._answered.append(False)
        if not alive:
            self._answered.clear()
        if len(self._answered) < LEAST:
            return []
        lost, count = self._answered.count(False), len(self._answered)
        if self._lossy or lost < LOSSY * count:
            self._lossy &= lost >= LOSSY / 2 * count
            return []
        self._lossy = True
        return [Notice(t_s, self._sensor, f"link loses packets: {lost} of the last {count} clock exchanges")]
