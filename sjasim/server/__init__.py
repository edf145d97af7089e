"""The server: clients' messages in, events out; the method's answers in, robot commands out."""

from .dispatch import Dispatcher
from .server import Server

__all__ = ["Dispatcher", "Server"]
