"""Random scenes for training: dancers of random builds in postures of planned motions, anywhere in front of a sensor.

There is no physics and no balance: bodies are set to planned postures with small random errors.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ..assets.names import ACTUATED_INDEX
from ..choreography.layout import Mount, layout
from ..config import BodyConfig, PhysicsConfig, RobotConfig, SessionConfig
from ..core import Array, BoolArray, Cue, Geoms, Move
from ..core.clock import stream
from ..humans.body.anatomy import Anatomy, Build
from ..humans.body.proportions import scaled_anatomy
from ..humans.motion.planner import Planner
from ..humans.motion.reference_trajectory import ReferenceTrajectory
from ..simulation.physics import Physics

STATURE_M = (1.50, 1.95)
"""Smallest and largest stature."""

MASS_KG = (50.0, 100.0)
"""Smallest and largest mass."""

RATE_HZ = 30
"""Rate of plans and frames."""

PLAN_S = 16.0
"""Duration of a plan from which postures are drawn."""

STEP_M = 0.5
"""Length of a step forward or backward."""

MIN_DISTANCE_M = 0.55
"""Smallest distance on the floor between two dancers."""

MIN_ROBOT_DISTANCE_M = 0.40
"""Smallest distance on the floor between the robot and a dancer."""

DEPTH_M = (1.7, 4.3)
"""Smallest and largest distance of dancers from the sensor along its axis."""

MAX_SLOPE = 0.58
"""Largest distance from the sensor's axis over the distance along it; inside the horizontal field of view."""

CLAP_SHARE = 0.3
"""Share of postures drawn from claps; hands in front of the trunk are small and need many examples."""

ARM_SHARE = 0.25
"""Share of postures in which one arm is set to random angles, so that hands are found outside the dance as well."""

HINGE_ERROR_RAD = math.radians(2.5)
"""Standard deviation of a hinge from the plan, as in simulated physics."""

TILT_ERROR_RAD = math.radians(2.0)
"""Standard deviation of the trunk's tilt from the plan."""

NECK_ERROR_RAD = 0.2
"""Standard deviation of the head's turn."""

SCENES_PER_CAST = 20
"""Number of scenes before new dancers are drawn."""

_ARM_HINGES = [ACTUATED_INDEX[f"{name}_{side}"] for side in "LR" for name in ("shoulder_y", "shoulder_x", "elbow")]
_ARM_LOW_RAD = np.radians([-110, -10, -130] * 2)
_ARM_HIGH_RAD = np.radians([20, 60, -5] * 2)
_NECK = ACTUATED_INDEX["neck_z"]


@dataclass(frozen=True, slots=True)
class Scene:
    """One scene of D dancers, with the truth.

    Attributes:
        geoms: all visible geoms.
        joints_m: (D, 25, 3) true joints in the world [m].
        yaw_rad: (D,) headings relative to facing the sensor.
        stature_m: (D,) statures.
        danced: (D,) whether the posture is one of the dance: no arm is set to random angles.
    """

    geoms: Geoms
    joints_m: Array
    yaw_rad: Array
    stature_m: Array
    danced: BoolArray


def random_build(rng: np.random.Generator) -> Build:
    """Return a build, uniform over the range of statures and masses."""
    return Build(float(rng.uniform(*STATURE_M)), float(rng.uniform(*MASS_KG)))


def random_dance(rng: np.random.Generator, dancer: str, length_s: float = PLAN_S) -> list[Cue]:
    """Return moves in the order of the dance (forward, backward, clap, turn) with random holds and durations."""
    cues: list[Cue] = []
    t_s = 1.5 + rng.uniform(0.0, 0.5)
    order = (Move.FORWARD, Move.BACKWARD, Move.CLAP, Move.TURN)
    # Start with a step forward or with a clap.
    step = int(rng.integers(2)) * 2
    while t_s < length_s - 3.0:
        move = order[step % 4]
        duration_s = 0.0 if move is Move.CLAP else float(rng.uniform(1.6, 2.2))
        cues.append(Cue(dancer, move, 0, len(cues), 0.0, t_s, duration_s))
        t_s += duration_s + float(rng.uniform(0.9, 1.3))
        step += 1
    return cues


def planned_motion(
    body: Anatomy,
    cues: list[Cue],
    length_s: float = PLAN_S,
    *,
    slot: Array | None = None,
    heading_rad: float = 0.0,
) -> ReferenceTrajectory:
    """Return the planned motion of one dancer at 30 Hz; the dancer rests after the last cue.

    Args:
        body: the dancer's body.
        cues: the moves.
        length_s: duration.
        slot: (2,) place at the start [m]; by default the origin.
        heading_rad: heading at the start.
    """
    reference = ReferenceTrajectory.empty(1, round(length_s * RATE_HZ)).for_dancer(0)
    start = np.zeros(2) if slot is None else slot
    planner = Planner(body, start, heading_rad, STEP_M, math.pi / 2, RATE_HZ, reference)
    planner.extend(cues, 0.0)

    # The planner fills rows up to the end of the last move.
    planned_rows = int(reference.planned_rows[0])
    for column in (reference.joints, reference.pelvis, reference.yaw):
        column[planned_rows:] = column[planned_rows - 1]
    return reference


