"""The page of a study: verdict, synchrony, timing, tests, power, and threats to validity."""

from __future__ import annotations

import json
import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ...assets import published_study as published
from ...core.errors import RecordError
from .page import Cell, Page, Table
from .power_page import power_figure, power_sentence
from .study_questions import questions
from .study_ratings import rating_sentence, rating_table
from .study_synchrony import (
    chance_of,
    charted_conditions,
    condition_series,
    group_table,
    published_table,
    robot_conditions,
    surrogate_table,
    synchrony_figures,
    synchrony_table,
)
from .study_timing import comparison_table, event_test_sentence, is_shown, timing_figures, timing_table
from .text import NAME_CHARACTERS, condition_text, counted, difference, interval, listed, number, percent, shortened

POWER_FILE = "power.json"
"""File with a power analysis, which may lie in the folder of a study."""

METHODS = {
    "eca": "A method of the published study. The robot moves when the dancers moved on average an iteration before.",
    "sia": "The other method of the published study. The robot follows the dancer who was most synchronous in the "
    "iteration before.",
    "random-dancer": "The control that the published study lacks. The robot follows as under SIA, but a dancer who is "
    "drawn at random for each iteration.",
    "metronome": "The robot moves with the music, whatever the dancers do.",
}
"""Method -> what it does, for readers who do not know it."""

MOST_PAIRS = 6
"""Largest number of differences that the verdict lists one by one."""

SECTIONS = (
    ("asked", "What was asked"),
    ("synchrony", "Synchrony"),
    ("timing", "Timing of the robot"),
    ("tests", "Differences and tests"),
    ("power", "How many groups are needed"),
)


def study_page(folder: Path, content: Mapping[str, Any]) -> Page:
    """The page.

    Args:
        folder: the study's folder.
        content: content of its study.json.

    Raises:
        RecordError: power.json is damaged.
    """
    if "gsi" not in content:
        return _overview_page(folder, content)
    conditions = robot_conditions(content)
    shown = listed([condition_text(name) for name in conditions[:3]])
    more = f" and {len(conditions) - 3} further conditions" if len(conditions) > 3 else ""
    return Page(
        template="study.html",
        kind="report of a study",
        title=f"{shown or 'Dancers alone'}{more} in {counted(content['groups'], 'group')}",
        verdict=verdict(content),
        facts=_facts(content),
        sections=SECTIONS,
        questions=questions(content),
        commands=(command_line(folder),),
        versions=content.get("versions", {}),
        content=_content(content, _power(folder)),
    )


def _overview_page(folder: Path, content: Mapping[str, Any]) -> Page:
    """The page of a study whose conditions were not compared, such as one with very many conditions."""
    rows = content["by_condition"]
    return Page(
        template="overview.html",
        kind="report of a study",
        title=f"{counted(len(rows), 'condition')} in {counted(content['design']['groups'], 'group')}",
        verdict=["The conditions of this study were not compared.", *content.get("notices", ())],
        facts=_facts(content),
        sections=(("conditions", "The conditions"),),
        commands=(command_line(folder),),
        versions=content.get("versions", {}),
        content={"table": _overview_table(rows)},
    )


def _overview_table(rows: Sequence[Mapping[str, Any]]) -> Table:
    """Means with intervals of every condition."""
    cells = [
        [
            Cell(condition_text(row["condition"]), "name"),
            Cell(str(row["sessions"])),
            *(
                cell
                for measure, digits in (("gsi", 3), ("gsi_full_edges", 3), ("gsi_humans", 3), ("ta_mean_s", 2))
                for cell in (
                    Cell(number(row[measure]["mean"], digits)),
                    Cell(interval(row[measure]["low"], row[measure]["high"], digits)),
                )
            ),
        ]
        for row in rows
    ]
    pair = ("mean", "95 % interval")
    return Table(
        "Means over groups",
        ("condition", "sessions", *pair * 4),
        cells,
        above=(("", 2), ("GSI, published rule", 2), ("GSI, all edges", 2), ("GSI, dancers alone", 2), ("TA [s]", 2)),
    )


