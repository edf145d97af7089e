"""Numbers, names and times as a page writes them."""

from __future__ import annotations

from collections.abc import Sequence

NOTHING = "–"
"""Stands for a figure that was not measured."""

NAME_CHARACTERS = 32
"""Longest name of a condition, preset or file in running text and tables."""

CONDITIONS = {"eca": "ECA", "sia": "SIA", "none": "dancers alone"}
"""Method -> its name in running text."""

CERTAIN_P = 0.001
"""p-values below this are given as smaller than it."""


def number(value: float | None, digits: int = 3) -> str:
    """A number with so many decimals, `NOTHING` for None."""
    if value is None:
        return NOTHING
    # A negative number that is rounded to 0 has no sign.
    return f"{round(value, digits) + 0.0:.{digits}f}".replace("-", "−")


def signed(value: float | None, digits: int = 3) -> str:
    """A number with its sign, `NOTHING` for None."""
    return NOTHING if value is None else f"{value:+.{digits}f}".replace("-", "−")


def difference(value: float, low: float | None, high: float | None, p: float | None, digits: int = 2) -> str:
    """A difference in words, with its interval and probability."""
    ends = "" if low is None or high is None else f", 95 % interval {number(low, digits)} to {number(high, digits)}"
    return f"difference {number(value, digits)}{ends}, {p_value(p)}"


def percent(share: float | None, digits: int = 1) -> str:
    """A share from 0 to 1 in per cent."""
    return NOTHING if share is None else f"{100.0 * share:.{digits}f} %"


def interval(low: float | None, high: float | None, digits: int = 3) -> str:
    """``[low, high]``, or `NOTHING` if an end is not known."""
    return NOTHING if low is None or high is None else f"[{number(low, digits)}, {number(high, digits)}]"


def p_value(value: float | None) -> str:
    """``p = 0.03``, with two digits that count, or ``p < 0.001``."""
    if value is None:
        return "p unknown"
    if value < CERTAIN_P:
        return f"p < {CERTAIN_P:g}"
    return f"p = {value:.2f}" if value >= 0.0995 else f"p = {value:.3f}"


def shortened(name: str, characters: int) -> str:
    """A name of at most so many characters: of a longer one the middle is left out."""
    if len(name) <= characters:
        return name
    head = (characters - 1) * 2 // 3
    return f"{name[:head]}…{name[len(name) - (characters - 1 - head) :]}"


def listed(names: Sequence[str]) -> str:
    """``a``, ``a and b``, or ``a, b and c``."""
    if len(names) <= 1:
        return "".join(names)
    return f"{', '.join(names[:-1])} and {names[-1]}"


def counted(count: int, noun: str, plural: str = "") -> str:
    """``1 group``, ``9 groups``."""
    return f"{count} {noun if count == 1 else plural or noun + 's'}"


def condition_text(name: str) -> str:
    """Name of a condition as a reader writes it: published methods in capitals, and long names shortened.

    Args:
        name: the method, perhaps followed by the levels of factors, such as ``sia dance.bpm=100``.
    """
    method, space, levels = name.partition(" ")
    return shortened(f"{CONDITIONS.get(method, method)}{space}{levels}", NAME_CHARACTERS)


def agent(name: str) -> str:
    """Name of a dancer or the robot in running text: ``dancer 2`` for ``dancer_2``."""
    return name.replace("_", " ")
