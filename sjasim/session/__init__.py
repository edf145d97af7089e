"""One session: the loop around a world, and the protocol of a world."""

from .session import Session, run_session
from .world import World

__all__ = ["Session", "World", "run_session"]
