"""The page of a session: whom the robot followed, how late it was, and what was missed."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from ...analysis.delay_breakdown import delay_report
from ...analysis.group_metrics import GroupSynchronyRow, group_metrics
from ...analysis.missing_events import MissingEvents, missing_events
from ...analysis.session_metrics import logged_events
from ...choreography.timetable import timetable
from ...config import HUMANS_ONLY
from ...config.toml_file import from_plain
from ...core import ROBOT
from ...core.session_log import SessionLog
from ...record.rerun.explanation import (
    LATE_S,
    STAGES,
    TIMING_CLASSES,
    DelayReport,
    StepDelay,
    classify_step,
    explain,
)
from ...record.session_folder import read, read_summary
from .command_lines import has_unnamed_fields, session_command
from .page import Cell, Figure, Page, Question, Table, names, numbers
from .session_charts import lateness, raster, raster_legend
from .session_events import IterationEvents, iteration_events
from .svg import swatch
from .text import NAME_CHARACTERS, agent, condition_text, listed, number, percent, shortened, signed

INDICES = ("gsi", "gsi_full_edges", "gsi_truth")
"""Keys of the group synchronisation indices in session.json."""

WORST_STEPS = 5
"""Number of late or early steps that are explained in words."""

NOBODY = "nobody"
"""Stands for an iteration in which the robot followed no dancer."""

SECTIONS = (
    ("followed", "Whom the robot followed"),
    ("events", "All events"),
    ("late", "How late the robot was"),
    ("parts", "Sensors, clocks and bodies"),
    ("notices", "Notices"),
)

STAGE_HEADS = ("dancer", "sensor", "detector", "network", "method", "robot")
"""Head of the column of each of `explanation.STAGES`."""


class _Session(NamedTuple):
    """What the parts of the page share: content of session.json, the log, its measures, its events, and its delays."""

    summary: Mapping[str, Any]
    log: SessionLog
    rows: list[GroupSynchronyRow]
    iterations: list[IterationEvents]
    missing: MissingEvents
    delays: DelayReport

    @property
    def danced(self) -> list[int]:
        """Numbers of the danced iterations."""
        return [row.iteration for row in self.rows]

    def followed(self, iteration: int) -> str:
        """Whom the robot followed in a danced iteration, in words."""
        followed = next(row.followed for row in self.rows if row.iteration == iteration)
        if len(followed) > 1 and len(followed) == self.log.config["dancers"]:
            return "everybody"
        return listed([agent(name) for name in followed]) or NOBODY

    @property
    def has_robot(self) -> bool:
        return bool(self.summary["method"] != HUMANS_ONLY)


def session_page(folder: Path) -> Page:
    """The page.

    Args:
        folder: the session's folder.

    Raises:
        RecordError: a table of the folder is missing or damaged.
    """
    summary = read_summary(folder)
    log = read(folder)
    config = from_plain(log.config)
    table = timetable(config)
    rows = group_metrics(logged_events(log), config, table, log.followed)
    missing = missing_events(log)
    iterations = iteration_events(log, config, table, rows, missing)
    session = _Session(summary, log, rows, iterations, missing, delay_report(log))

    method = condition_text(str(summary["method"]))
    title = f"One session under {method}" if session.has_robot else "One session of the dancers alone"
    return Page(
        template="session.html",
        kind="report of a session",
        title=title,
        verdict=_verdict(session),
        facts=_facts(session),
        sections=SECTIONS,
        questions=_questions(session),
        commands=(session_command(log.config),),
        versions=log.versions,
        content=_content(session, config.synchrony.tau_s),
    )


def _verdict(session: _Session) -> list[str]:
    """Whom the robot followed, how late it was, and how synchronous the group was."""
    summary = session.summary
    index = (
        f"The group's synchronisation index is {number(summary['gsi_full_edges'], 2)} of 1 with every pair of agents "
        f"counted"
    )
    if not session.has_robot:
        return [f"{index}.", _missing_sentence(session)]
    return [
        f"{_timing_sentence(session)} {_followed_sentence(session)}",
        f"{index}, and {number(summary['gsi'], 2)} under the published rule for the robot's edges. "
        f"{_missing_sentence(session)}",
    ]


def _timing_sentence(session: _Session) -> str:
    """Mean distance of the robot from the dancers, and how many steps were on time."""
    counts = _class_counts(session.delays.steps)
    total = len(session.delays.steps)
    late_s = [step.late_s for step in session.delays.steps if math.isfinite(step.late_s)]
    if not late_s:
        return "The robot never moved."
    mean_s = sum(late_s) / len(late_s)
    word = "later" if mean_s >= 0 else "earlier"
    return (
        f"The robot moved {number(abs(mean_s), 2)} s {word} than the dancers' mean on average, and was on time in "
        f"{counts['on time']} of {total} steps (within {LATE_S:g} s)."
    )


def _followed_sentence(session: _Session) -> str:
    """Whom the robot followed, in the order of the iterations."""
    followed = [session.followed(iteration) for iteration in session.danced]
    named = [name for name in dict.fromkeys(followed) if name != NOBODY]
    return f"It followed {listed(named) or NOBODY}."


def _missing_sentence(session: _Session) -> str:
    """How many events are missing in the log, and how many steps the robot left out."""
    lost = sum(event.agent != ROBOT for event in session.missing.not_logged)
    false = sum(event.agent != ROBOT for event in session.missing.false)
    sentence = f"Of the dancers' events {lost} were not logged, and {false} logged ones did not happen"
    if not session.has_robot:
        return f"{sentence}."
    missed = sum(event.agent == ROBOT for event in session.missing.not_performed)
    return f"{sentence}; the robot left out {missed} of {len(session.delays.steps)} steps."


def _facts(session: _Session) -> list[tuple[str, str]]:
    config = session.log.config
    summary = session.summary
    return [
        ("method", shortened(str(summary["method"]), NAME_CHARACTERS)),
        ("people", f"{config['dancers']}, preset {shortened(str(summary['humans']), NAME_CHARACTERS)}"),
        ("seed", str(summary["seed"])),
        ("world", str(summary["fidelity"])),
        ("skeletons from", str(summary["sensing"])),
        ("iterations", str(len(summary["iterations"]))),
    ]


def _content(session: _Session, tau_s: float) -> dict[str, object]:
    """Values of the template."""
    steps = session.delays.steps
    off = [step for step in steps if classify_step(step) in ("late", "early")]
    missed = [step for step in steps if classify_step(step) == "missed"]
    return {
        "has_robot": session.has_robot,
        "tau_s": tau_s,
        "iteration_table": _iteration_table(session),
        "raster": Figure(
            raster("Events of all iterations", session.iterations),
            "Each marker is a logged event. Vertical lines are the beats of the music at which steps are due.",
            raster_legend(),
            wide=True,
        ),
        "lateness": _lateness_figure(steps, tau_s) if steps else None,
        "explained": [agent(explain(step)) for step in sorted(off, key=lambda step: -abs(step.late_s))[:WORST_STEPS]],
        "missed": [agent(explain(step)) for step in missed],
        "delay_table": _delay_table(steps) if any(step.follows for step in steps) else None,
        "latency_table": _latency_table(session.summary["net_latency_s"]) if session.summary["net_latency_s"] else None,
        "part_table": _part_table(session.summary),
        "clock_table": _clock_table(session.summary["clocks"]) if session.summary["clocks"] else None,
        "notice_table": _notice_table(session.summary["notices"]) if session.summary["notices"] else None,
        "unnamed_fields": has_unnamed_fields(session.log.config),
    }


def _iteration_table(session: _Session) -> Table:
    """Figures of every iteration: whom the robot followed, its timing, and the group's synchrony."""
    rows = []
    for row in session.summary["iterations"]:
        own = [step for step in session.delays.steps if step.iteration == row["index"]]
        late_s = [step.late_s for step in own if math.isfinite(step.late_s)]
        rows.append([
            Cell(str(row["index"])),
            *names([session.followed(row["index"]) if own else "–", agent(row["msp"]) or "–"]),
            *(Cell(str(count) if own else "–") for count in _class_counts(own).values()),
            Cell(signed(sum(late_s) / len(late_s) if late_s else None, 2)),
            *numbers([row.get("late_mean_s"), row["ta_mean_s"]], 2),
            *numbers([row[key] for key in INDICES]),
        ])  # fmt: skip

    summary = session.summary
    blank = Cell("")
    count = len(TIMING_CLASSES) + 3
    rows.append([
        Cell("mean"), *[blank] * count, *numbers([summary.get("late_mean_s"), summary["ta_mean_s"]], 2),
        *numbers([summary[key] for key in INDICES]),
    ])  # fmt: skip
    return Table(
        "The iterations",
        (
            "iteration", "followed", "MSP", *TIMING_CLASSES, "later [s]", "later [s]", "TA [s]", "published",
            "all edges", "true onsets",
        ),
        rows,
        above=(
            ("", 1), ("dancer", 2), ("robot's true motion", len(TIMING_CLASSES) + 1), ("logged events", 2), ("GSI", 3),
        ),
    )  # fmt: skip