class RandomCast:
    """Dancers of random builds and a robot in a scene of their own.

    Args:
        rng: random generator of builds, dances and postures.
        dancers: number of dancers.

    Attributes:
        mount: where the sensor is.
        stature_m: (D,) statures.
    """

    def __init__(self, rng: np.random.Generator, dancers: int = 3) -> None:
        self._rng = rng
        self._bodies = [scaled_anatomy(random_build(rng)) for _ in range(dancers)]
        dances = [random_dance(rng, "") for _ in self._bodies]
        self._plans = [planned_motion(body, cues) for body, cues in zip(self._bodies, dances, strict=True)]
        self._claps_s = [[cue.t_s for cue in cues if cue.move is Move.CLAP] for cues in dances]
        place = layout(SessionConfig())
        self.mount: Mount = place.mounts[0]
        self.stature_m = np.array([body.build.stature_m for body in self._bodies])
        self._physics = Physics(
            self._bodies, place, (0.0, 0.0), np.zeros((dancers, 25)), np.zeros((dancers, 3)), PhysicsConfig(),
            BodyConfig(), RobotConfig(),
        )  # fmt: skip

    def random_scene(self) -> Scene:
        """Return a scene with all dancers at random places, headings and postures."""
        rng = self._rng
        count = len(self._bodies)
        places = _random_places(rng, count + 1)
        yaw = np.array([_random_yaw(rng) for _ in range(count)])
        joints = np.zeros((count, 25))
        roots = np.zeros((count, 6))
        danced = np.ones(count, dtype=bool)
        for index, plan in enumerate(self._plans):
            row = self._random_row(index)
            joints[index] = plan.joints[row] + HINGE_ERROR_RAD * rng.standard_normal(25)
            if rng.random() < ARM_SHARE:
                arm = slice(0, 3) if rng.random() < 0.5 else slice(3, 6)
                joints[index, _ARM_HINGES[arm]] = rng.uniform(_ARM_LOW_RAD[arm], _ARM_HIGH_RAD[arm])
                danced[index] = False
            joints[index, _NECK] += NECK_ERROR_RAD * rng.standard_normal()

            # The north sensor looks along negative y; pi / 2 is the heading of a dancer who faces it.
            x_m, depth_m = places[index]
            roots[index, :3] = x_m, self.mount.position[1] - depth_m, plan.pelvis[row, 2]
            roots[index, 3] = math.pi / 2 + yaw[index]
            roots[index, 4:] = TILT_ERROR_RAD * rng.standard_normal(2)

        robot_x_m, robot_depth_m = places[-1]
        robot = (float(robot_x_m), float(self.mount.position[1] - robot_depth_m), float(rng.uniform(-3.1, 3.1)))
        self._physics.pose(joints, roots, robot)
        return Scene(self._physics.geoms, self._physics.joints_m, yaw, self.stature_m, danced)

    def _random_row(self, dancer: int) -> int:
        """Return a row of a dancer's plan; claps are drawn more often than their duration would give."""
        rng = self._rng
        claps_s = self._claps_s[dancer]
        if claps_s and rng.random() < CLAP_SHARE:
            # From the reach of the arms to their return.
            return round((float(rng.choice(claps_s)) + float(rng.uniform(-0.65, 0.55))) * RATE_HZ)
        return int(rng.integers(len(self._plans[dancer].yaw)))


def random_scenes(count: int, seed: int, name: str) -> Iterator[tuple[Mount, Scene]]:
    """Yield random scenes with the mount of the sensor that sees them.

    A scene is valid until the next one is drawn.

    Args:
        count: number of scenes.
        seed: seed of everything random.
        name: name of the random stream; training, tuning and evaluation must not share one.
    """
    rng = stream(seed, "training", name)
    cast = RandomCast(rng)
    for index in range(count):
        if index and index % SCENES_PER_CAST == 0:
            cast = RandomCast(rng)
        yield cast.mount, cast.random_scene()


def _random_yaw(rng: np.random.Generator) -> float:
    """Return a heading relative to facing the sensor; the headings at which claps and moves are detected are common."""
    share = rng.random()
    widest_deg = 35.0 if share < 0.30 else 115.0 if share < 0.65 else 180.0
    return math.radians(rng.uniform(-widest_deg, widest_deg))


def _random_places(rng: np.random.Generator, count: int) -> Array:
    """Return (N, 2) separate places: x to the sensor's left and distance along its axis [m]; the robot's is last."""
    places: list[Array] = []
    while len(places) < count:
        depth_m = rng.uniform(*DEPTH_M)
        place = np.array([rng.uniform(-MAX_SLOPE, MAX_SLOPE) * depth_m, depth_m])
        min_distance_m = MIN_DISTANCE_M if len(places) < count - 1 else MIN_ROBOT_DISTANCE_M
        if all(np.hypot(*(place - other)) > min_distance_m for other in places):
            places.append(place)
    return np.array(places)
