"""What a recording shows beside the log, each figure with its time; `analysis.delay_breakdown` finds them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from ...core import Array, Kind

STAGES = ("dancer", "sensor", "detector", "network", "decision", "wheels")
"""Parts of the way from the group's mean time of a step to the robot's: how far the followed dancer was from the
mean; from the onset to the frame that shows it processed at the earliest; what detection takes beyond that; the
network; the method; from command to motion. Without a followed dancer all but the last are the decision's."""


@dataclass(frozen=True, slots=True)
class StepDelay:
    """One step of the robot: when it moved, when the group did, and where the difference arose.

    Attributes:
        iteration: from 1.
        ordinal: place in the iteration.
        kind: the dancers' event that the step answers.
        t_s: when the dancers did it, on average; true onsets.
        robot_s: when the robot did, or NaN if it never did.
        follows: the dancer whose event decided the command, or "".
        parts_s: seconds by `STAGES`, adding up to ``late_s``; those that do not apply are NaN.
        why: the method's own words.
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
        """How much later than the dancers the robot moved; negative if earlier, NaN if never [s]."""
        return self.robot_s - self.t_s


@dataclass(frozen=True, slots=True)
class Graph:
    """The group topology graph of one iteration.

    Attributes:
        t_s: when the iteration's window closed.
        iteration: which.
        agents: the vertices.
        pairs: (H, H) pair indices.
        edges: (H, H) whether an edge leads from row to column.
        individual: (H,) individual indices.
        follows: whom the robot followed, or "".
        gsi: the group index under these edges.
        gsi_full_edges: under all edges.
        gsi_truth: under all edges, from true onsets.
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


@dataclass(frozen=True, slots=True)
class DelayReport:
    """Everything beside the log.

    Attributes:
        graphs: one per danced iteration.
        steps: every step of every iteration in order; none without a robot.
        ta: (time, value) of timing appropriateness from logged times [s], as session.json has it.
        clocks: sensor -> (time, error) of its events in session time [s].
    """

    graphs: tuple[Graph, ...] = ()
    steps: tuple[StepDelay, ...] = ()
    ta: tuple[tuple[float, float], ...] = ()
    clocks: Mapping[str, tuple[Array, Array]] = field(default_factory=dict)


CAUSES = {
    "sensor": "the sensor's frames", "detector": "detection", "network": "the network",
    "decision": "the method's own timing", "wheels": "the robot's way from command to motion",
}  # fmt: skip
"""Name of a stage -> what a sentence calls it; the dancer has a sentence of its own."""

LATE_S = 0.4
"""From here on a robot is called late or early: where people begin to see it (assumed)."""


def classify_step(step: StepDelay) -> str:
    """``on time``, ``late``, ``early`` or ``missed``."""
    if math.isnan(step.late_s):
        return "missed"
    return "on time" if abs(step.late_s) < LATE_S else "late" if step.late_s > 0 else "early"


def as_markdown(report: DelayReport) -> str:
    """What happened, as a short text in Markdown: an iteration a line, then each one's worst step and why."""
    lines = ["| iteration | robot followed | robot's steps | GSI, full edges |", "|---|---|---|---|"]
    for graph in report.graphs:
        steps = [step for step in report.steps if step.iteration == graph.iteration]
        counts = {
            word: sum(classify_step(step) == word for step in steps) for word in ("on time", "late", "early", "missed")
        }
        said = ", ".join(f"{count} {word}" for word, count in counts.items() if count) or "no robot"
        whom = graph.follows or ("nobody in particular" if steps else "-")
        lines.append(f"| {graph.iteration} | {whom} | {said} | {graph.gsi_full_edges:.2f} |")
    lines.append("")
    for graph in report.graphs:
        off = [s for s in report.steps if s.iteration == graph.iteration and classify_step(s) in ("late", "early")]
        lines += [f"- {explain(step)}" for step in sorted(off, key=lambda step: -abs(step.late_s))[:1]]
    lines += [f"- {explain(step)}" for step in report.steps if classify_step(step) == "missed"][:2]
    return "\n".join(lines)


def explain(step: StepDelay) -> str:
    """One step in a sentence: how late, and the stage that explains most of it."""
    name = step.kind.value.replace("_", " ")
    if classify_step(step) == "missed":
        return f"{step.t_s:.1f} s, {name}: the robot missed it ({step.why})"
    sign = 1.0 if step.late_s > 0 else -1.0
    known = [(sign * part, stage) for part, stage in zip(step.parts_s, STAGES, strict=True) if not math.isnan(part)]
    most, stage = max(known)
    word = "late" if sign > 0 else "early"
    if stage == "dancer":
        reason = f"{step.follows}, whom it followed, was {most:.2f} s {word} too"
    else:
        reason = f"mostly {CAUSES[stage]} ({most:.2f} s): {step.why}"
    return f"{step.t_s:.1f} s, {name}: robot {abs(step.late_s):.2f} s {word}; {reason}"
