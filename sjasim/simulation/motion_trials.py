"""Dancers without sensors: how well they move, how they take a push, what a robot does to them.

`OpenLoopWorld` is the physics of a session with nobody looking; the trials below dance, push and drive in it, and
`figures` says what came of them.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

import numpy as np

from ..analysis.motion_metrics import foot_slips, rise_times, timing_errors
from ..choreography.layout import layout
from ..choreography.timetable import timetable
from ..config import BodyConfig, DanceConfig, SessionConfig
from ..core import Array, Cue, Kind, Move, WheelCommand, dancer_name
from .physics_world import PhysicsWorld

FULL_RANGE = BodyConfig(stature_m=(1.50, 1.95), mass_kg=(50.0, 100.0))
"""Everybody that can be built."""
PUSH_S = 0.2
"""A push takes so long [s]."""


class OpenLoopWorld(PhysicsWorld):
    """A session's physics without sensing; the motion of every control step is recorded.

    Args:
        config: the session; its sensors stay idle.
        plans: cues of each dancer; None lets the human timing model decide, as in a session.
        robot: whether there is a robot.

    Attributes:
        wheels: constant wheel speeds of the robot; None lets its controller decide.
    """

    def __init__(
        self, config: SessionConfig, plans: Sequence[Sequence[Cue]] | None = None, *, robot: bool = True
    ) -> None:
        self._rows: list[tuple[Array, ...]] = []
        self.wheels: WheelCommand | None = None
        super().__init__(config, timetable(config), layout(config), robot=robot, given_cues=plans)

    def update_sensors(self, now: float) -> None:
        """Measure the load on the feet; no sensor captures anything."""
        self.physics.measure_load()

    def update_robot(self, now: float) -> None:
        """Drive the robot with constant wheel speeds, if these are given."""
        if self.wheels is None:
            super().update_robot(now)
        else:
            self.physics.drive(self.wheels)

    def run(self, until_s: float | None = None) -> OpenLoopWorld:
        """Go on to a time, or to the end."""
        until_s = self.end_s if until_s is None else until_s
        while self.time_s < until_s - 1e-9:
            self.advance(until_s)
        return self

    def update_dancers(self, now: float) -> None:
        """Run a control step and record the motion."""
        super().update_dancers(now)
        states, count = self.physics.states(), len(self._fallen)
        tick = np.minimum(round(now * self._config.physics.control_hz), self.reference.planned_rows - 1)
        planned, landing = (column[range(count), tick] for column in (self.reference.pelvis, self.reference.landing))
        palms = np.sqrt(((states.hands[:, 0] - states.hands[:, 1]) ** 2).sum(axis=1))
        feet = states.ankles[:, :, :2]
        self._rows.append((np.array(now), states.root, palms, feet, states.tether, states.load, planned, landing))

    def recording(self) -> MotionRecording:
        """What has been danced so far."""
        t_s, roots, palms, feet, tether, load, planned, landing = (
            np.array(column) for column in zip(*self._rows, strict=True)
        )
        weight, cues, falls = self.physics.servos.weight, tuple(self.cues), sum(self._fallen)
        return MotionRecording(t_s, roots, palms, feet, tether, load, planned, landing, weight, cues, falls)


@dataclasses.dataclass(frozen=True)
class MotionRecording:
    """Motion of D dancers at N ticks of balance.

    Attributes:
        t_s: (N,) [s].
        roots: (N, D, 6) pelvis x, y, z [m], yaw, pitch, roll [rad].
        palms: (N, D) distance between the hands [m].
        feet: (N, D, 2, 2) ankles on the floor, left and right [m].
        tether: (N, D, 5) forces [N] and torques [Nm].
        loads: (N, D) floor's force under the feet [N].
        planned: (N, D, 3) planned pelvis [m].
        landing: (N, D, 2) planned time until a swinging foot lands [s].
        weight: (D,) [N].
        cues: what was planned.
        falls: how many fell.
    """

    t_s: Array
    roots: Array
    palms: Array
    feet: Array
    tether: Array
    loads: Array
    planned: Array
    landing: Array
    weight: Array
    cues: tuple[Cue, ...]
    falls: int

    def completed_cues(self, dancer: int) -> list[Cue]:
        """One dancer's cues that are over."""
        return [
            cue for cue in self.cues
            if cue.dancer == dancer_name(dancer) and cue.t_s + cue.duration_s + 0.5 < self.t_s[-1]
        ]  # fmt: skip


def motion_figures(danced: Sequence[MotionRecording]) -> dict[str, float]:
    """Pooled figures: worst dancer where a figure is a dancer's, all events where it is an event's."""
    parts = [(m, d) for m in danced for d in range(len(m.weight))]
    off = [np.hypot(*(m.roots[:, d, :2] - m.planned[:, d, :2]).T) for m, d in parts]
    events = [
        pair for m, d in parts for pair in timing_errors(m.t_s, m.roots[:, d], m.palms[:, d], m.completed_cues(d))
    ]
    claps = np.array([error for kind, error in events if kind is Kind.CLAP])
    edges = np.array([error for kind, error in events if kind is not Kind.CLAP])
    rises = np.concatenate([rise_times(m.t_s, m.roots[:, d], m.completed_cues(d)) for m, d in parts])
    slid = np.concatenate([foot_slips(m.t_s, m.feet[:, d], m.landing[:, d]) for m, d in parts])
    return {
        "dances": len(danced),
        "dances_without_a_fall": sum(m.falls == 0 for m in danced),
        "falls": sum(m.falls for m in danced),
        "pelvis_error_mean_mm": 1e3 * max(float(one.mean()) for one in off),
        "pelvis_error_max_mm": 1e3 * max(float(one.max()) for one in off),
        "tether_rms_n": max(float(np.sqrt((m.tether[:, d, :2] ** 2).sum(axis=1).mean())) for m, d in parts),
        "feet_load_share": min(float(m.loads[:, d].mean() / m.weight[d]) for m, d in parts),
        "crossing_bias_ms": 1e3 * _mean(edges),
        "crossing_p95_ms": 1e3 * _p95(edges),
        "crossings_missing": int(np.isnan(edges).sum()),
        "clap_p95_ms": 1e3 * _p95(claps),
        "claps_missing": int(np.isnan(claps).sum()),
        "rise_p95_s": _p95(rises),
        "slip_median_mm": 1e3 * float(np.median(slid)) if len(slid) else math.nan,
        "slip_p95_mm": 1e3 * _p95(slid),
    }


