"""Plain data without the numbers that JSON does not have."""

from __future__ import annotations

import math
from collections.abc import Mapping


def without_nan(value: object) -> object:
    """Return the same plain data with None for NaN and infinity.

    Args:
        value: numbers, strings, mappings, lists and tuples, nested in any way; tuples become lists.
    """
    if isinstance(value, float) and not math.isfinite(value):
        return None
    if isinstance(value, Mapping):
        return {key: without_nan(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [without_nan(item) for item in value]
    return value
