"""Groups of joints, as indices into `assets.names.JOINTS`."""

from __future__ import annotations

import numpy as np

from ...assets.names import JOINT_INDEX, JOINTS


def _pair(name: str) -> list[int]:
    return [JOINT_INDEX[f"{name}Left"], JOINT_INDEX[f"{name}Right"]]


SPINE_BASE = JOINT_INDEX["SpineBase"]
"""Index of the joint SpineBase, between the hips."""

SPINE_MID = JOINT_INDEX["SpineMid"]
"""Index of the joint SpineMid."""

HEAD = JOINT_INDEX["Head"]
"""Index of the joint Head."""

TRUNK = np.array(
    [JOINT_INDEX[name] for name in ("SpineBase", "SpineMid", "SpineShoulder", "Neck", "ShoulderLeft", "ShoulderRight",
                                    "HipLeft", "HipRight")]
)  # fmt: skip
"""(8,) joints that tell where a person stands."""

HAND_JOINTS = np.array([_pair(name) for name in ("Wrist", "Hand", "HandTip", "Thumb")])
"""(4, 2) wrists, hands, hand tips and thumbs, each left and right."""

PALMS = HAND_JOINTS[1]
"""(2,) the joints HandLeft and HandRight."""

ELBOWS = np.array(_pair("Elbow"))
"""(2,) elbows, left and right."""

TRUNK_PAIRS = np.array([_pair("Shoulder"), _pair("Hip")])
"""(2, 2) shoulders and hips, left and right: the lines between them give the heading."""

IS_ARM = np.array([name.startswith(("Elbow", "Wrist", "Hand", "Thumb")) for name in JOINTS])
"""(25,) whether a joint belongs to an arm."""

IS_LIMB = IS_ARM | np.array([name.startswith(("Knee", "Ankle", "Foot")) for name in JOINTS])
"""(25,) whether a joint belongs to an arm or a leg; limbs are thin, so their surface is near the joint."""

LIMBS = np.flatnonzero(IS_LIMB)
"""(16,) joints of arms and legs."""
