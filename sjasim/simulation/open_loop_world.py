"""A physics world without sensing, in which the dancers' motion is tested."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..choreography.layout import layout
from ..choreography.timetable import timetable
from ..config import SessionConfig
from ..core import Array, Cue, WheelCommand
from .motion_recording import MotionRecording
from .physics_world import PhysicsWorld


class _MotionSample(NamedTuple):
    """Motion at one control step; see `MotionRecording`."""

    t_s: Array
    roots: Array
    hands_m: Array
    feet_m: Array
    tether: Array
    loads_n: Array
    planned_m: Array
    landing_s: Array


class OpenLoopWorld(PhysicsWorld):
    """Physics of a session without sensing. The dancers' motion is recorded at every control step.

    Args:
        config: the session; its sensors capture nothing.
        cues: cues of each dancer; None lets the human timing model decide, as in a session.
        robot: whether there is a robot.

    Attributes:
        wheels: constant wheel speeds of the robot; None leaves them to its controller.
    """

    def __init__(
        self, config: SessionConfig, cues: Sequence[Sequence[Cue]] | None = None, *, robot: bool = True
    ) -> None:
        self._samples: list[_MotionSample] = []
        self.wheels: WheelCommand | None = None
        super().__init__(config, timetable(config), layout(config), robot=robot, given_cues=cues)

    def run(self, until_s: float | None = None) -> OpenLoopWorld:
        """Advance to a session time [s], or to the end of the dance; returns the world itself."""
        until_s = self.end_s if until_s is None else until_s
        while self.time_s < until_s - 1e-9:
            self.advance(until_s)
        return self

    def update_sensors(self, now: float) -> None:
        """Measure the load on the feet; no sensor captures anything."""
        self.physics.measure_load()

    def update_robot(self, now: float) -> None:
        """Drive the robot with the constant wheel speeds, if they are set."""
        if self.wheels is None:
            super().update_robot(now)
        else:
            self.physics.drive(self.wheels)

    def update_dancers(self, now: float) -> None:
        """Run a control step and record the motion."""
        super().update_dancers(now)
        states = self.physics.states()

        # A dancer whose plan has ended stays in the last planned row.
        row = np.minimum(round(now * self._config.physics.control_hz), self.reference.planned_rows - 1)
        dancers = range(len(self._fallen))
        self._samples.append(
            _MotionSample(
                t_s=np.array(now),
                roots=states.root,
                hands_m=np.sqrt(((states.hands[:, 0] - states.hands[:, 1]) ** 2).sum(axis=1)),
                feet_m=states.ankles[:, :, :2],
                tether=states.tether,
                loads_n=states.load,
                planned_m=self.reference.pelvis[dancers, row],
                landing_s=self.reference.landing[dancers, row],
            )
        )

    def recording(self) -> MotionRecording:
        """The motion so far; the world must have been advanced."""
        columns = _MotionSample(*(np.array(column) for column in zip(*self._samples, strict=True)))
        return MotionRecording(
            **columns._asdict(),
            weight_n=self.physics.servos.weight,
            cues=tuple(self.cues),
            falls=sum(self._fallen),
        )
