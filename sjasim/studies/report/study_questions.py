"""What reviewers will ask about a study, with the answers that its data give."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from .page import Question
from .study_synchrony import chance_of, robot_conditions
from .text import condition_text, counted, interval, listed, number, p_value, percent, signed

FEW_GROUPS = 20
"""Number of groups below which the page says that they are few (assumed)."""

ENTRAINED = "paper-entrainment"
"""Preset in which people become steadier when the robot's timing was good in the iteration before."""


def questions(content: Mapping[str, Any]) -> list[Question]:
    """Threats to validity of a study.

    Args:
        content: content of study.json.
    """
    design = content["design"]
    found = [_people(design), *_preset(design), _edges(content), _chance(content), *_events(content)]
    found += [_groups(content), *_control(content), _rehearsal(), _world(design), *_missing(content), _seeds(design)]
    return found


def _people(design: Mapping[str, Any]) -> Question:
    return Question(
        "Are these people?",
        f"No. Their timing comes from a statistical model with the parameters of {listed(_presets(design))}. A study "
        "says what would be found if people moved like this. It can show that a method fails, or how many groups a "
        "study needs; it cannot replace the study with people.",
    )


def _preset(design: Mapping[str, Any]) -> list[Question]:
    if ENTRAINED not in _presets(design):
        return []
    return [
        Question(
            "Is part of the gain built into the people?",
            f"Yes. Under {ENTRAINED} people become steadier after an iteration in which the robot's timing was good, "
            "and less steady after a bad one. A method with good timing therefore gains twice. Repeat the study with "
            "paper-warmup, which has no such term, before you attribute a gain to the method alone.",
        )
    ]


def _edges(content: Mapping[str, Any]) -> Question:
    answer = (
        "Under the published edge rule the robot counts only with those whom it follows. A perfect session scores "
        "10/12 under SIA (9/12 in its first iteration, in which it follows nobody) and 1 under ECA, so that this index "
        "favours ECA. The index with all edges treats all methods alike."
    )
    both = {item["measure"]: item for item in reversed(content["comparisons"])}
    if {"gsi", "gsi_full_edges"} <= set(both):
        pair = both["gsi"]
        answer += (
            f" Here {condition_text(pair['second'])} minus {condition_text(pair['first'])} is "
            f"{signed(pair['difference'])} under the published rule and "
            f"{signed(both['gsi_full_edges']['difference'])} with all edges."
        )
    return Question("Does the index treat both methods alike?", answer)


def _chance(content: Mapping[str, Any]) -> Question:
    asked = "Is an index of this size more than chance?"
    levels = {name: chance_of(content, name, "gsi_full_edges") for name in robot_conditions(content)}
    known = {name: level for name, level in levels.items() if level.get("p95") is not None}
    if not known:
        return Question(asked, "This cannot be said: no chance level could be computed for this study.")
    parts = [
        f"{condition_text(name)} has {number(content['gsi_full_edges'][name]['mean'], 2)} with all edges, people who "
        f"never met {number(level['mean'], 2)} on average"
        for name, level in known.items()
    ]
    return Question(
        asked,
        f"{'; '.join(parts)}. The level comes from people of different groups, who share the music and the dance but "
        "not the room. The music alone synchronises people, so an index well above 0 is no achievement of a group.",
    )


def _events(content: Mapping[str, Any]) -> list[Question]:
    test = content["wilcoxon"]
    if not test:
        return []
    return [
        Question(
            "Why not test single events, as published?",
            f"The {test['n']} observations of that test are events of a few groups. Events of one group depend on each "
            "other: if a group is early once, it is early often. A test that takes them as independent finds "
            "differences that are not there. The group is the unit that was sampled, and the tests here use it.",
        )
    ]