def _lateness_figure(steps: Sequence[StepDelay], tau_s: float) -> Figure:
    return Figure(
        lateness("Lateness of the robot in every step", steps, tau_s),
        f"True onset of the robot's motion minus the mean of the dancers' true onsets. The band marks {tau_s:g} s to "
        "both sides, within which two events count as synchronous.",
        [
            (swatch([("block", "c0 fill soft")]), "lateness of a step; below 0 is early"),
            (swatch([("diamond", "fault hollow")]), "the robot did not move"),
        ],
        wide=True,
    )


def _delay_table(steps: Sequence[StepDelay]) -> Table:
    """Mean parts of the delay by kind, over the steps that followed a dancer."""
    following = [step for step in steps if step.follows and math.isfinite(step.late_s)]
    rows = []
    for kind in dict.fromkeys(step.kind for step in following):
        own = [step for step in following if step.kind is kind]
        parts = [_mean([step.parts_s[index] for step in own]) for index in range(len(STAGES))]
        late_s = _mean([step.late_s for step in own])
        rows.append([
            *names([kind.value.replace("_", " ")]), Cell(str(len(own))),
            *(Cell(signed(value, 2)) for value in [*parts, late_s]),
        ])  # fmt: skip
    return Table(
        "Where the delay comes from: means over the steps in which the robot followed a dancer [s]",
        ("event", "steps", *STAGE_HEADS, "in all"),
        rows,
        "dancer: the followed dancer behind the group's mean; sensor: until a frame shows the motion; detector: until "
        "it is detected; network: until the server knows; method: until the command; robot: until it moves. A negative "
        "part means that the cause came before the onset, such as an early event.",
    )


