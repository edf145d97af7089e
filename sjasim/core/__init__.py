"""Plain data that crosses doors between rooms: frozen values, SI units, one clock named per field.

World z is up, quaternions are wxyz. A time field's name says its clock: ``t_s`` is session time (true
simulation time for what the world logs, the server's estimate of it for an `Event`), ``t_device_s`` is an
uncorrected device clock, ``t_arrival_s`` is session time at the receiver.
"""

from .bodies import Cue, DancerStates, Geoms, SceneView, Servos, Solids
from .messages import (
    ClientOrder,
    ClientStatus,
    DeviceEvent,
    Event,
    MoveDuration,
    PersonStatus,
    RecordedJoints,
    SkeletonFrame,
    Skeletons,
    SyncReply,
    SyncRequest,
)
from .robot import MoveCommand, RobotState, WheelCommand, WheelReading
from .vocabulary import (
    INFERRED,
    NOT_TRACKED,
    ROBOT,
    SYNCHRONY_KINDS,
    TRACKED,
    Array,
    BoolArray,
    IntArray,
    Kind,
    Move,
    TrackingState,
    dancer_name,
)

__all__ = [
    "INFERRED",
    "NOT_TRACKED",
    "ROBOT",
    "SYNCHRONY_KINDS",
    "TRACKED",
    "Array",
    "BoolArray",
    "ClientOrder",
    "ClientStatus",
    "Cue",
    "DancerStates",
    "DeviceEvent",
    "Event",
    "Geoms",
    "IntArray",
    "Kind",
    "Move",
    "MoveCommand",
    "MoveDuration",
    "PersonStatus",
    "RecordedJoints",
    "RobotState",
    "SceneView",
    "Servos",
    "SkeletonFrame",
    "Skeletons",
    "Solids",
    "SyncReply",
    "SyncRequest",
    "TrackingState",
    "WheelCommand",
    "WheelReading",
    "dancer_name",
]
