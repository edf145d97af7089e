"""Trials: whole dances in front of a depth sensor, with the truth of every frame.

No training uses them: random streams, builds, dances and places differ from those of the training scenes. Bodies move
exactly as planned, without physics, so that a minute of dance takes seconds to compute.
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
from ..core import NOT_TRACKED, Array, Geoms, IntArray, Move, Skeletons, Solids, dancer_name
from ..core.clock import stream
from ..humans.body.anatomy import Build
from ..humans.body.proportions import scaled_anatomy
from ..humans.motion.reference_trajectory import ReferenceTrajectory
from ..sensors.depth_sensing import DepthSensing
from ..simulation.physics import Physics
from .scenes import RATE_HZ, planned_motion, random_build, random_dance

WARM_FRAMES = 30
"""Frames at the start that are not evaluated."""

IDENTITY_FRAMES = 5
"""Frames at the start in which persons are not assigned to dancers yet."""

SIDE_M = (1.25, 1.5)
"""Smallest and largest side of a trial's square of dancers."""

LAYOUT_TURN_DEG = (24.0, 38.0)
"""Smallest and largest turn of that square [degrees]."""

EXTREME_STATURES_M = (1.52, 1.93)
"""Statures of extreme builds."""

EXTREME_MASSES_KG = (52.0, 98.0)
"""Masses of extreme builds."""


class PosedView:
    """A scene whose bodies are set to planned postures, as sensors see it.

    Args:
        physics: the bodies.
        plans: planned motion of each dancer at 30 Hz.
        robot: x, y [m] and heading [rad] of the robot.

    Attributes:
        time_s: time of the current tick.
    """

    def __init__(self, physics: Physics, plans: list[ReferenceTrajectory], robot: tuple[float, float, float]) -> None:
        self._physics = physics
        self._plans = plans
        self._robot = robot
        self.time_s = 0.0
        self.set_tick(0)

    def set_tick(self, tick: int) -> None:
        """Set all bodies to the postures of a tick of the plans."""
        joints = np.array([plan.joints[tick] for plan in self._plans])
        roots = np.zeros((len(self._plans), 6))
        roots[:, :3] = [plan.pelvis[tick] for plan in self._plans]
        roots[:, 3] = [plan.yaw[tick] for plan in self._plans]
        self._physics.pose(joints, roots, self._robot)
        self.time_s = tick / RATE_HZ

    @property
    def joints_m(self) -> Array:
        """(D, 25, 3) true joints in the world [m]."""
        return self._physics.joints_m

    @property
    def yaw_rad(self) -> Array:
        """(D,) true headings [rad]."""
        return self._physics.yaw_rad

    @property
    def geoms(self) -> Geoms:
        """All visible geoms."""
        return self._physics.geoms

    @property
    def solids(self) -> Solids:
        """Geoms that can occlude a joint."""
        return self._physics.solids


