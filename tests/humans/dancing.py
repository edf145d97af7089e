"""Dancers in physics without sensors: plans, balance and physics as in a session, and measures of the motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from sjasim.analysis.ground_truth_events import detect_claps, detect_moves
from sjasim.choreography.layout import layout
from sjasim.choreography.score import MOVE_EVENTS, Choreography
from sjasim.choreography.timetable import Timetable
from sjasim.config import BodyConfig, PhysicsConfig, RobotConfig, SessionConfig
from sjasim.core import Array, Cue, Kind, Move, dancer_name
from sjasim.core.registry import resolve
from sjasim.core.tempo import TempoMap
from sjasim.humans.body.anatomy import Anatomy, Build
from sjasim.humans.body.proportions import scaled_anatomy
from sjasim.humans.motion.balance_controller import BalanceController, BalanceGains
from sjasim.humans.motion.planner import Planner
from sjasim.humans.motion.reference_trajectory import ReferenceTrajectory
from sjasim.simulation.control_loop import DancerController
from sjasim.simulation.ground_truth_recorder import GroundTruthRecorder
from sjasim.simulation.physics import Physics

HZ = PhysicsConfig().control_hz
TICKS = PhysicsConfig().rate_hz // HZ
NORTH = np.pi / 2


def dance(name: str = "paper") -> Choreography:
    """A registered dance."""
    return resolve("choreography", name).factory()


def builds(count: int, seed: int) -> list[Anatomy]:
    """Bodies of random stature and mass."""
    rng = np.random.default_rng(seed)
    return [scaled_anatomy(Build(rng.uniform(1.50, 1.95), rng.uniform(50, 100))) for _ in range(count)]


def walk_cue(move: Move, t_s: float, duration_s: float, dancer: int = 0) -> Cue:
    """Cue of a single move in iteration 1."""
    return Cue(dancer_name(dancer), move, 1, 0, 0.0, t_s, duration_s)


def jittered(timetable: Timetable, iteration: int, dancer: int, rng: np.random.Generator, sd_s: float) -> list[Cue]:
    """One iteration's cues with independent jitter at every event, no move under .8 s, no hold under .15 s."""
    cues: list[Cue] = []
    free = 0.0

    for index, item in enumerate(timetable.choreography.moves):
        t = timetable.time_s(iteration, item.beat) + float(np.clip(rng.normal(0, sd_s), -0.6, 0.6))
        end = timetable.time_s(iteration, item.beat + item.beats) + float(np.clip(rng.normal(0, sd_s), -0.6, 0.6))
        t = max(t, free)
        duration = max(end - t, 0.8) if len(MOVE_EVENTS[item.move]) == 2 else 0.0
        if item.move is Move.TURN:
            t = cues[-1].t_s + 0.25
            duration = 1.8

        ordinal = timetable.choreography.first_ordinal(index)
        cues.append(Cue(dancer_name(dancer), item.move, iteration, ordinal, item.beat, t, duration))
        free = t + duration + 0.15

    return cues


def at_rest(reference: ReferenceTrajectory) -> ReferenceTrajectory:
    """One dancer's trajectory, with rows that are not planned filled as they are read: by the last planned one."""
    planned = int(reference.planned_rows[0])
    reference.rows[planned:] = reference.rows[planned - 1]
    return reference


