"""Compiles the functions that a session needs, ahead of the first session: ``python -m sjasim.simulation.precompile``.

Numba compiles a function when it is first called and keeps the machine code in its cache. The two parts call disjoint
sets of functions, but for a few small ones, so that two processes can compile them at the same time.
"""

from __future__ import annotations

import gc
import sys
from collections.abc import Callable

from ..choreography.layout import layout
from ..choreography.timetable import timetable
from ..config import DanceConfig, SessionConfig
from ..session.session import run_session
from .physics_world import PhysicsWorld

FRAMES = 12
"""Depth frames after which all stages of the skeleton estimator have run."""

TICKS_PER_FRAME = 5


def compile_session() -> None:
    """Compile the functions of every session: dancers, robot, event detectors and joint sensing."""
    run_session(SessionConfig(sensing="joints", iterations=1, dance=DanceConfig(rehearsal=False)))


def compile_skeletons() -> None:
    """Compile the additional functions of depth sensing: depth images, and skeletons from them."""
    config = SessionConfig(sensing="depth", iterations=1)
    world = PhysicsWorld(config, timetable(config), layout(config), robot=True)
    source = world.sensing[world.active]
    for frame in range(FRAMES):
        world.physics.step_to(frame * TICKS_PER_FRAME)
        source.sample(world.physics)


PARTS: dict[str, Callable[[], None]] = {"session": compile_session, "skeletons": compile_skeletons}


def main(names: list[str]) -> None:
    """Compile the named parts, or all of them if none is named."""
    # Garbage collection takes a tenth of the compile time, and is unnecessary in a process that ends soon.
    gc.disable()
    for name in names or list(PARTS):
        PARTS[name]()


if __name__ == "__main__":
    main(sys.argv[1:])
