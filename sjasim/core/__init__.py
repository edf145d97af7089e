"""Data types that the parts of the system exchange: frozen dataclasses and named tuples in SI units.

The z axis of the world points up, and quaternions are in the order w, x, y, z. The name of a time field gives its
clock. ``t_s`` is session time: the true simulation time in ground truth, and the server's estimate of it in an `Event`.
``t_device_s`` is the reading of an uncorrected device clock. ``t_arrival_s`` is the session time at which a message
reaches its receiver.
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
