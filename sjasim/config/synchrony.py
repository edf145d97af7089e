"""Parameters of the synchrony measures."""

from __future__ import annotations

from dataclasses import dataclass

from .checks import within


@dataclass(frozen=True, slots=True)
class SynchronyConfig:
    """Parameters of the synchrony measures.

    Attributes:
        tau_s: two events of a kind coincide if they are less than this apart [s] (iqbal2016: .25 s).
        one_to_one: match each event at most once, which bounds Q by 1; the equation in iqbal2016 is not bounded.
    """

    tau_s: float = 0.25
    one_to_one: bool = False

    def __post_init__(self) -> None:
        within("synchrony.tau_s", self.tau_s, 0.001, 5.0)
