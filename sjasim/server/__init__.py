"""The server: messages of the sensor clients in, events out; a method's actions in, robot commands out."""

from .dispatcher import Dispatcher
from .fusion import Server

__all__ = ["Dispatcher", "Server"]
