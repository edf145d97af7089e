"""What a session leaves behind: rows of its logs, and the log as a whole; clocks as in `types`."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from . import Array, Cue, DeviceEvent, Event, Kind, MoveCommand


@dataclass(frozen=True, slots=True)
class AgentEvent:
    """One thing that an agent did, from an event table, odometry or the truth.

    Attributes:
        iteration: 0 for the rehearsal, then 1, 2, ...
        agent: ``dancer_1``..., or ``robot``.
        kind: what it did.
        t_s: session time.
        visible: whether the active sensor could see it (truth only; True elsewhere).
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
        session: which session.
        iteration: 0 for a rehearsal, then 1, 2, ...
        agent: who; ``robot`` for a robot.
        kind: what they did.
        t_s: when, on the session's clock.
        early: whether the row announces an event that another row tells of.
        line: where it stands: the line of a CSV file, the row of a Parquet file counted from 1.
    """

    session: str
    iteration: int
    agent: str
    kind: Kind
    t_s: float
    early: bool
    line: int


def natural_order(agent: str) -> tuple[tuple[str, int], ...]:
    """A key that sorts agents' names as people count: p2 before p10."""
    return tuple((word, int(number or 0)) for word, number in re.findall(r"(\D*)(\d*)", agent))


@dataclass(frozen=True, slots=True)
class Decision:
    """One line of the decision log: what was decided, when, and on what evidence."""

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
    """Something that went wrong, named: a dead sensor, a jumped clock, a blocked robot, a fallen dancer."""

    t_s: float
    source: str
    what: str


@dataclass(frozen=True, slots=True)
class Handover:
    """From when on a sensor's client was the active one."""

    t_s: float
    sensor: str


@dataclass(frozen=True, slots=True)
class Followed:
    """Whom the robot's method followed in an iteration, or "" for nobody; without a row it made use of everyone."""

    iteration: int
    person: str


@dataclass(frozen=True, slots=True)
class DepthPicture:
    """One depth image of the active sensor: 16-bit PNG of whole millimetres, 0 where there is none."""

    t_s: float
    sensor: str
    png: bytes


@dataclass(frozen=True, slots=True)
class SessionLog:
    """Everything a session leaves behind; read back from a session's folder it is the same value.

    Attributes:
        config: the full configuration as plain data.
        versions: package versions by name.
        cues: what each dancer planned, at the times they performed.
        device_events: events on device clocks, with ``t_sent_s``, the true time of sending (for judging clocks).
        events: events in session time, as the method was told of them.
        commands: orders sent to the robot.
        decisions: the method's decision log.
        robot_events: the robot's events, from its odometry.
        notices: what went wrong.
        odometry: columns of equal length at the odometry rate (t_s, x_m, y_m, heading_rad, step_m,
            yaw_rate_rad_s, true_x_m, true_y_m, true_heading_rad).
        truth: columns of equal length, one row per (tick, dancer): see `recorder.TRUTH_COLUMNS`.
        handovers: which sensor's client was active from when on.
        followed: whom the method followed, for methods that can tell.
        joints: (F, D, 25, 3) float32 true joints at 30 Hz, or None in a log read from a folder.
        skeletons: (F, D, 25, 4) float32 joints in the world as the active client saw them at the same frames, and
            their tracking state; NaN where it took no frame or lost the joint. None in a log read from a folder.
        depth: depth images of the active sensor, if they were asked for; kept in the recording alone.
        cost: ``sim_s``, ``cpu_s`` and ``wall_s``.
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
