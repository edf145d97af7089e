"""A standing person in the model's mean posture, for the tests of tracking."""

from __future__ import annotations

import numpy as np

from sjasim.sensors.skeleton import posture_prior
from sjasim.sensors.skeleton.person_tracking import Person
from sjasim.sensors.skeleton.trained_model import default_model, runtime_model

MODEL = runtime_model(default_model())
DT_S = 1 / 30
ALL = np.ones(25, dtype=bool)


def standing(x: float, z: float, yaw_rad: float = 0.0) -> np.ndarray:
    """Return the joints (25, 3) of the mean posture at a position and yaw [m]."""
    return posture_prior.sensor_from_body(MODEL.mean, yaw_rad) + np.array([x, 0.0, z])


def track(person: Person, joints: np.ndarray, seen: np.ndarray = ALL) -> None:
    """Let a person be tracked for one frame."""
    person.predict(DT_S)
    person.update(joints, seen, MODEL, DT_S)


def tracked_person(x: float = 0.0, z: float = 3.0, yaw_rad: float = 0.0, frames: int = 5) -> Person:
    """Return a person who stood still for some frames."""
    person = Person(0, np.array([x, z]), yaw_rad=yaw_rad, scale=1.0)
    for _ in range(frames):
        track(person, standing(x, z, yaw_rad))
    return person