def command_line(folder: Path) -> str:
    """The command line that simulates a study again."""
    return shlex.join(["sjasim", "study", "--design", f"{folder.name}/design.toml", "--out", "DIR"])


def verdict(content: Mapping[str, Any]) -> list[str]:
    """Sentences that answer the question of the study.

    Args:
        content: content of study.json.
    """
    conditions = robot_conditions(content)
    if not conditions:
        own = next(iter(content["gsi_humans"].values()))
        return [f"Dancers alone have a synchronisation index of {_with_interval(own)}."]
    if len(conditions) == 1:
        own = content["gsi_full_edges"][conditions[0]]
        first = f"Under {condition_text(conditions[0])} the group has a synchronisation index of {_with_interval(own)}."
        return [first, *_chance_sentences(content, conditions)]
    return [
        _synchrony_sentence(content, conditions),
        _timing_sentence(content, conditions),
        *_chance_sentences(content, conditions),
        *_published_sentences(content),
    ]


def _synchrony_sentence(content: Mapping[str, Any], conditions: Sequence[str]) -> str:
    """Whether one condition leads to a more synchronous group than the others."""
    figures = content["gsi_full_edges"]
    best = max(conditions, key=lambda name: figures[name]["mean"] or 0.0)
    if len(conditions) > 2:
        return _many_sentence(content, conditions, best)

    other = next(name for name in conditions if name != best)
    item = _comparison(content, "gsi_full_edges", best, other)
    values = (
        f"on a scale from 0 to 1 the synchronisation index is {number(figures[best]['mean'], 2)} under "
        f"{condition_text(best)} and {number(figures[other]['mean'], 2)} under {condition_text(other)}"
        f"{_difference(item, best)}"
    )
    if item is not None and is_shown(item):
        return f"Groups are more synchronous under {condition_text(best)} than under {condition_text(other)}: {values}."
    return f"{counted(content['groups'], 'group')} do not show a difference in synchrony: {values}."


def _many_sentence(content: Mapping[str, Any], conditions: Sequence[str], best: str) -> str:
    """The best of several conditions, and the differences that are shown."""
    figure = number(content["gsi_full_edges"][best]["mean"], 2)
    first = (
        f"Of {len(conditions)} conditions, {condition_text(best)} has the highest synchronisation index ({figure} of 1)"
    )
    return f"{first}. {_shown_sentence(content, 'gsi_full_edges', 'more synchronous')}"


def _shown_sentence(content: Mapping[str, Any], measure: str, better: str) -> str:
    """Which of several conditions are shown to differ in a measure, and which are not."""
    pairs = [item for item in content["comparisons"] if item["measure"] == measure]
    shown = []
    for item in pairs:
        if is_shown(item):
            # A higher index and a smaller distance are better.
            second_is_better = (item["difference"] > 0) == (measure != "ta_mean_s")
            names = (item["second"], item["first"]) if second_is_better else (item["first"], item["second"])
            shown.append(" than ".join(map(condition_text, names)))
    open_pairs = [" and ".join(map(condition_text, (i["first"], i["second"]))) for i in pairs if not is_shown(i)]
    if len(pairs) > MOST_PAIRS:
        return f"Of {len(pairs)} differences, {len(shown)} are shown after adjustment for several comparisons."

    sentence = f"Shown to be {better}: {listed(shown)}. " if shown else ""
    return sentence + (f"No difference is shown between {'; '.join(open_pairs)}." if open_pairs else "")


