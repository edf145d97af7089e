"""Tables of a study: the columns of the data set, and their meaning, type and unit.

A study has four tables, which share the key ``session``. Every analysis of a study reads these tables and nothing else,
so that it works on simulated studies and on those of a laboratory. The codebook that is written beside a data set is
made from `COLUMNS`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Columns = Mapping[str, NDArray[np.generic]]
"""Name -> (N,) values of a column; all columns of a table have the same length."""


@dataclass(frozen=True, slots=True)
class Column:
    """Type and meaning of a column.

    Attributes:
        dtype: NumPy type; ``str`` columns have the type object.
        meaning: what the value is, with its unit.
    """

    dtype: str
    meaning: str


SESSIONS: Mapping[str, Column] = {
    "session": Column("int64", "number of the session in the study, from 0; the key of all tables"),
    "study": Column("int64", "replication of the whole study, from 0"),
    "group": Column("int64", "group of people within the study, from 1"),
    "order": Column("int64", "position of the session among those of its group, from 1"),
    "condition": Column("str", "name of the condition: the method, and the levels of the design's factors"),
    "method": Column("str", "anticipation method; none for a session without a robot"),
    "humans": Column("str", "human timing model"),
    "seed": Column("int64", "seed of the session; sessions of one group have the same seed, hence the same persons"),
    "gsi": Column("float64", "group synchronisation index, mean over iterations, under the paper's edges"),
    "gsi_full_edges": Column("float64", "group synchronisation index, mean over iterations, under all edges"),
    "gsi_humans": Column("float64", "group synchronisation index of the dancers alone, mean over iterations"),
    "ta_mean_s": Column("float64", "mean timing appropriateness of the robot [s]; NaN without a robot"),
    "robot_missed": Column("int64", "number of steps that the robot did not perform"),
}
"""One row for each session. Columns ``factor.NAME`` follow, with the levels of the factors of the design."""

ITERATIONS: Mapping[str, Column] = {
    "session": Column("int64", "the session"),
    "iteration": Column("int64", "iteration of the dance, from 1; the rehearsal has no row"),
    "gsi": Column("float64", "group synchronisation index under the paper's edges"),
    "gsi_full_edges": Column("float64", "group synchronisation index under all edges"),
    "gsi_humans": Column("float64", "group synchronisation index of the dancers alone"),
    "msp": Column("int64", "most synchronous dancer, from 1; 0 without events"),
    "followed": Column("int64", "dancer whom the robot followed, from 1; 0 if it followed nobody or several dancers"),
    "ta_mean_s": Column("float64", "mean timing appropriateness of the robot [s]; NaN without a robot"),
    "robot_missed": Column("int64", "number of steps that the robot did not perform"),
}
"""One row for each danced iteration of each session."""

STEPS: Mapping[str, Column] = {
    "session": Column("int64", "the session"),
    "iteration": Column("int64", "iteration of the dance, from 1"),
    "ordinal": Column("int64", "step of the dance within the iteration, from 0"),
    "ta_s": Column("float64", "timing appropriateness: distance from the dancers' mean time [s]; NaN if missed"),
    "latency_s": Column("float64", "robot's time minus that of the dancer who triggered the step [s]; else NaN"),
}
"""One row for each step of the robot; none in sessions without a robot."""

EVENTS: Mapping[str, Column] = {
    "session": Column("int64", "the session"),
    "iteration": Column("int64", "iteration of the dance, from 1"),
    "agent": Column("int64", "dancer, from 1; 0 is the robot"),
    "kind": Column("str", "kind of the event; the robot's turn stands where the dancers clap"),
    "t_s": Column("float64", "time of the logged event since beat 0 of its iteration [s]"),
}
"""One row for each logged regular event of the dancers and each event of the robot, in order of time per agent."""

COLUMNS: Mapping[str, Mapping[str, Column]] = {
    "sessions": SESSIONS,
    "iterations": ITERATIONS,
    "steps": STEPS,
    "events": EVENTS,
}
"""Table -> column -> type and meaning."""

FACTOR_PREFIX = "factor."
"""Prefix of the columns of the table ``sessions`` that hold the levels of the design's factors."""


@dataclass(frozen=True, slots=True)
class StudyTables:
    """The tables of a study, each as columns of equal length; see `COLUMNS`.

    Attributes:
        sessions: one row for each session.
        iterations: one row for each danced iteration.
        steps: one row for each step of the robot.
        events: one row for each event; without rows if the study did not keep events.
    """

    sessions: Columns
    iterations: Columns
    steps: Columns
    events: Columns