@dataclass
class Floor:
    """Physics with planners and balance controllers; the columns of ``truth`` have a row for each control step."""

    bodies: list[Anatomy]
    seconds: float
    heading: float = NORTH
    turn_rad: float = NORTH
    robot: RobotConfig | None = None
    body: BodyConfig = field(default_factory=BodyConfig)
    gains: BalanceGains | None = None
    slots: Array | None = None

    def __post_init__(self) -> None:
        count = len(self.bodies)
        place = layout(SessionConfig(dancers=min(count, 3)))
        if self.slots is not None:
            place = replace(place, dancers=self.slots)

        self.ticks = round(self.seconds * HZ)
        self.reference = ReferenceTrajectory.empty(count, self.ticks + 120)
        self.planners = [
            Planner(body, place.dancers[i], self.heading, 0.5, self.turn_rad, HZ, self.reference.for_dancer(i))
            for i, body in enumerate(self.bodies)
        ]

        start = self.reference.joints[:, 0].copy(), self.reference.pelvis[:, 0].copy()
        self.physics = Physics(
            self.bodies, place, (self.heading, NORTH), *start, PhysicsConfig(), self.body, self.robot
        )

        omega = np.array([planner.omega for planner in self.planners])
        balance = BalanceController(self.reference, omega, HZ, self.physics.servos, self.gains)
        self.controller = DancerController(self.physics, balance, GroundTruthRecorder(self.physics.servos.weight, 1))

        self.cues: list[list[Cue]] = [[] for _ in self.bodies]
        self.tick = 0
        self.truth: dict[str, list[Array]] = {name: [] for name in ("roots", "support", "loads", "hands", "joints")}

    def plan(self, dancer: int, cues: Sequence[Cue], now_s: float) -> None:
        """Plan further cues of a dancer."""
        self.cues[dancer] += cues
        self.planners[dancer].extend(cues, now_s)

    def run(self, seconds: float | None = None) -> Floor:
        """Continue for a time, or to the end."""
        last = self.ticks if seconds is None else self.tick + round(seconds * HZ)
        for tick in range(self.tick, last):
            self.controller.step(tick, tick / HZ)
            self.physics.step_to((tick + 1) * TICKS)
            self.physics.measure_load()

            states = self.physics.states()
            gaps = np.linalg.norm(states.hands[:, 0] - states.hands[:, 1], axis=1)
            rows = states.root, states.tether, states.load, gaps
            for column, row in zip(self.truth.values(), (*rows, self.physics.joints_m), strict=True):
                column.append(np.array(row))

        self.tick = last
        return self

    def column(self, name: str) -> Array:
        """(T, ...) one column of ``truth``."""
        return np.array(self.truth[name])

    @property
    def times(self) -> Array:
        """(T,) session times of the rows of ``truth`` [s]."""
        return (np.arange(len(self.truth["roots"])) + 1) / HZ

    @property
    def fell(self) -> bool:
        """Whether the pelvis of a dancer was ever lower than 65 % of its standing height."""
        standing = np.array([body.standing_m for body in self.bodies])
        return bool((self.column("roots")[:, :, 2] < 0.65 * standing).any())

    def pelvis_errors(self) -> Array:
        """(T, D) distance between planned and true pelvis on the floor [m]."""
        for dancer in range(len(self.bodies)):
            at_rest(self.reference.for_dancer(dancer))
        planned = self.reference.pelvis[:, 1 : len(self.times) + 1, :2].swapaxes(0, 1)
        return np.linalg.norm(self.column("roots")[:, :, :2] - planned, axis=2)

    def support_n(self) -> Array:
        """(T, D) horizontal force of the balance support [N]."""
        force = self.column("support")
        return np.hypot(force[..., 0], force[..., 1])

    def event_errors(self, dancer: int) -> list[tuple[Kind, float, float]]:
        """(kind, true minus planned time, planned duration of the move) of every start, stop and clap.

        The error of a missing event is NaN. Starts and stops are crossings of .10 m/s by the speed of SpineBase along
        the heading.
        """
        roots = self.column("roots")[:, dancer]
        found = detect_moves(self.times, roots[:, 0], roots[:, 1], roots[:, 3])
        found += [(t, Kind.CLAP) for t in detect_claps(self.times, self.column("hands")[:, dancer])]

        errors = []
        for cue in self.cues[dancer]:
            for kind, t_s in cue.events():
                near = [t for t, other in found if other is kind and abs(t - t_s) < 0.4]
                errors.append((kind, min((t - t_s for t in near), key=abs, default=np.nan), cue.duration_s))
        return errors


def paper_floor(bodies: list[Anatomy], seed: int, iterations: int = 1, sd_s: float = 0.1, lead_in_s: float = 2.0,
                name: str = "paper", **options) -> Floor:  # fmt: skip
    """Dancers with plans for whole iterations of a dance."""
    choreography = dance(name)
    timetable = Timetable(choreography, TempoMap.steady(118), lead_in_s, 1, iterations)
    floor = Floor(bodies, timetable.close_s(iterations) + 1.5, turn_rad=choreography.turn_rad, **options)
    rng = np.random.default_rng([seed, 7])

    for dancer in range(len(bodies)):
        for iteration in range(1, iterations + 1):
            cues = jittered(timetable, iteration, dancer, rng, sd_s)
            floor.plan(dancer, cues, max(0.0, timetable.start_s(iteration) - 2.0))

    return floor