def _timing_sentence(content: Mapping[str, Any], conditions: Sequence[str]) -> str:
    """Which condition has the best timing."""
    figures = content["ta"]
    known = [name for name in conditions if figures[name]["mean_s"] is not None]
    if not known:
        return "The robot performed no step, so nothing can be said of its timing."
    best = min(known, key=lambda name: figures[name]["mean_s"])
    others = [f"{number(figures[name]['mean_s'], 2)} s under {condition_text(name)}" for name in known if name != best]
    own = number(figures[best]["mean_s"], 2)
    first = f"The robot is nearest to the dancers under {condition_text(best)}: {own} s on average"
    if len(known) != 2:
        others = others[:MOST_PAIRS]
        against = f", against {listed(others)}" if others else ""
        return f"{first}{against}. {_shown_sentence(content, 'ta_mean_s', 'nearer')}".strip()

    item = _comparison(content, "ta_mean_s", *known)
    shown = "" if item is not None and is_shown(item) else ", which the groups do not show to be a difference"
    return f"{first}, against {others[0]}{_difference(item, best)}{shown}."


def _chance_sentences(content: Mapping[str, Any], conditions: Sequence[str]) -> list[str]:
    """How many iterations are above their chance level; nothing without chance levels."""
    found = {name: chance_of(content, name, "gsi_full_edges").get("above_p95") for name in conditions}
    shares = [f"{percent(share, 0)} under {condition_text(name)}" for name, share in found.items() if share is not None]
    if not shares:
        return []
    return [f"Of the iterations, {listed(shares)} exceed the index that 5 % would exceed by chance."]


def _published_sentences(content: Mapping[str, Any]) -> list[str]:
    """The published values beside those of this study, where it has the published conditions."""
    pair = ("eca", "sia")
    if not set(pair) <= set(content["ta"]):
        return []
    published_gsi = listed([number(float(np.mean(published.GSI[name])), 2) for name in pair])
    own_gsi = listed([number(content["gsi"][name]["mean"], 2) for name in pair])
    published_s = listed([number(published.TA_MEAN_S[name], 2) for name in pair])
    own_s = listed([number(content["ta"][name]["mean_s"], 2) for name in pair])
    item = _comparison(content, "gsi", *pair)
    return [
        f"The published study found an index of {published_gsi} for ECA and SIA under its own rule of counting (here "
        f"{own_gsi}{_difference(item, 'sia')}), and a distance from the dancers of {published_s} s (here {own_s} s)."
    ]


def _facts(content: Mapping[str, Any]) -> list[tuple[str, str]]:
    design = content["design"]
    humans = design.get("humans", "")
    presets = [humans] if isinstance(humans, str) else list(humans)
    session = design.get("session") or {}
    facts = [
        ("groups", str(content.get("groups", design["groups"]))),
        ("people in a group", str(session.get("dancers", 3))),
        ("people", listed([shortened(str(name), NAME_CHARACTERS) for name in presets])),
        ("order of conditions", str(design.get("order", "–"))),
        ("world", str(session.get("fidelity", "–"))),
        ("seed", str(design.get("seed", "–"))),
    ]
    if content.get("studies", 1) > 1:
        facts.append(("replications", f"{content['studies']}; this page shows the first"))
    return facts


def _content(content: Mapping[str, Any], power: Mapping[str, Any] | None) -> dict[str, object]:
    """Values of the template."""
    conditions = robot_conditions(content)
    styles = condition_series(content["conditions"])
    design = content["design"]
    return {
        "conditions": [condition_text(name) for name in conditions],
        "methods": [(condition_text(name), text) for name, text in METHODS.items() if name in conditions],
        "has_published": bool({"eca", "sia"} & set(conditions)),
        "humans_only": any(name not in conditions for name in content["conditions"]),
        "uncharted": len(conditions) - len(charted_conditions(content)),
        "performance": design.get("performance", "fresh"),
        "synchrony_figures": synchrony_figures(content, styles) if conditions else [],
        "synchrony_table": synchrony_table(content),
        "surrogate_table": surrogate_table(content),
        "group_table": group_table(content) if conditions else None,
        "published_table": published_table(),
        "wins": _win_sentences(content),
        "timing_figures": timing_figures(content, styles),
        "timing_table": timing_table(content) if conditions else None,
        "comparison_table": comparison_table(content) if content["comparisons"] else None,
        "event_test": event_test_sentence(content),
        "rating_sentence": rating_sentence(content),
        "rating_table": rating_table(content),
        "replications": _replication_table(content),
        "power_figure": power_figure(power) if power else None,
        "power_sentence": power_sentence(power) if power else "",
        "notices": list(content.get("notices") or ()),
    }