def _mean(values: Array) -> float:
    known = values[~np.isnan(values)]
    return float(known.mean()) if len(known) else math.nan


def _p95(values: Array) -> float:
    known = np.abs(values[~np.isnan(values)])
    return float(np.percentile(known, 95)) if len(known) else math.nan


def dance_trial(seed: int, iterations: int = 4, **changes: object) -> MotionRecording:
    """A whole dance by three people of any build, with a paper's group's jitter; the robot stands by."""
    config = SessionConfig(
        seed=seed, iterations=iterations, method="none", body=FULL_RANGE, dance=DanceConfig(rehearsal=False)
    )
    return OpenLoopWorld(dataclasses.replace(config, **changes), robot=False).run().recording()  # type: ignore[arg-type]


def walking_trial(seed: int, duration_s: float, moves: int = 4, hold_s: float = 1.0) -> OpenLoopWorld:
    """Three people of any build who go forward and backward in moves of a given time."""
    config = SessionConfig(seed=seed, iterations=1, method="none", body=FULL_RANGE, dance=DanceConfig(rehearsal=False))
    plans = []
    for dancer in range(config.dancers):
        starts = 2.0 + 0.1 * dancer + (duration_s + hold_s) * np.arange(moves)
        ways = (Move.FORWARD, Move.BACKWARD) * moves
        plans.append([
            Cue(dancer_name(dancer), way, 1, 2 * index, 0.0, float(t_s), duration_s)
            for index, (way, t_s) in enumerate(zip(ways, starts, strict=False))
        ])  # fmt: skip
    return OpenLoopWorld(config, plans, robot=False)


def timed_moves_trial(seed: int, duration_s: float) -> MotionRecording:
    """What becomes of four moves of a given time."""
    return walking_trial(seed, duration_s).run(2.7 + 4 * (duration_s + 1.0)).recording()


def count_falls_after_push(seed: int, impulse_ns: float, *, walking: bool) -> int:
    """How many of three people fall who are pushed sideways, once each, one to the left, the next to the right."""
    trial = walking_trial(seed, 2.0, moves=4 if walking else 0).run(2.5)
    for dancer in range(3):
        left = float(trial.physics.yaw_rad[dancer]) + math.pi / 2
        force = (-1) ** (seed + dancer) * impulse_ns / PUSH_S * np.array([math.cos(left), math.sin(left), 0.0])
        trial.physics.push(dancer, force)
        trial.run(trial.time_s + PUSH_S)
        trial.physics.push(dancer, np.zeros(3))
        trial.run(trial.time_s + 0.13)
    return trial.run(trial.time_s + 5.0).recording().falls


@dataclasses.dataclass(frozen=True)
class Collision:
    """A robot that drove into a standing dancer.

    Attributes:
        peak_n: greatest force between them.
        sway_m: how far the dancer's pelvis was moved at most.
        speed_m_s: the robot's speed towards the dancer at the end, while it is still driven.
        falls: how many dancers fell.
    """

    peak_n: float
    sway_m: float
    speed_m_s: float
    falls: int


def collision_trial(seed: int, from_rad: float, speed_m_s: float = 0.5) -> Collision:
    """Drive the robot into the first of three standing people of any build.

    Args:
        seed: whose build.
        from_rad: where the robot comes from, as the dancer sees it: 0 from ahead, counter-clockwise.
        speed_m_s: how fast; it drives on whatever happens.
    """
    trial = walking_trial(seed, 2.0, moves=0)
    trial = OpenLoopWorld(trial._config, [[], [], []])
    physics, robot = trial.physics, trial._config.robot
    root = physics.states().root[0]
    bearing = float(root[3]) + from_rad
    begin = root[:2] + 0.9 * np.array([math.cos(bearing), math.sin(bearing)])
    roots = np.concatenate([trial.reference.pelvis[:, 0], np.zeros((3, 3))], axis=1)
    roots[:, 3] = physics.yaw_rad
    physics.pose(trial.reference.joints[:, 0], roots, (float(begin[0]), float(begin[1]), bearing + math.pi))
    turn = speed_m_s / robot.wheel_radius_m
    trial.wheels = WheelCommand(turn, turn)
    peak, sway, tick_s = 0.0, 0.0, 1.0 / physics.ticks.rate_hz
    ends: list[Array] = []
    while trial.time_s < 4.0 - 1e-9:
        trial.run(trial.time_s + tick_s)
        peak = max(peak, physics.contacts.impact_n())
        sway = max(sway, float(np.hypot(*(physics.states().root[0, :2] - root[:2]))))
        ends.append(np.array(physics.robot_pose()[:2]))
    towards = -np.array([math.cos(bearing), math.sin(bearing)])
    back = round(0.5 / tick_s)
    return Collision(peak, sway, float((ends[-1] - ends[-1 - back]) @ towards / 0.5), trial.recording().falls)
