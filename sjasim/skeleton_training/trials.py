"""Trials that no training saw: whole dances before a depth sensor, with the truth beside every frame.

Bodies move as planned, without physics, so that minutes of them cost seconds. Streams, builds, dances and places are
other ones than those of the training's scenes.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..assets.names import JOINTS
from ..choreography.layout import Layout, layout
from ..config import BodyConfig, PhysicsConfig, RobotConfig, SceneConfig, SensorConfig, SessionConfig
from ..core import NOT_TRACKED, Array, Cue, Geoms, IntArray, Move, Solids, dancer_name
from ..core.clock import stream
from ..humans.body.anatomy import Build
from ..humans.body.proportions import scaled_anatomy
from ..humans.motion.reference_trajectory import ReferenceTrajectory
from ..sensors.depth_sensing import DepthSensing
from ..simulation.physics import Physics
from .scenes import RATE_HZ, dance, planned, random_build

WARM_FRAMES = 30
"""Frames at the start that are not judged."""


class PosedView:
    """A stage whose bodies are put where they are planned to be; what sensors see of it.

    Args:
        stage: the stage.
        plans: one per dancer, on a grid of 30 Hz.
        robot: place and heading of the robot.
    """

    def __init__(self, physics: Physics, plans: list[ReferenceTrajectory], robot: tuple[float, float, float]) -> None:
        self._physics = physics
        self._plans = plans
        self._robot = robot
        self.time_s = 0.0
        self.at(0)

    def at(self, tick: int) -> None:
        """Go to a tick of the plans."""
        joints = np.array([plan.joints[tick] for plan in self._plans])
        roots = np.zeros((len(self._plans), 6))
        roots[:, :3] = [plan.pelvis[tick] for plan in self._plans]
        roots[:, 3] = [plan.yaw[tick] for plan in self._plans]
        self._physics.pose(joints, roots, self._robot)
        self.time_s = tick / RATE_HZ

    @property
    def joints_m(self) -> Array:
        """(D, 25, 3) true joints [m]."""
        return self._physics.joints_m

    @property
    def yaw_rad(self) -> Array:
        """(D,) true headings [rad]."""
        return self._physics.yaw_rad

    @property
    def geoms(self) -> Geoms:
        """What there is to see."""
        return self._physics.geoms

    @property
    def solids(self) -> Solids:
        """What can hide something."""
        return self._physics.solids


@dataclass(frozen=True, slots=True)
class Trial:
    """One dance to be seen.

    Attributes:
        seed: of builds, dances, places and noise.
        length_s: how long it lasts.
        facing_rad: heading of everyone relative to facing the sensor.
        turns: whether dancers also turn, by 90 degrees there and back.
        aligned: whether rows stand behind one another, as in the paper's layout.
        edge: whether builds come from the edges of the range: tall and heavy, tall and light, short and so on.
        width_px: columns of the image.
    """

    seed: int
    length_s: float = 14.0
    facing_rad: float = 0.0
    turns: bool = False
    aligned: bool = False
    edge: bool = False
    width_px: int = 256


@dataclass(frozen=True, slots=True)
class TrialResult:
    """What a trial showed: T frames, D dancers.

    Attributes:
        trial: which.
        true: (T, D, 25, 3) joints in the sensor's frame [m].
        found: (T, D, 25, 3) those of the person that was first taken for the dancer, NaN if not tracked [m].
        state: (T, D, 25) how they are known.
        visible: (T, D, 25) which the sensor could see.
        name: (T, D) identity of the person at the dancer's place, -1 for nobody.
        strangers: (T,) persons at nobody's place.
        cpu_s: (T,) time for image, noise and skeletons.
    """

    trial: Trial
    true: Array
    found: Array
    state: NDArray[np.int8]
    visible: NDArray[np.bool_]
    name: IntArray
    strangers: IntArray
    cpu_s: Array


def place_everyone(trial: Trial) -> Layout:
    """Slots of a trial: the session's layout, its side and turn varied; or aligned rows."""
    rng = stream(trial.seed, "trial", "layout")
    scene = SceneConfig(side_m=float(rng.uniform(1.25, 1.5)), turn_rad=math.radians(float(rng.uniform(24.0, 38.0))))
    return layout(SessionConfig(layout="rows" if trial.aligned else "square", scene=scene))


def prepare_trial(trial: Trial) -> tuple[PosedView, Layout]:
    """Cast and plan a trial."""
    rng = stream(trial.seed, "trial", "cast")
    room = place_everyone(trial)
    heading = math.pi / 2 + trial.facing_rad
    plans, bodies = [], []
    for index, slot in enumerate(room.dancers):
        build = random_build(rng)
        if trial.edge:
            build = Build(float(rng.choice([1.52, 1.93])), float(rng.choice([52.0, 98.0])))
        body = scaled_anatomy(build)
        cues = dance(rng, dancer_name(index), trial.length_s)
        plans.append(planned(body, _kept(cues, trial), trial.length_s, slot=slot, heading_rad=heading))
        bodies.append(body)
    joints, pelvis = np.array([plan.joints[0] for plan in plans]), np.array([plan.pelvis[0] for plan in plans])
    physics = Physics(bodies, room, (heading, heading), joints, pelvis, PhysicsConfig(), BodyConfig(), RobotConfig())
    return PosedView(physics, plans, (float(room.robot[0]), float(room.robot[1]), heading)), room


def _kept(cues: list[Cue], trial: Trial) -> list[Cue]:
    """Without turns, unless the trial has them."""
    return [cue for cue in cues if trial.turns or cue.move is not Move.TURN]


def record_trial(view: PosedView, room: Layout, trial: Trial, ticks: int) -> TrialResult:
    """Let the north sensor see a view tick by tick."""
    config = replace(SensorConfig(), width_px=trial.width_px)
    mount = room.mounts[0]
    sensing = DepthSensing(mount, SessionConfig(sensors=config), stream(trial.seed, "trial", "sensor"))
    dancers = len(view.joints_m)
    shape = (ticks, dancers, len(JOINTS))
    true, found = np.zeros((*shape, 3)), np.full((*shape, 3), np.nan)
    state, visible = np.zeros(shape, np.int8), np.zeros(shape, bool)
    name, strangers = np.full((ticks, dancers), -1), np.zeros(ticks, dtype=np.int64)
    cpu = np.zeros(ticks)
    first: dict[int, int] = {}
    for tick in range(ticks):
        view.at(tick)
        began = time.thread_time()
        skeletons = sensing.sample(view)
        cpu[tick] = time.thread_time() - began
        assert skeletons is not None
        true[tick] = (view.joints_m - mount.position) @ mount.world_from_sensor
        visible[tick] = sensing.visibility
        strangers[tick] = int((sensing.dancers < 0).sum())
        for row, (person, dancer) in enumerate(zip(skeletons.persons.tolist(), sensing.dancers.tolist(), strict=True)):
            if dancer >= 0:
                name[tick, dancer] = person
                if tick >= 5:
                    first.setdefault(person, dancer)
            owner = first.get(person, -1)
            if owner >= 0:
                known = skeletons.state[row] != NOT_TRACKED
                found[tick, owner, known] = skeletons.joints[row, known]
                state[tick, owner] = skeletons.state[row]
    return TrialResult(trial, true, found, state, visible, name, strangers, cpu)


def run_trial(trial: Trial) -> TrialResult:
    """Perform a trial and see it."""
    view, room = prepare_trial(trial)
    return record_trial(view, room, trial, round(trial.length_s * RATE_HZ))
