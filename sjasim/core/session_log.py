"""The log of a session, and the types of the rows of its tables. The names of time fields are explained in `core`."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from . import Array, Cue, DeviceEvent, Event, Kind, MoveCommand


@dataclass(frozen=True, slots=True)
class AgentEvent:
    """An event of a dancer or the robot, from an event table, from odometry or from ground truth.

    Attributes:
        iteration: 0 for the rehearsal, then 1, 2, ...
        agent: ``dancer_1``..., or ``robot``.
        kind: kind of the event.
        t_s: session time.
        visible: whether the event was visible to the active sensor. Computed for ground truth only; otherwise True.
    """

    iteration: int
    agent: str
    kind: Kind
    t_s: float
    visible: bool = True


@dataclass(frozen=True, slots=True)
class TableEvent:
    """One row of an event table.

    Attributes:
        session: name of the session.
        iteration: 0 for a rehearsal, then 1, 2, ...
        agent: name of the person; ``robot`` for a robot.
        kind: kind of the event.
        t_s: time of the event on the clock of the table.
        early: whether this is an early event, which announces a regular event in another row.
        line: line number in a CSV file, or row number in a Parquet file, from 1.
    """

    session: str
    iteration: int
    agent: str
    kind: Kind
    t_s: float
    early: bool
    line: int


def natural_order(agent: str) -> tuple[tuple[str, int], ...]:
    """Return a sorting key that orders names with numbers numerically: p2 before p10."""
    return tuple((word, int(number or 0)) for word, number in re.findall(r"(\D*)(\d*)", agent))


@dataclass(frozen=True, slots=True)
class Decision:
    """One row of the decision log: an action of the method for a step, with its time and reason.

    Attributes:
        t_s: session time of the decision.
        iteration: iteration of the step.
        ordinal: index of the step in the iteration, from 0.
        kind: kind of the step.
        action: outcome of the action.
        t_send_s: session time at which the command is to be sent.
        person: name of the dancer whose event led to the decision, or "".
        why: reason of the decision.
    """

    t_s: float
    iteration: int
    ordinal: int
    kind: Kind
    action: str
    t_send_s: float
    person: str
    why: str


@dataclass(frozen=True, slots=True)
class Notice:
    """A problem during a session, such as a dead sensor, a clock jump, a blocked robot or a fallen dancer.

    Attributes:
        t_s: session time.
        source: name of the sensor, agent or component that it concerns.
        what: description of the problem.
    """

    t_s: float
    source: str
    what: str


@dataclass(frozen=True, slots=True)
class Handover:
    """Session time from which a sensor's client was the active one."""

    t_s: float
    sensor: str


@dataclass(frozen=True, slots=True)
class Followed:
    """The dancer that the method followed in an iteration, or "" if it followed none.

    An iteration without a row is one in which the method used the events of all dancers.
    """

    iteration: int
    person: str


@dataclass(frozen=True, slots=True)
class DepthPicture:
    """One depth image of the active sensor: a 16-bit PNG in millimetres, 0 where there is no depth."""

    t_s: float
    sensor: str
    png: bytes


@dataclass(frozen=True, slots=True)
class SessionLog:
    """Complete result of a session. A log that is read from the session's folder has the same values, see below.

    Attributes:
        config: the full configuration as plain data.
        versions: package versions by name.
        cues: moves that the dancers performed, with their true times.
        device_events: events on device clocks, each with its true time of sending, for the evaluation of clocks.
        events: events in session time, as the method received them.
        commands: commands sent to the robot.
        decisions: decisions of the method.
        robot_events: events of the robot, detected in its odometry.
        notices: problems during the session.
        odometry: columns of equal length at the odometry rate (t_s, x_m, y_m, heading_rad, step_m,
            yaw_rate_rad_s, true_x_m, true_y_m, true_heading_rad).
        truth: columns of equal length, one row for each logged tick and dancer; see
            `ground_truth_recorder.TRUTH_COLUMNS`.
        handovers: changes of the active sensor.
        followed: dancers that the method followed, if it reports them.
        joints: (F, D, 25, 3) float32 true joint positions in the world at 30 Hz [m]; None in a log that was read from a
            folder.
        skeletons: (F, D, 25, 4) float32 joint positions in the world as estimated by the active client at the same
            frames [m], and tracking state; NaN if it captured no frame or did not track the joint. None in a log that
            was read from a folder.
        depth: depth images of the active sensor, if they were requested; stored in the rerun recording only.
        cost: simulated time ``sim_s``, CPU time ``cpu_s`` and elapsed time ``wall_s`` [s].
    """

    config: Mapping[str, object]
    versions: Mapping[str, str]
    cues: tuple[Cue, ...] = ()
    device_events: tuple[tuple[DeviceEvent, float], ...] = ()
    events: tuple[Event, ...] = ()
    commands: tuple[MoveCommand, ...] = ()
    decisions: tuple[Decision, ...] = ()
    robot_events: tuple[AgentEvent, ...] = ()
    notices: tuple[Notice, ...] = ()
    handovers: tuple[Handover, ...] = ()
    followed: tuple[Followed, ...] = ()
    odometry: Mapping[str, Array] = field(default_factory=dict)
    truth: Mapping[str, NDArray[np.generic]] = field(default_factory=dict)
    joints: NDArray[np.float32] | None = None
    skeletons: NDArray[np.float32] | None = None
    depth: tuple[DepthPicture, ...] = ()
    cost: Mapping[str, float] = field(default_factory=dict)
