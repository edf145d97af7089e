"""The page of a characterisation: how accurately events are detected, joints tracked and commands executed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from .charts import Interval, intervals
from .command_lines import changed_fields
from .page import Cell, Figure, Page, Question, Table, names, numbers
from .svg import series, swatch
from .text import counted, listed, number, percent, signed

Row = Mapping[str, Any]

ALL = "all"
"""Value of a column in rows that sum over it."""

GOOD_SHARE = 0.95
"""Recall and precision from which detectors are called complete (assumed)."""

SMALL_SHARE_OF_TAU = 1 / 3
"""Share of tau up to which a standard deviation of times is called small (assumed)."""

SHOWN_SETTINGS = {"method", "humans", "seed", "layout", "sensing"}
"""Fields of the configuration that the command line of the page shows."""

SECTIONS = (
    ("events", "Events of the dancers"),
    ("robot", "The robot"),
    ("joints", "Joints"),
    ("details", "By row and occlusion"),
)


def verdict(report: Mapping[str, Any]) -> list[str]:
    """Sentences that say whether the sensors and the robot are good enough.

    Args:
        report: content of characterise.json.
    """
    tau_s = float(report["config"]["synchrony"]["tau_s"])
    found = ((sensing, _detector_row(report, sensing, ALL, False)) for sensing in _sensings(report))
    whole = {sensing: row for sensing, row in found if row is not None and row["n"]}
    if not whole:
        return ["The dancers had no events, so nothing can be said of the detectors."]
    return [_detection_sentence(whole), *_timing_sentences(whole, tau_s), *_robot_sentences(report, tau_s)]


def characterisation_page(report: Mapping[str, Any]) -> Page:
    """The page.

    Args:
        report: content of characterise.json.
    """
    sessions = report["sessions"]
    facts = [
        ("sessions", str(len(sessions))),
        ("skeletons from", listed(_sensings(report))),
        ("layouts", listed(sorted({item["layout"] for item in sessions}))),
        ("seeds", listed(sorted({str(item["seed"]) for item in sessions}, key=int))),
        ("people", str(report["config"]["humans"])),
        ("method", str(report["config"]["method"])),
    ]

    return Page(
        template="characterisation.html",
        kind="accuracy of sensors, detectors and robot",
        title="How accurately events are detected, joints tracked and commands executed",
        verdict=verdict(report),
        facts=facts,
        sections=SECTIONS,
        questions=_questions(report),
        commands=(command_line(report),),
        versions=report["versions"],
        content=_content(report),
    )


def event_table(report: Mapping[str, Any], sensing: str, early: bool = False) -> Table:
    """Accuracy of one sort of events by kind.

    Args:
        report: content of characterise.json.
        sensing: source of the skeletons.
        early: whether it is about early events.
    """
    rows = [_detector_row(report, sensing, kind, early) for kind in _kinds(report)]
    cells = [[*names([_words(row["kind"])]), Cell(str(row["n"])), *_event_cells(row)] for row in rows if row]
    which = "early events, which announce a start or a stop" if early else "regular events"
    head = ("kind", "events", "recall", "precision", "bias [s]", "s.d. [s]", "95 % within [s]")
    return Table(f"Skeletons from {sensing}: {which}", head, cells)


def event_tables(report: Mapping[str, Any]) -> list[Table]:
    """Accuracy of the regular events, one table for each source of skeletons."""
    return [event_table(report, sensing) for sensing in _sensings(report)]


def command_line(report: Mapping[str, Any]) -> str:
    """The command line that gives the same figures, but for further settings of the sessions."""
    sessions = report["sessions"]
    layouts = dict.fromkeys(item["layout"] for item in sessions)
    seeds = {item["seed"] for item in sessions}
    config = report["config"]
    return (
        f"sjasim characterise --sessions {len(seeds)} --layouts {' '.join(layouts)} "
        f"--sensings {' '.join(_sensings(report))} --method {config['method']} --humans {config['humans']} "
        f"--seed {report['seed']} --out DIR"
    )


def _content(report: Mapping[str, Any]) -> dict[str, object]:
    """Values of the template."""
    sensings = _sensings(report)
    return {
        "event_figures": [figure for sensing in sensings for figure in _event_figures(report, sensing)],
        "event_tables": [event_table(report, sensing, early) for sensing in sensings for early in (False, True)],
        "robot_figure": _robot_figure(report["robot"]) if report["robot"] else None,
        "robot_table": _robot_table(report["robot"]) if report["robot"] else None,
        "joint_tables": [_joint_table(report, sensing) for sensing in sensings],
        "detail_tables": [_detail_table(report, sensing) for sensing in sensings],
        "tau_s": report["config"]["synchrony"]["tau_s"],
        "own_settings": bool(set(changed_fields(report["config"])) - SHOWN_SETTINGS),
    }


def _detection_sentence(whole: Mapping[str, Row]) -> str:
    """Recall and precision with each source of skeletons."""
    complete = all(min(row["recall"], row["precision"] or 0.0) >= GOOD_SHARE for row in whole.values())
    judgement = "find nearly all events" if complete else "miss events or report false ones"
    shares = [
        f"{percent(row['recall'])} of {row['n']} events are logged with skeletons from {sensing} "
        f"({percent(row['precision'])} of the logged ones are true)"
        for sensing, row in whole.items()
    ]
    return f"The detectors {judgement}: {listed(shares)}."


def _timing_sentences(whole: Mapping[str, Row], tau_s: float) -> list[str]:
    """Delay and spread of logged times, against the width of the coincidence window; nothing without a logged event."""
    known = {sensing: row for sensing, row in whole.items() if row["sd_s"] is not None}
    if not known:
        return []

    worst_s = max(row["sd_s"] for row in known.values())
    judgement = "small" if worst_s <= SMALL_SHARE_OF_TAU * tau_s else "not small"
    delays = [f"{number(row['bias_s'], 2)} s with {sensing}" for sensing, row in known.items()]
    return [
        f"Logged times are late by {listed(delays)} on average, which all dancers share. They spread by up to "
        f"{number(worst_s, 2)} s (s.d.), which is {judgement} against the {tau_s:g} s within which two events count as "
        f"synchronous."
    ]


def _robot_sentences(report: Mapping[str, Any], tau_s: float) -> list[str]:
    """Delay of the robot; nothing without a robot."""
    whole = next((row for row in report["robot"] if row["kind"] == ALL), None)
    if whole is None or whole["delay_s"] is None:
        return []
    consequence = (
        "so a command that waits for a dancer's event comes too late to be synchronous with it"
        if whole["delay_s"] > tau_s
        else "so it can answer a dancer's event in time"
    )
    return [
        f"The robot moves {number(whole['delay_s'], 2)} s after a command (s.d. {number(whole['jitter_s'], 2)} s), "
        f"{consequence}; it leaves out {percent(whole['not_executed'])} of {whole['n']} commands."
    ]


def _event_figures(report: Mapping[str, Any], sensing: str) -> list[Figure]:
    """Errors of the times, and recall, by kind."""
    regular = series(0)
    early = series(1)
    errors: list[Interval] = []
    recalls: list[Interval] = []
    for kind in _kinds(report):
        for is_early, style, shape in ((False, regular, "circle"), (True, early, "diamond")):
            row = _detector_row(report, sensing, kind, is_early)
            if row is None:
                continue
            label = "early" if is_early else _words(kind)
            recalls.append(Interval(label, style, row["recall"], shape=shape))
            if row["bias_s"] is not None and row["sd_s"] is not None:
                ends = (row["bias_s"] - row["sd_s"], row["bias_s"] + row["sd_s"])
                errors.append(Interval(label, style, row["bias_s"], *ends, shape=shape))

    legend = [
        (swatch([("circle", f"{regular} fill")]), "regular events"),
        (swatch([("diamond", f"{early} fill")]), "early events"),
    ]
    error_title = f"Error of logged times, {sensing}"
    recall_title = f"Share of events that are logged, {sensing}"
    described = f"Mean error by kind: {'; '.join(f'{item.label} {signed(item.value, 2)} s' for item in errors)}."
    shares = f"Recall by kind: {'; '.join(f'{item.label} {percent(item.value)}' for item in recalls)}."
    return [
        Figure(
            intervals(error_title, described, "logged minus true time [s]", errors, zero=True),
            f"{error_title}: mean, and one standard deviation to each side. Right of 0 is late.",
            legend,
        ),
        Figure(intervals(recall_title, shares, "recall", recalls), f"{recall_title}, occluded ones included.", legend),
    ]


def _robot_figure(rows: Sequence[Row]) -> Figure:
    """Delay of the robot by kind."""
    items = [
        Interval(_words(row["kind"]), "ink", row["delay_s"], *_around(row["delay_s"], row["jitter_s"])) for row in rows
    ]
    described = f"Mean delay: {'; '.join(f'{item.label} {number(item.value, 2)} s' for item in items)}."
    title = "From command to motion"
    return Figure(
        intervals(title, described, "delay [s]", items, zero=True),
        f"{title}: mean delay of the robot's event, and one standard deviation to each side.",
    )


def _robot_table(rows: Sequence[Row]) -> Table:
    cells = [
        [
            *names([_words(row["kind"])]),
            Cell(str(row["n"])),
            *numbers([row["delay_s"], row["jitter_s"]]),
            Cell(percent(row["not_executed"])),
        ]
        for row in rows
    ]
    head = ("event", "commands", "mean delay [s]", "s.d. [s]", "not executed")
    return Table("Robot: from command to event", head, cells)


def _joint_table(report: Mapping[str, Any], sensing: str) -> Table:
    """Errors of the joints by part of the body, in centimetres."""
    rows = [
        row for row in report["joints"] if row["sensing"] == sensing and (row["row"], row["occlusion"]) == (ALL, ALL)
    ]
    return Table(
        f"Joints from {sensing}",
        (
            "joints", "number", "tracked", "inferred", "median [cm]", "95 % within [cm]", "outliers", "constant [cm]",
            "slow [cm]", "inferred [cm]",
        ),
        [[*names([row["joints"]]), *_joint_cells(row)] for row in rows],
    )  # fmt: skip


def _detail_table(report: Mapping[str, Any], sensing: str) -> Table:
    """Accuracy of regular events by kind, row and occlusion."""
    rows = [
        row
        for row in report["detector"]
        if row["sensing"] == sensing and not row["early"] and ALL not in (row["row"], row["occlusion"])
    ]
    cells = [
        [*names([_words(row["kind"]), row["row"], row["occlusion"]]), Cell(str(row["n"])), *_event_cells(row)]
        for row in rows
    ]
    head = ("kind", "row", "occlusion", "events", "recall", "precision", "bias [s]", "s.d. [s]", "95 % within [s]")
    return Table(f"Skeletons from {sensing}: regular events by row and occlusion", head, cells)


def _event_cells(row: Row) -> list[Cell]:
    shares = [Cell(percent(row[name]), "bad" if _is_low(row[name]) else "") for name in ("recall", "precision")]
    return [*shares, Cell(signed(row["bias_s"])), *numbers([row["sd_s"], row["p95_s"]])]


def _joint_cells(row: Row) -> list[Cell]:
    shares = [Cell(percent(row[name])) for name in ("tracked", "inferred")]
    # Lengths are read more easily in centimetres.
    lengths = {
        name: None if row[name] is None else 100.0 * row[name]
        for name in ("median_m", "p95_m", "bias_m", "drift_m", "inferred_m")
    }
    first = numbers([lengths["median_m"], lengths["p95_m"]], 1)
    last = numbers([lengths["bias_m"], lengths["drift_m"], lengths["inferred_m"]], 2)
    return [Cell(str(row["n"])), *shares, *first, Cell(percent(row["astray"], 2)), *last]


def _questions(report: Mapping[str, Any]) -> list[Question]:
    """Threats to validity of these figures."""
    sessions = counted(len(report["sessions"]), "session")
    return [
        Question(
            "Are these figures of real sensors?",
            "No. Bodies, depth images and their noise are simulated, and people stand in a room without furniture, "
            "loose clothes or sunlight. The figures say what the simulated pipeline does, and are a bound from above "
            "for a real one.",
        ),
        Question(
            "Why does every event come late?",
            "A frame has to be captured and processed, and a detector needs several frames to tell a movement from "
            "noise. Events are stamped when the frame that shows them has been processed, as in the published study.",
        ),
        Question(
            "Are there enough events?",
            f"The figures come from {sessions}. Events of one session are not independent of each other: the same "
            "people stand in the same places. Rows with few events say little.",
        ),
    ]


def _detector_row(report: Mapping[str, Any], sensing: str, kind: str, early: bool) -> Row | None:
    """The row of a kind over all rows and occlusion bands."""
    wanted = (sensing, kind, early, ALL, ALL)
    keys = ("sensing", "kind", "early", "row", "occlusion")
    return next((row for row in report["detector"] if tuple(row[key] for key in keys) == wanted), None)


def _sensings(report: Mapping[str, Any]) -> list[str]:
    return sorted({str(item["sensing"]) for item in report["sessions"]}, reverse=True)


def _kinds(report: Mapping[str, Any]) -> list[str]:
    """Kinds of events in the order of the dance, then the sum over them."""
    order = ("start_forward", "stop_forward", "start_backward", "stop_backward", "clap")
    present = {str(row["kind"]) for row in report["detector"]}
    return [*(kind for kind in order if kind in present), *sorted(present - {*order, ALL}), ALL]


def _is_low(share: float | None) -> bool:
    return share is not None and share < GOOD_SHARE


def _around(middle: float | None, width: float | None) -> tuple[float | None, float | None]:
    return (None, None) if middle is None or width is None else (middle - width, middle + width)


def _words(kind: str) -> str:
    return kind.replace("_", " ")
