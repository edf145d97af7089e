"""Names of joints, hinges and sensors, and contact bits of the physics model."""

from __future__ import annotations

JOINTS = (
    "SpineBase", "SpineMid", "Neck", "Head",
    "ShoulderLeft", "ElbowLeft", "WristLeft", "HandLeft",
    "ShoulderRight", "ElbowRight", "WristRight", "HandRight",
    "HipLeft", "KneeLeft", "AnkleLeft", "FootLeft",
    "HipRight", "KneeRight", "AnkleRight", "FootRight",
    "SpineShoulder", "HandTipLeft", "ThumbLeft", "HandTipRight", "ThumbRight",
)  # fmt: skip
"""The 25 joints of a Kinect v2 skeleton, in the order of its JointType enumeration (0 to 24)."""

JOINT_INDEX = {name: index for index, name in enumerate(JOINTS)}
"""Joint name -> row in every (25, 3) array."""

LEG_JOINTS = ("hip_z", "hip_x", "hip_y", "knee", "ankle_y", "ankle_x")
"""Hinges of one leg, from the pelvis down; suffixed ``_L`` or ``_R`` in the model."""

ARM_JOINTS = ("shoulder_y", "shoulder_x", "shoulder_z", "elbow")
"""Hinges of one arm, from the trunk down."""

TRUNK_JOINTS = ("abdomen_z", "abdomen_y", "abdomen_x", "neck_y", "neck_z")
"""Hinges between pelvis, chest and head."""

ACTUATED = (
    *TRUNK_JOINTS,
    *(f"{joint}_{side}" for side in "LR" for joint in LEG_JOINTS),
    *(f"{joint}_{side}" for side in "LR" for joint in ARM_JOINTS),
)
"""The 25 actuated hinges of a dancer, in the order of every (J,) array of joint targets."""

ACTUATED_INDEX = {name: index for index, name in enumerate(ACTUATED)}
"""Hinge name -> column in every (J,) array."""

ROOT_JOINTS = ("root_x", "root_y", "root_z", "root_yaw", "root_pitch", "root_roll")
"""Three slide joints and three hinges by which a dancer's pelvis moves freely."""

TETHERED = ("root_x", "root_y", "root_yaw", "root_pitch", "root_roll")
"""Root joints on which the balance support acts; the vertical one is free."""

ROBOT_PREFIX = "robot/"
"""Prefix of all names in the robot's part of the model."""

CARDINALS = ("north", "west", "south", "east")
"""Names of the sensors, in the order in which the dancers turn to them: counter-clockwise."""


def dancer_prefix(index: int) -> str:
    """Prefix of all names in the part of the model that belongs to the dancer with this index, counted from 0."""
    return f"dancer_{index + 1}/"


FLOOR_BIT = 1
"""Contact bit of the floor; geoms whose conaffinity contains it collide with the floor."""

ROBOT_BIT = 2
"""Contact bit of the robot's geoms."""


HAND_BIT = 1 << 10
"""Contact bit of the hands, by which the two hands of one dancer collide with each other."""


def dancer_bit(index: int) -> int:
    """Contact bit of a dancer's geoms. Dancers collide with one another and with the robot, not with themselves."""
    return 4 << index
