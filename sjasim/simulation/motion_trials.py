"""Trials of the dancers' motion without sensing: whole dances, timed walks, pushes, and collisions with the robot."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from ..config import BodyConfig, DanceConfig, SessionConfig
from ..core import Array, Cue, Move, WheelCommand, dancer_name
from .motion_recording import MotionRecording
from .open_loop_world import OpenLoopWorld

FULL_RANGE = BodyConfig(stature_m=(1.50, 1.95), mass_kg=(50.0, 100.0))
"""The widest range of builds that the balance controller is made for."""

PUSH_S = 0.2
"""Duration of a push [s]."""

PUSH_PAUSE_S = 0.13
"""Time between the pushes of two dancers [s]."""

RECOVERY_S = 5.0
"""Time after the last push in which a dancer may fall [s]."""

FIRST_MOVE_S = 2.0
"""Time of the first dancer's first move in a walking trial [s]."""

COLLISION_S = 4.0
"""Duration of a collision trial [s]."""

COLLISION_DISTANCE_M = 0.9
"""Initial distance between robot and dancer in a collision trial [m]."""

FINAL_SPEED_S = 0.5
"""Time at the end of a collision trial over which the robot's speed is averaged [s]."""


def _trial_config(seed: int, iterations: int = 1) -> SessionConfig:
    """A dance without rehearsal and method, by people of any build."""
    return SessionConfig(
        seed=seed, iterations=iterations, method="none", body=FULL_RANGE, dance=DanceConfig(rehearsal=False)
    )


def dance_trial(seed: int, iterations: int = 4, **changes: object) -> MotionRecording:
    """Record a whole dance without a robot, by people of any build with the default human timing.

    Args:
        seed: the session's seed.
        iterations: length of the dance.
        changes: fields of `SessionConfig` to replace.
    """
    config = dataclasses.replace(_trial_config(seed, iterations), **changes)  # type: ignore[arg-type]
    return OpenLoopWorld(config, robot=False).run().recording()


def walking_trial(seed: int, duration_s: float, moves: int = 4, hold_s: float = 1.0) -> OpenLoopWorld:
    """A world in which people of any build are going to walk forward and backward in turn.

    Args:
        seed: the session's seed.
        duration_s: duration of each move.
        moves: number of moves of each dancer; with 0 everybody stands.
        hold_s: time between two moves.

    Returns:
        the world at time 0.
    """
    config = _trial_config(seed)
    directions = (Move.FORWARD, Move.BACKWARD) * moves
    cues = []
    for dancer in range(config.dancers):
        # The dancers start 0.1 s apart, so that they do not all step in phase.
        starts_s = FIRST_MOVE_S + 0.1 * dancer + (duration_s + hold_s) * np.arange(moves)
        cues.append(
            [
                Cue(dancer_name(dancer), direction, 1, 2 * index, 0.0, float(t_s), duration_s)
                for index, (direction, t_s) in enumerate(zip(directions, starts_s, strict=False))
            ]
        )
    return OpenLoopWorld(config, cues, robot=False)


def timed_moves_trial(seed: int, duration_s: float) -> MotionRecording:
    """Record four moves of a given duration [s] by each dancer."""
    return walking_trial(seed, duration_s).run(2.7 + 4 * (duration_s + 1.0)).recording()


def count_falls_after_push(seed: int, impulse_ns: float, *, walking: bool) -> int:
    """Push each of three dancers sideways once, in alternating directions.

    Args:
        seed: the session's seed.
        impulse_ns: impulse of each push [N s].
        walking: whether the dancers walk meanwhile; else they stand.

    Returns:
        the number of dancers who fall.
    """
    world = walking_trial(seed, 2.0, moves=4 if walking else 0).run(2.5)
    for dancer in range(3):
        left_rad = float(world.physics.yaw_rad[dancer]) + math.pi / 2
        direction = np.array([math.cos(left_rad), math.sin(left_rad), 0.0])
        world.physics.push(dancer, (-1) ** (seed + dancer) * impulse_ns / PUSH_S * direction)
        world.run(world.time_s + PUSH_S)
        world.physics.push(dancer, np.zeros(3))
        world.run(world.time_s + PUSH_PAUSE_S)
    return world.run(world.time_s + RECOVERY_S).recording().falls


@dataclasses.dataclass(frozen=True)
class CollisionResult:
    """Outcome of a robot that drives into a standing dancer.

    Attributes:
        peak_n: largest force between them.
        sway_m: largest displacement of the dancer's pelvis on the floor.
        speed_m_s: speed of the robot towards the dancer at the end, while its wheels are still driven.
        falls: number of dancers who fell.
    """

    peak_n: float
    sway_m: float
    speed_m_s: float
    falls: int


def collision_trial(seed: int, bearing_rad: float, speed_m_s: float = 0.5) -> CollisionResult:
    """Drive the robot into the first of three standing dancers, and go on driving.

    Args:
        seed: the session's seed, which determines the build.
        bearing_rad: direction of the robot as seen by the dancer: 0 is ahead, positive is to the left.
        speed_m_s: speed of the robot's wheels at the rim.
    """
    config = _trial_config(seed)
    world = OpenLoopWorld(config, [[], [], []])
    physics = world.physics
    root = physics.states().root[0]
    azimuth_rad = float(root[3]) + bearing_rad
    outward = np.array([math.cos(azimuth_rad), math.sin(azimuth_rad)])

    start_m = root[:2] + COLLISION_DISTANCE_M * outward
    _place_robot(world, (float(start_m[0]), float(start_m[1]), azimuth_rad + math.pi))
    wheel_rad_s = speed_m_s / config.robot.wheel_radius_m
    world.wheels = WheelCommand(wheel_rad_s, wheel_rad_s)

    tick_s = 1.0 / physics.ticks.rate_hz
    peak_n = 0.0
    sway_m = 0.0
    robot_m: list[Array] = []
    while world.time_s < COLLISION_S - 1e-9:
        world.run(world.time_s + tick_s)
        peak_n = max(peak_n, physics.contacts.contact_force_n())
        sway_m = max(sway_m, float(np.hypot(*(physics.states().root[0, :2] - root[:2]))))
        robot_m.append(np.array(physics.robot_pose()[:2]))

    final_ticks = round(FINAL_SPEED_S / tick_s)
    final_speed_m_s = float((robot_m[-1] - robot_m[-1 - final_ticks]) @ -outward / FINAL_SPEED_S)
    return CollisionResult(peak_n, sway_m, final_speed_m_s, world.recording().falls)


def _place_robot(world: OpenLoopWorld, pose: tuple[float, float, float]) -> None:
    """Move the robot to a position and heading [m, m, rad], and leave the dancers in their initial pose."""
    roots = np.concatenate([world.reference.pelvis[:, 0], np.zeros((3, 3))], axis=1)
    roots[:, 3] = world.physics.yaw_rad
    world.physics.pose(world.reference.joints[:, 0], roots, pose)
