"""Simulated participants' ratings in the page of a study."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ...assets import published_study as published
from .page import Cell, Table
from .text import condition_text, counted

MOST_GROUPS = 40
"""Largest number of groups in the table of a page."""


def rating_sentence(content: Mapping[str, Any]) -> str:
    """In how many groups the ratings match the measured synchrony; "" without ratings.

    Args:
        content: content of study.json.
    """
    ratings = content.get("ratings")
    if not ratings:
        return ""
    agree, groups = published.RATINGS_AGREE
    first, second = map(condition_text, ratings["conditions"])
    return (
        f"Each dancer rates from 1 to 5 how synchronous the robot was. In {ratings['matches']} of "
        f"{counted(ratings['groups'], 'group')} most dancers find that one of {first} and {second} more synchronous "
        f"which has the higher index. Published are {agree} of {groups}. How people come to their ratings is not "
        "published: the model of their perception is assumed, and the ratings are no evidence about people."
    )


def rating_table(content: Mapping[str, Any]) -> Table | None:
    """The ratings of each group; None without ratings.

    Args:
        content: content of study.json.
    """
    ratings = content.get("ratings")
    if not ratings:
        return None
    rows = []
    for group in ratings["by_group"][:MOST_GROUPS]:
        own = [" ".join(map(str, group["ratings"][name])) for name in ratings["conditions"]]
        better = [condition_text(group[key]) if group[key] else "neither" for key in ("rated", "measured")]
        rows.append([Cell(str(group["group"])), *map(Cell, own), *(Cell(name, "name") for name in better)])

    left_out = len(ratings["by_group"]) - len(rows)
    return Table(
        "Simulated ratings of the robot's synchrony, one for each dancer",
        ("group", *map(condition_text, ratings["conditions"]), "rated higher", "higher index"),
        rows,
        f"{counted(left_out, 'further group')} are in study.json." if left_out else "",
    )
