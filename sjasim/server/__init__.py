"""The server: clients' messages in, events out; the method's answers in, robot commands out."""

from .dispatcher import Dispatcher
from .fusion import Server

__all__ = ["Dispatcher", "Server"]
