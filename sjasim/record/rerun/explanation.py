"""Values that a recording shows beside the log: delays, graphs, clock errors, and a summary in words.

`analysis.delay_breakdown` computes them; this module holds the value types and puts them into sentences.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from ...core import ROBOT, Array, Kind

STAGES = ("dancer", "sensor", "detector", "network", "decision", "wheels")
"""Parts of the time between the group's mean time of a step and the robot's motion, in order of cause.

- dancer: distance of the followed dancer from the group's mean
- sensor: from the onset to the earliest processed frame that can show it
- detector: what detection takes beyond that
- network: from the client to the server
- decision: from the event's arrival to the command
- wheels: from the command to the motion

Without a followed dancer, everything before the command counts as decision.
"""


@dataclass(frozen=True, slots=True)
class StepDelay:
    """Delay of one step of the robot behind the group, and where it arose.

    Attributes:
        iteration: number of the iteration, from 1.
        ordinal: index of the step in the iteration.
        kind: the dancers' event that the step answers.
        t_s: mean of the dancers' true onsets, session time [s].
        robot_s: the robot's true onset, session time [s]; NaN if it never moved.
        follows: the dancer whose event decided the command, or "".
        parts_s: duration of each of `STAGES` [s]; they add up to ``late_s``. Parts that do not apply are NaN, and all
            of them are NaN without a command.
        why: the method's reason for its command.
    """

    iteration: int
    ordinal: int
    kind: Kind
    t_s: float
    robot_s: float
    follows: str
    parts_s: tuple[float, ...]
    why: str

    @property
    def late_s(self) -> float:
        """Delay of the robot behind the dancers [s]; negative if it is early, NaN if it never moved."""
        return self.robot_s - self.t_s


@dataclass(frozen=True, slots=True)
class Graph:
    """Group topology graph of one iteration with A agents.

    Attributes:
        t_s: end of the iteration's window, session time [s].
        iteration: number of the iteration.
        agents: names of the vertices.
        pairs: (A, A) pairwise synchronisation indices.
        edges: (A, A) 1 where an edge leads from the row's to the column's agent, else 0.
        individual: (A,) individual synchronisation indices.
        follows: the dancer whom the robot followed, or "".
        gsi: group synchronisation index under these edges.
        gsi_full_edges: the index under all edges.
        gsi_truth: the index under all edges, from true onsets.
    """

    t_s: float
    iteration: int
    agents: tuple[str, ...]
    pairs: Array
    edges: Array
    individual: Array
    follows: str
    gsi: float
    gsi_full_edges: float
    gsi_truth: float

    @property
    def followed(self) -> str:
        """Whom the robot followed, in a word: a dancer, "nobody" or "everyone"; "" without a robot."""
        if ROBOT not in self.agents:
            return ""
        # The robot has an edge to everyone whom it follows.
        count = int(self.edges[self.agents.index(ROBOT)].sum())
        return self.follows or ("everyone" if count == len(self.agents) - 1 else "nobody" if not count else "several")


@dataclass(frozen=True, slots=True)
class DelayReport:
    """Everything that a recording shows beside the log.

    Attributes:
        graphs: one per danced iteration.
        steps: every step of every iteration, in order; empty without a robot.
        ta: (session time, timing appropriateness) of the robot's logged events [s], with the values of session.json.
        clocks: sensor -> (session times, clock errors) of its events [s].
    """

    graphs: tuple[Graph, ...] = ()
    steps: tuple[StepDelay, ...] = ()
    ta: tuple[tuple[float, float], ...] = ()
    clocks: Mapping[str, tuple[Array, Array]] = field(default_factory=dict)


CAUSES = {
    "sensor": "the sensor's frames", "detector": "detection", "network": "the network",
    "decision": "the method's own timing", "wheels": "the robot's way from command to motion",
}  # fmt: skip
"""Stage -> its name in a sentence; the dancer has a sentence of its own."""

LATE_S = 0.4
"""Delay from which a step is called late or early; about where people notice it (assumed)."""

TIMING_CLASSES = ("on time", "late", "early", "missed")
"""Results of `classify_step`."""


def classify_step(step: StepDelay) -> str:
    """Timing class of a step: one of `TIMING_CLASSES`; missed means that the robot never moved."""
    if math.isnan(step.late_s):
        return "missed"
    if abs(step.late_s) < LATE_S:
        return "on time"
    return "late" if step.late_s > 0 else "early"


def as_markdown(report: DelayReport) -> str:
    """Summary of a session in Markdown: a table of the iterations, the worst step of each, and missed steps."""
    lines = ["| iteration | robot followed | robot's steps | GSI, full edges |", "|---|---|---|---|"]
    for graph in report.graphs:
        steps = [step for step in report.steps if step.iteration == graph.iteration]
        counts = {name: sum(classify_step(step) == name for step in steps) for name in TIMING_CLASSES}
        summary = ", ".join(f"{count} {name}" for name, count in counts.items() if count) or "no robot"
        lines.append(f"| {graph.iteration} | {graph.followed or '-'} | {summary} | {graph.gsi_full_edges:.2f} |")

    lines.append("")
    for graph in report.graphs:
        off = [s for s in report.steps if s.iteration == graph.iteration and classify_step(s) in ("late", "early")]
        lines += [f"- {explain(step)}" for step in sorted(off, key=lambda step: -abs(step.late_s))[:1]]

    # Two missed steps are enough: a robot that stands still misses all of them for the same reason.
    lines += [f"- {explain(step)}" for step in report.steps if classify_step(step) == "missed"][:2]
    return "\n".join(lines)


def explain(step: StepDelay) -> str:
    """One sentence about a step: how late or early it was, and the stage with the largest part of that."""
    name = step.kind.value.replace("_", " ")
    if classify_step(step) == "missed":
        return f"{step.t_s:.1f} s, {name}: the robot missed it ({step.why})"

    late = step.late_s > 0
    word = "late" if late else "early"
    return f"{step.t_s:.1f} s, {name}: robot {abs(step.late_s):.2f} s {word}; {_main_cause(step, late)}"


def _main_cause(step: StepDelay, late: bool) -> str:
    """The stage that contributes most to a delay, or to the earliness of a step, in words."""
    sign = 1.0 if late else -1.0
    known = [(sign * part, stage) for part, stage in zip(step.parts_s, STAGES, strict=True) if not math.isnan(part)]

    # The robot may move without a command, for example after an earlier one: then no part is known.
    if not known:
        return f"no command ({step.why})"

    largest_s, stage = max(known)
    if stage == "dancer":
        return f"{step.follows}, whom it followed, was {largest_s:.2f} s {'late' if late else 'early'} too"
    return f"mostly {CAUSES[stage]} ({largest_s:.2f} s): {step.why}"