def _win_sentences(content: Mapping[str, Any]) -> list[str]:
    """How often one condition has the higher index, for every pair."""
    wins = content.get("wins")
    if not wins:
        return []
    sentences = []
    for pair in wins["pairs"]:
        iterations = pair["iterations"]
        groups = pair["groups"]
        sentence = (
            f"{condition_text(pair['second'])} has a higher index than {condition_text(pair['first'])} in "
            f"{iterations['second']} of {iterations['n']} iterations ({counted(iterations['ties'], 'tie')}) and in "
            f"{groups['second']} of {groups['n']} groups."
        )
        if (pair["first"], pair["second"]) == ("eca", "sia"):
            sentence += (
                f" Published are {published.ITERATIONS_WON[0]} of {published.ITERATIONS_WON[1]} and "
                f"{published.GROUPS_WON[0]} of {published.GROUPS_WON[1]}."
            )
        sentences.append(sentence)
    return sentences


def _replication_table(content: Mapping[str, Any]) -> Table | None:
    """How much figures vary between replications of the whole study."""
    replications = content.get("replications")
    if not replications:
        return None
    rows = [(f"GSI, {condition_text(name)}", item, 3) for name, item in replications["gsi"].items()]
    rows += [(f"TA [s], {condition_text(name)}", item, 2) for name, item in replications["ta_mean_s"].items()]
    names = {"wins_iterations": "iterations won", "wins_groups": "groups won", "z": "z of the published test"}
    rows += [(text, replications[key], 1) for key, text in names.items() if key in replications]
    cells = [
        [
            Cell(text, "name"),
            Cell(number(item["mean"], digits)),
            Cell(interval(item["low"], item["high"], digits)),
            Cell(str(item["studies"])),
        ]
        for text, item, digits in rows
    ]
    return Table(
        "Replications of the whole study: how much its figures vary",
        ("figure", "mean", "middle 95 %", "studies"),
        cells,
    )


def _power(folder: Path) -> Mapping[str, Any] | None:
    """The power analysis in the folder; None without one."""
    path = folder / POWER_FILE
    if not path.is_file():
        return None
    try:
        power = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise RecordError(f"{path} is damaged: {error}") from None
    if not isinstance(power, dict):
        raise RecordError(f"{path} is damaged: it holds no table of keys")
    return power


def _comparison(content: Mapping[str, Any], measure: str, one: str, other: str) -> Mapping[str, Any] | None:
    """The comparison of two conditions in a measure, in either order."""
    for item in content["comparisons"]:
        if item["measure"] == measure and {item["first"], item["second"]} == {one, other}:
            return dict(item)
    return None


def _difference(item: Mapping[str, Any] | None, minuend: str) -> str:
    """Difference of a comparison, a condition minus the other, with interval and probability; begins with a comma."""
    if item is None or item["difference"] is None:
        return ""
    sign = 1.0 if item["second"] == minuend else -1.0
    ends = [None if item[end] is None else sign * item[end] for end in ("low", "high")]
    low, high = ends if sign > 0 else reversed(ends)
    return f", {difference(sign * item['difference'], low, high, item['p_adjusted'])}"


def _with_interval(figures: Mapping[str, Any]) -> str:
    return f"{number(figures['mean'], 2)} {interval(figures['low'], figures['high'], 2)}"