def _groups(content: Mapping[str, Any]) -> Question:
    count = content["groups"]
    comparison = next((item for item in content["comparisons"] if item["measure"] == "gsi"), None)
    answer = f"The study has {counted(count, 'group')}."
    if comparison is not None:
        answer += (
            f" They determine the difference in the published index only to "
            f"{interval(comparison['low'], comparison['high'])}, and no p-value can be below "
            f"{comparison['smallest_p']:.2g}."
        )
    if count < FEW_GROUPS:
        answer += (
            " That is few: a study with other groups can come out differently. sjasim power tells how many are needed."
        )
    return Question("Are there enough groups?", answer)


def _control(content: Mapping[str, Any]) -> list[Question]:
    if "sia" not in robot_conditions(content):
        return []
    item = next((item for item in content["comparisons"] if _is_control(item)), None)
    if item is None:
        answer = (
            "This study cannot say. It lacks the control random-dancer, which follows a dancer chosen at random just "
            "as quickly; the published study lacks it too. SIA may win because it reacts, not because of "
            "whom it follows."
        )
    else:
        sign = 1.0 if item["second"] == "sia" else -1.0
        answer = (
            "Compare SIA with random-dancer, which follows a dancer chosen at random just as quickly: SIA minus "
            f"random-dancer is {signed(sign * item['difference'])} with all edges ({p_value(item['p_adjusted'])}). "
            "Only what SIA gains over that control is due to the choice of the most synchronous dancer."
        )
    return [Question("Does it matter whom the robot follows?", answer)]


def _is_control(item: Mapping[str, Any]) -> bool:
    """Whether a comparison is that of SIA with its control."""
    return item["measure"] == "gsi_full_edges" and {item["first"], item["second"]} == {"sia", "random-dancer"}


def _rehearsal() -> Question:
    return Question(
        "What does the robot know of a group beforehand?",
        "One rehearsal iteration, in which it stands still. It stands for the published session without the robot, "
        "which had four iterations. SIA follows nobody in iteration 1 and dances as ECA does there.",
    )


def _world(design: Mapping[str, Any]) -> Question:
    fidelity = (design.get("session") or {}).get("fidelity", "physics")
    if fidelity == "timing":
        answer = (
            "No. There are no bodies and no sensors: detection delays, missed and false events and the robot's delay "
            "are drawn from distributions that were measured in the simulation of bodies and sensors (sjasim "
            "characterise)."
        )
    else:
        answer = (
            "Bodies, sensors and the robot are simulated with MuJoCo. Walking, sensor noise and the robot's drive are "
            "models, tested against published figures, not recordings of a laboratory."
        )
    return Question("Is the room simulated?", answer)


def _missing(content: Mapping[str, Any]) -> list[Question]:
    missed = {name: content["ta"][name] for name in robot_conditions(content)}
    shares = [
        f"{condition_text(name)}: {item['missed']} of {item['missed'] + item['n']} "
        f"({percent(_share(item['missed'], item['n']))})"
        for name, item in missed.items()
    ]
    if not any(item["missed"] for item in missed.values()):
        return []
    rule = content["design"].get("missing", "keep")
    return [
        Question(
            "What of the steps that the robot missed?",
            f"{'; '.join(shares)}. A missed step has no timing appropriateness, so that a method which leaves out its "
            f"worst steps looks better there; the synchronisation index counts it as a failure. Rule: {rule}.",
        )
    ]


def _seeds(design: Mapping[str, Any]) -> Question:
    tuning = design.get("seeds") == "tuning"
    answer = (
        "Yes: these are seeds for tuning. Report figures of the other set of seeds (seeds = evaluation)."
        if tuning
        else "Not if its parameters were chosen on other seeds. sjasim keeps two sets of seeds that share none: tune "
        "with seeds = tuning, and report what seeds = evaluation gives, as here."
    )
    return Question("Was the method tuned to these groups?", answer)


def _presets(design: Mapping[str, Any]) -> Sequence[str]:
    humans = design.get("humans", ())
    return [humans] if isinstance(humans, str) else list(humans)


def _share(missed: int, done: int) -> float | None:
    return missed / (missed + done) if missed + done else None
