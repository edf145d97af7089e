"""ROS 2 message definitions that MCAP files contain, as published by their packages but without comments.

To add a message type: write its definition into `_MESSAGES`, and those of its parts into `_PARTS`.
"""

from __future__ import annotations

SEPARATOR = "=" * 80
"""Line between the definitions of a message and its parts, as the MCAP format demands it."""

_PARTS = {
    "std_msgs/Header": "builtin_interfaces/Time stamp\nstring frame_id",
    "builtin_interfaces/Time": "int32 sec\nuint32 nanosec",
    "builtin_interfaces/Duration": "int32 sec\nuint32 nanosec",
    "geometry_msgs/Vector3": "float64 x\nfloat64 y\nfloat64 z",
    "geometry_msgs/Point": "float64 x\nfloat64 y\nfloat64 z",
    "geometry_msgs/Quaternion": "float64 x\nfloat64 y\nfloat64 z\nfloat64 w",
    "geometry_msgs/Pose": "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation",
    "geometry_msgs/Twist": "geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular",
    "geometry_msgs/PoseWithCovariance": "geometry_msgs/Pose pose\nfloat64[36] covariance",
    "geometry_msgs/TwistWithCovariance": "geometry_msgs/Twist twist\nfloat64[36] covariance",
    "geometry_msgs/Transform": "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation",
    "geometry_msgs/TransformStamped": "std_msgs/Header header\nstring child_frame_id\n"
    "geometry_msgs/Transform transform",
    "std_msgs/ColorRGBA": "float32 r\nfloat32 g\nfloat32 b\nfloat32 a",
    "visualization_msgs/Marker": "std_msgs/Header header\nstring ns\nint32 id\nint32 type\nint32 action\n"
    "geometry_msgs/Pose pose\ngeometry_msgs/Vector3 scale\nstd_msgs/ColorRGBA color\n"
    "builtin_interfaces/Duration lifetime\nbool frame_locked\ngeometry_msgs/Point[] points\n"
    "std_msgs/ColorRGBA[] colors\nstring text\nstring mesh_resource\nbool mesh_use_embedded_materials",
}
"""Type that others contain -> its definition."""

_MESSAGES = {
    "std_msgs/msg/String": "string data",
    "geometry_msgs/msg/TwistStamped": "std_msgs/Header header\ngeometry_msgs/Twist twist",
    "nav_msgs/msg/Odometry": "std_msgs/Header header\nstring child_frame_id\n"
    "geometry_msgs/PoseWithCovariance pose\ngeometry_msgs/TwistWithCovariance twist",
    "tf2_msgs/msg/TFMessage": "geometry_msgs/TransformStamped[] transforms",
    "visualization_msgs/msg/MarkerArray": "visualization_msgs/Marker[] markers",
}
"""Type of a message -> its definition."""


def _with_parts(definition: str) -> str:
    """A definition followed by those of all types that it contains, directly or not."""
    needed: list[str] = []
    pending = [definition]

    while pending:
        for line in pending.pop().splitlines():
            name = line.split()[0].partition("[")[0]
            if name in _PARTS and name not in needed:
                needed.append(name)
                pending.append(_PARTS[name])

    return "\n".join([definition, *(f"{SEPARATOR}\nMSG: {name}\n{_PARTS[name]}" for name in needed)])


SCHEMAS = {name: _with_parts(definition) for name, definition in _MESSAGES.items()}
"""Type of a message -> its definition with those of its parts."""