@dataclass(frozen=True, slots=True)
class Trial:
    """Description of one dance in front of a sensor.

    Attributes:
        seed: seed of builds, dances, places and noise.
        length_s: duration.
        facing_rad: heading of all dancers relative to facing the sensor.
        turns: whether dancers also turn, by 90 degrees there and back.
        aligned: whether dancers stand behind one another in rows, as in the paper's layout.
        edge: whether builds are extreme: each stature with each mass at the limits of the range.
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
    """What a sensor found in a trial of T frames and D dancers, and the truth.

    Attributes:
        trial: the trial.
        true: (T, D, 25, 3) true joints in the sensor's frame [m].
        found: (T, D, 25, 3) joints of the persons that were first assigned to the dancer, NaN if not tracked [m].
        state: (T, D, 25) tracking states of these joints.
        visible: (T, D, 25) whether the sensor could see the joint.
        person: (T, D) identity of the person at the dancer's place, -1 for none.
        extra_persons: (T,) number of persons who are at no dancer's place.
        cpu_s: (T,) CPU time for image, noise and skeletons.
    """

    trial: Trial
    true: Array
    found: Array
    state: NDArray[np.int8]
    visible: NDArray[np.bool_]
    person: IntArray
    extra_persons: IntArray
    cpu_s: Array

    @classmethod
    def empty(cls, trial: Trial, frames: int, dancers: int) -> TrialResult:
        """Return a result without persons, to be filled frame by frame."""
        shape = (frames, dancers, len(JOINTS))
        return cls(
            trial,
            true=np.zeros((*shape, 3)),
            found=np.full((*shape, 3), np.nan),
            state=np.zeros(shape, np.int8),
            visible=np.zeros(shape, bool),
            person=np.full((frames, dancers), -1),
            extra_persons=np.zeros(frames, dtype=np.int64),
            cpu_s=np.zeros(frames),
        )


def run_trial(trial: Trial) -> TrialResult:
    """Prepare a trial and record it."""
    view, place = prepare_trial(trial)
    return record_trial(view, place, trial, round(trial.length_s * RATE_HZ))


def prepare_trial(trial: Trial) -> tuple[PosedView, Layout]:
    """Return the scene of a trial, with bodies drawn and dances planned, and its layout."""
    rng = stream(trial.seed, "trial", "cast")
    place = _trial_layout(trial)
    heading = math.pi / 2 + trial.facing_rad
    plans = []
    bodies = []
    for index, slot in enumerate(place.dancers):
        build = random_build(rng)
        if trial.edge:
            build = Build(float(rng.choice(EXTREME_STATURES_M)), float(rng.choice(EXTREME_MASSES_KG)))
        body = scaled_anatomy(build)
        cues = random_dance(rng, dancer_name(index), trial.length_s)
        if not trial.turns:
            cues = [cue for cue in cues if cue.move is not Move.TURN]
        plans.append(planned_motion(body, cues, trial.length_s, slot=slot, heading_rad=heading))
        bodies.append(body)

    joints = np.array([plan.joints[0] for plan in plans])
    pelvis = np.array([plan.pelvis[0] for plan in plans])
    physics = Physics(bodies, place, (heading, heading), joints, pelvis, PhysicsConfig(), BodyConfig(), RobotConfig())
    return PosedView(physics, plans, (float(place.robot[0]), float(place.robot[1]), heading)), place


def _trial_layout(trial: Trial) -> Layout:
    """Return rows if the trial is aligned, otherwise the square of a session with a random side and turn."""
    rng = stream(trial.seed, "trial", "layout")
    side_m = float(rng.uniform(*SIDE_M))
    turn_rad = math.radians(float(rng.uniform(*LAYOUT_TURN_DEG)))
    scene = SceneConfig(side_m=side_m, turn_rad=turn_rad)
    return layout(SessionConfig(layout="rows" if trial.aligned else "square", scene=scene))


def record_trial(view: PosedView, place: Layout, trial: Trial, frames: int) -> TrialResult:
    """Record the north sensor's skeletons of a scene, with the truth.

    Args:
        view: the scene.
        place: the layout with the sensor's mount.
        trial: the trial, whose seed and image width are used.
        frames: number of frames.
    """
    config = replace(SensorConfig(), width_px=trial.width_px)
    mount = place.mounts[0]
    sensor = DepthSensing(mount, SessionConfig(sensors=config), stream(trial.seed, "trial", "sensor"))
    result = TrialResult.empty(trial, frames, len(view.joints_m))
    first_dancer: dict[int, int] = {}
    for frame in range(frames):
        view.set_tick(frame)
        # The time of this thread is not affected by other processes.
        started_s = time.thread_time()
        skeletons = sensor.sample(view)
        result.cpu_s[frame] = time.thread_time() - started_s
        assert skeletons is not None

        result.true[frame] = (view.joints_m - mount.position) @ mount.world_from_sensor
        result.visible[frame] = sensor.visibility
        result.extra_persons[frame] = int((sensor.dancers < 0).sum())
        _add_persons(result, frame, skeletons, sensor.dancers.tolist(), first_dancer)
    return result


def _add_persons(
    result: TrialResult, frame: int, skeletons: Skeletons, dancers: list[int], first_dancer: dict[int, int]
) -> None:
    """Write the persons of a frame.

    Args:
        result: the result; changed.
        frame: index of the frame.
        skeletons: persons with their joints.
        dancers: dancer at the place of each person, -1 for none.
        first_dancer: person to the dancer at whose place the person was first seen; extended. A person who is later
            at another dancer's place still counts for the first one, which makes it an error of that dancer's joints.
    """
    for row, (person, dancer) in enumerate(zip(skeletons.persons.tolist(), dancers, strict=True)):
        if dancer >= 0:
            result.person[frame, dancer] = person
            if frame >= IDENTITY_FRAMES:
                first_dancer.setdefault(person, dancer)
        owner = first_dancer.get(person, -1)
        if owner >= 0:
            known = skeletons.state[row] != NOT_TRACKED
            result.found[frame, owner, known] = skeletons.joints[row, known]
            result.state[frame, owner] = skeletons.state[row]
