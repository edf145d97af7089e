"""Formatting of texts that messages of several packages contain."""

from __future__ import annotations


def counted(count: int, noun: str) -> str:
    """Return a count with its noun in singular or plural: ``1 person``, ``2 persons``."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"