def _latency_table(latencies: Mapping[str, Any]) -> Table:
    rows = [
        [*names([kind.replace("_", " ")]), Cell(str(item["n"])), Cell(signed(item["mean"])), Cell(number(item["sd"]))]
        for kind, item in latencies.items()
    ]
    head = ("event", "number", "mean [s]", "s.d. [s]")
    return Table("Net latency: the robot's event minus that of the dancer whom it followed", head, rows)


def _part_table(summary: Mapping[str, Any]) -> Table:
    """Quality of detectors, robot and bodies, one row each."""
    detector = summary["detector"]
    robot = summary["robot"]
    rows = [
        ("events that were logged, of those in sight", percent(detector["recall"])),
        ("logged events that are true", percent(detector["precision"])),
        ("95 % of logged times within", f"{number(detector['timing_p95_s'])} s"),
    ]
    if robot["commands"]:
        rows += [
            ("commands to the robot", str(robot["commands"])),
            ("of them executed", percent(robot["executed"])),
            ("robot's distance from its place at the end", f"{number(robot['end_distance_m'], 2)} m"),
        ]
    rows += [
        ("falls of dancers", str(summary["falls"])),
        ("share of the weight that the feet carry", percent(summary["feet_load_share"])),
        ("horizontal force of the balance support (r.m.s.)", f"{number(summary['tether_rms_n'], 1)} N"),
    ]
    return Table("Components", ("figure", "value"), [[*names([]), Cell(name, "name"), Cell(v)] for name, v in rows])


def _clock_table(clocks: Mapping[str, Any]) -> Table:
    rows = [
        [*names([sensor]), Cell(str(item["n"])), *numbers([_ms(item["bias_s"]), _ms(item["p95_s"])], 2)]
        for sensor, item in clocks.items()
    ]
    head = ("sensor", "events", "mean error [ms]", "95 % within [ms]")
    return Table("Clocks of the sensors after synchronisation", head, rows)


def _notice_table(notices: Sequence[Mapping[str, Any]]) -> Table:
    rows = [[Cell(number(item["t_s"], 1)), *names([item["source"]]), Cell(item["what"], "words")] for item in notices]
    return Table("Notices of the session", ("time [s]", "about", "notice"), rows)


def _questions(session: _Session) -> list[Question]:
    """Threats to validity of one session."""
    questions = [
        Question(
            "Can one session show that a method works?",
            "No. Sessions of the same people under the same method differ widely. Compare methods in a study of many "
            "groups (sjasim study), and read the index beside its chance level there.",
        ),
        Question(
            "Are these people?",
            "No. Their timing comes from a statistical model of published data, and their bodies from a simulation. A "
            "session shows what the robot would do if people moved like this.",
        ),
    ]
    if session.has_robot:
        questions.append(
            Question(
                "Which of the synchronisation indices should I read?",
                "The one with all edges. Under the published rule the robot has edges to those whom it follows only, "
                "so that a perfect session scores 10/12 under SIA and 1 under ECA.",
            )
        )
    return questions


def _class_counts(steps: Sequence[StepDelay]) -> dict[str, int]:
    """Number of steps by timing class."""
    classes = [classify_step(step) for step in steps]
    return {name: classes.count(name) for name in TIMING_CLASSES}


def _mean(values: Sequence[float]) -> float | None:
    """Mean of the values that are known; None without one."""
    known = [value for value in values if math.isfinite(value)]
    return sum(known) / len(known) if known else None


def _ms(value_s: float | None) -> float | None:
    return None if value_s is None else 1000.0 * value_s
