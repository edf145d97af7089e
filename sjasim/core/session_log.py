"""The log of a session, and the rows of its tables. Clocks are named as in `core`."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from . import Array, Cue, DeviceEvent, Event, Kind, MoveCommand


@dataclass(frozen=True, slots=True)
class AgentEvent:
    """Something that a dancer or the robot did, from an event table, from odometry or from the truth.

    Attributes:
        iteration: 0 for the rehearsal, then 1, 2, ...
        agent: ``dancer_1``..., or ``robot``.
        kind: what happened.
        t_s: session time.
        visible: whether the active sensor could see it; known of true events only, True elsewhere.
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
        kind: what happened.
        t_s: time on the session's clock.
        early: whether the row announces an event that has a row of its own.
        line: line in a CSV file, or row in a Parquet file counted from 1.
    """

    session: str
    iteration: int
    agent: str
    kind: Kind
    t_s: float
    early: bool
    line: int


def natural_order(agent: str) -> tuple[tuple[str, int], ...]:
    """Sorting key that puts numbers in names into numerical order: p2 before p10."""
    return tuple((word, int(number or 0)) for word, number in re.findall(r"(\D*)(\d*)", agent))


@dataclass(frozen=True, slots=True)
class Decision:
    """One row of the decision log: what the method decided, when, and on what evidence."""

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
    """A problem that was noticed: a dead sensor, a clock that jumped, a blocked robot, a fallen dancer."""

    t_s: float
    source: str
    what: str


@dataclass(frozen=True, slots=True)
class Handover:
    """The time from which a sensor's client was the active one."""

    t_s: float
    sensor: str


@dataclass(frozen=True, slots=True)
class Followed:
    """The dancer that the method followed in an iteration, "" for nobody. Without a row it used all dancers' events."""

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
    """Everything that a session leaves behind. Read from a session's folder it is the same value.

    Attributes:
        config: the full configuration as plain data.
        versions: package versions by name.
        cues: moves that the dancers performed, with their true times.
        device_events: events on device clocks, each with the true time of sending, by which clocks are evaluated.
        events: events in session time, as the method received them.
        commands: commands sent to the robot.
        decisions: decisions of the method.
        robot_events: events of the robot, from its odometry.
        notices: problems that were noticed.
        odometry: columns of equal length at the odometry rate (t_s, x_m, y_m, heading_rad, step_m,
            yaw_rate_rad_s, true_x_m, true_y_m, true_heading_rad).
        truth: columns of equal length, one row for each logged tick and dancer; see
            `ground_truth_recorder.TRUTH_COLUMNS`.
        handovers: changes of the active sensor.
        followed: dancers that the method followed, if it reports them.
        joints: (F, D, 25, 3) float32 true joints at 30 Hz; None in a log that was read from a folder.
        skeletons: (F, D, 25, 4) float32 joints in the world as the active client estimated them at the same frames, and
            their tracking state; NaN where it took no frame or lost the joint. None in a log read from a folder.
        depth: depth images of the active sensor, if they were asked for; only the recording keeps them.
        cost: ``sim_s``, ``cpu_s`` and ``wall_s`` [s].
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
