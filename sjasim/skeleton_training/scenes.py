"""Scenes to learn from: dancers of random build in postures of real plans, anywhere before a sensor, at any heading.

Nobody balances here: postures are put on the stage without physics, with small errors of their own.
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

STATURE_M, MASS_KG = (1.50, 1.95), (50.0, 100.0)
RATE_HZ, PLAN_S = 30, 16.0
APART_M = 0.55
"""Least distance between two dancers over the floor."""
CLAPPING = 0.3
"""Share of postures drawn from claps: hands before the trunk are small, and must be found."""
SLACK_RAD, TILT_RAD = math.radians(2.5), math.radians(2.0)
"""Standard deviations of what a hinge and the trunk differ from the plan, as physics makes them."""
_ARMS = [ACTUATED_INDEX[f"{name}_{side}"] for side in "LR" for name in ("shoulder_y", "shoulder_x", "elbow")]
_ARM_LOW, _ARM_HIGH = np.radians([-110, -10, -130] * 2), np.radians([20, 60, -5] * 2)
_NECK = ACTUATED_INDEX["neck_z"]


@dataclass(frozen=True, slots=True)
class Scene:
    """One instant of a stage, with the truth.

    Attributes:
        geoms: what there is to see.
        joints_m: (D, 25, 3) true joints in the world [m].
        yaw_rad: (D,) headings relative to facing the sensor.
        stature_m: (D,) of the dancers.
        danced: (D,) whether the posture is one of the dance: no arm was put elsewhere.
    """

    geoms: Geoms
    joints_m: Array
    yaw_rad: Array
    stature_m: Array
    danced: BoolArray


def random_build(rng: np.random.Generator) -> Build:
    """A person from the whole range of statures and masses."""
    return Build(float(rng.uniform(*STATURE_M)), float(rng.uniform(*MASS_KG)))


def dance(rng: np.random.Generator, name: str, length_s: float = PLAN_S) -> list[Cue]:
    """Moves in the order of the dance (forward, backward, clap, turn), with random pauses and lengths."""
    cues: list[Cue] = []
    t_s = 1.5 + rng.uniform(0.0, 0.5)
    order = (Move.FORWARD, Move.BACKWARD, Move.CLAP, Move.TURN)
    step = int(rng.integers(2)) * 2
    while t_s < length_s - 3.0:
        move = order[step % 4]
        duration_s = 0.0 if move is Move.CLAP else float(rng.uniform(1.6, 2.2))
        cues.append(Cue(name, move, 0, len(cues), 0.0, t_s, duration_s))
        t_s += duration_s + float(rng.uniform(0.9, 1.3))
        step += 1
    return cues


def planned(
    body: Anatomy,
    cues: list[Cue],
    length_s: float = PLAN_S,
    *,
    slot: Array | None = None,
    heading_rad: float = 0.0,
) -> ReferenceTrajectory:
    """The motion of one dancer on a grid of 30 Hz: joints, pelvis and yaw, at rest after the last cue."""
    reference = ReferenceTrajectory.empty(1, round(length_s * RATE_HZ)).for_dancer(0)
    at = np.zeros(2) if slot is None else slot
    planner = Planner(body, at, heading_rad, 0.5, math.pi / 2, RATE_HZ, reference)
    planner.extend(cues, 0.0)
    known = int(reference.planned_rows[0])
    for column in (reference.joints, reference.pelvis, reference.yaw):
        column[known:] = column[known - 1]
    return reference


class Cast:
    """Three dancers and a robot on a stage of their own.

    Args:
        rng: draws builds, dances and postures.
        group: number of dancers.
    """

    def __init__(self, rng: np.random.Generator, group: int = 3) -> None:
        self._rng = rng
        self._bodies = [scaled_anatomy(random_build(rng)) for _ in range(group)]
        dances = [dance(rng, "") for _ in self._bodies]
        self._plans = [planned(body, cues) for body, cues in zip(self._bodies, dances, strict=True)]
        self._claps_s = [[cue.t_s for cue in cues if cue.move is Move.CLAP] for cues in dances]
        place = layout(SessionConfig())
        self.mount: Mount = place.mounts[0]
        self.stature_m = np.array([body.build.stature_m for body in self._bodies])
        self._physics = Physics(
            self._bodies, place, (0.0, 0.0), np.zeros((group, 25)), np.zeros((group, 3)), PhysicsConfig(), BodyConfig(),
            RobotConfig(),
        )  # fmt: skip

    def scene(self) -> Scene:
        """Everybody somewhere, in some posture."""
        rng, group = self._rng, len(self._bodies)
        spots = _spots(rng, group + 1)
        yaw = np.array([_yaw(rng) for _ in range(group)])
        joints, roots, danced = np.zeros((group, 25)), np.zeros((group, 6)), np.ones(group, dtype=bool)
        for index, plan in enumerate(self._plans):
            tick = self._tick(index)
            joints[index] = plan.joints[tick] + SLACK_RAD * rng.standard_normal(25)
            if rng.random() < 0.25:
                side = slice(0, 3) if rng.random() < 0.5 else slice(3, 6)
                joints[index, _ARMS[side]] = rng.uniform(_ARM_LOW[side], _ARM_HIGH[side])
                danced[index] = False
            joints[index, _NECK] += 0.2 * rng.standard_normal()
            x, z = spots[index]
            roots[index, :3] = x, self.mount.position[1] - z, plan.pelvis[tick, 2]
            roots[index, 3] = math.pi / 2 + yaw[index]
            roots[index, 4:] = TILT_RAD * rng.standard_normal(2)
        robot = (float(spots[-1, 0]), float(self.mount.position[1] - spots[-1, 1]), float(rng.uniform(-3.1, 3.1)))
        self._physics.pose(joints, roots, robot)
        return Scene(self._physics.geoms, self._physics.joints_m, yaw, self.stature_m, danced)

    def _tick(self, dancer: int) -> int:
        """A tick of a dancer's plan; many more in claps than their time would give."""
        claps, rng = self._claps_s[dancer], self._rng
        if claps and rng.random() < CLAPPING:
            return round((float(rng.choice(claps)) + float(rng.uniform(-0.65, 0.55))) * RATE_HZ)
        return int(rng.integers(len(self._plans[dancer].yaw)))


def scenes(count: int, seed: int, name: str) -> Iterator[tuple[Mount, Scene]]:
    """Random scenes; a new cast every twenty of them.

    Args:
        count: how many.
        seed: of everything in them.
        name: of the random stream: what is trained on, tuned on and tested on must not share one.
    """
    rng = stream(seed, "training", name)
    cast = Cast(rng)
    for index in range(count):
        if index and index % 20 == 0:
            cast = Cast(rng)
        yield cast.mount, cast.scene()


def _yaw(rng: np.random.Generator) -> float:
    """Mostly the headings that count: facing, up to 110 degrees; a few more from all around."""
    luck = rng.random()
    widest = 35.0 if luck < 0.30 else 115.0 if luck < 0.65 else 180.0
    return math.radians(rng.uniform(-widest, widest))


def _spots(rng: np.random.Generator, count: int) -> Array:
    """(N, 2) x to the left and z away from the sensor [m]; the last one is the robot's, which may stand closer."""
    spots: list[Array] = []
    while len(spots) < count:
        z = rng.uniform(1.7, 4.3)
        spot = np.array([rng.uniform(-0.58, 0.58) * z, z])
        apart = APART_M if len(spots) < count - 1 else 0.40
        if all(np.hypot(*(spot - other)) > apart for other in spots):
            spots.append(spot)
    return np.array(spots)
