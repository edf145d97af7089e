"""Values that the parts of the system exchange: frozen dataclasses and named tuples in SI units.

World z points up; quaternions are wxyz. The name of a time field names its clock: ``t_s`` is session time (the true
simulation time in what the world logs, the server's estimate of it in an `Event`), ``t_device_s`` is an uncorrected
device clock, ``t_arrival_s`` is session time at the receiver.
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
from .robot_messages import MoveCommand, RobotState, WheelCommand, WheelReading
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
