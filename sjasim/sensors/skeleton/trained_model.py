"""The trained skeleton model: two forests, thresholds, a posture regression and postures, kept as one typed npz.

Source: girshick2011, section 3 (leaves of a depth-difference forest vote for joint positions).
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, fields
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...assets.names import JOINTS
from ...core import Array
from ...core.errors import SjasimError
from .forest import pack_nodes

FORMAT_VERSION = 2
"""Of the file's meaning; a file of another version is refused."""
OFFSET_UNIT_M = 0.001
SPREAD_UNIT_M = 0.004
"""Unit of spreads."""


@dataclass(frozen=True, slots=True)
class SkeletonModel:
    """Arrays of the file, as they are stored.

    Lengths are those of a person of 1.75 m. A node's children are rows of the same forest; a negative left child
    -1 - k says that the node is leaf k.

    Attributes:
        probes: (F, 4) two offsets to the left and up in the image plane, in metres at the pixel's depth; the second
            may be 0.
        feature: (N,) what a node of the joints' forest asks for.
        threshold: (N,) answers up to this go left.
        left: (N,) left child; the right one is ``right``.
        right: (N,) right child.
        roots: (T,) first nodes of the trees.
        joint: (L, K) joints that a leaf votes for.
        offset: (L, K, 3) from the pixel's point forward, up and to the left in the person's frame [mm].
        view: (L, K, 2) what the offset has besides, whatever the yaw: to the sensor's left and away from it [mm].
        spread: (L, K) standard deviation of the offset, smallest first [4 mm].
        yaw_feature: (M,) the same for the forest of yaws.
        yaw_threshold: (M,) the same.
        yaw_left: (M,) the same.
        yaw_right: (M,) the same.
        yaw_roots: (S,) the same.
        yaw_vote: (V, 2) mean cosine and sine in a leaf [1/127].
        support: (25,) weight of votes from which a joint is tracked.
        posture: (R, 75) regression of all joints from those tracked, see `posture`.
        memory: (N, 75) postures, each less the mean one [m].
        mean: (25, 3) mean posture: forward, up from the floor, left of SpineBase [m].
        info: JSON: version, seed, config, and the hash of all other arrays.
    """

    probes: NDArray[np.float16]
    feature: NDArray[np.uint8]
    threshold: NDArray[np.float16]
    left: NDArray[np.int16]
    right: NDArray[np.int16]
    roots: NDArray[np.int16]
    joint: NDArray[np.int8]
    offset: NDArray[np.int16]
    view: NDArray[np.int16]
    spread: NDArray[np.uint8]
    yaw_feature: NDArray[np.uint8]
    yaw_threshold: NDArray[np.float16]
    yaw_left: NDArray[np.int16]
    yaw_right: NDArray[np.int16]
    yaw_roots: NDArray[np.int16]
    yaw_vote: NDArray[np.int8]
    support: NDArray[np.float32]
    posture: NDArray[np.float16]
    memory: NDArray[np.float16]
    mean: NDArray[np.float16]
    info: str

    @property
    def about(self) -> dict[str, Any]:
        """What ``info`` says."""
        return dict(json.loads(self.info))

    def digest(self) -> str:
        """SHA-256 of all arrays, in order of their names."""
        total = hashlib.sha256()
        for name in _DTYPES:
            array = np.ascontiguousarray(getattr(self, name))
            total.update(f"{name} {array.dtype.str} {array.shape}".encode())
            total.update(array.tobytes())
        return total.hexdigest()

    def save(self, path: Path) -> None:
        """Write the file; its hash is put into ``info``."""
        arrays = {name: getattr(self, name) for name in _DTYPES}
        info = json.dumps({**self.about, "version": FORMAT_VERSION, "sha256": self.digest()}, sort_keys=True)
        np.savez_compressed(path, info=np.array(info), **arrays)


_DTYPES: dict[str, type] = {
    "probes": np.float16, "feature": np.uint8, "threshold": np.float16, "left": np.int16, "right": np.int16,
    "roots": np.int16, "joint": np.int8, "offset": np.int16, "view": np.int16, "spread": np.uint8,
    "yaw_feature": np.uint8, "yaw_threshold": np.float16, "yaw_left": np.int16, "yaw_right": np.int16,
    "yaw_roots": np.int16, "yaw_vote": np.int8, "support": np.float32, "posture": np.float16,
    "memory": np.float16, "mean": np.float16,
}  # fmt: skip
assert [field.name for field in fields(SkeletonModel)] == [*_DTYPES, "info"]


def load_model(path: Path) -> SkeletonModel:
    """Read a model.

    Raises:
        SjasimError: the file is missing, cut off, of another version, or not what it was when it was written.
    """
    try:
        with np.load(path, allow_pickle=False) as file:
            arrays = {name: file[name] for name in _DTYPES}
            info = str(file["info"])
        about = json.loads(info)
    except (OSError, ValueError, KeyError, EOFError) as error:
        raise SjasimError(f"skeleton model {path}: cannot be read ({error})") from error
    except Exception as error:  # zipfile and zlib raise their own kinds on a file that is cut off
        raise SjasimError(f"skeleton model {path}: broken ({error})") from error
    if about.get("version") != FORMAT_VERSION:
        raise SjasimError(f"skeleton model {path}: version {about.get('version')!r}, not {FORMAT_VERSION}")
    model = SkeletonModel(**_typed(path, arrays), info=info)
    if model.digest() != about.get("sha256"):
        raise SjasimError(f"skeleton model {path}: its arrays are not those it was written with")
    return model


def _typed(path: Path, arrays: Mapping[str, NDArray[Any]]) -> dict[str, Any]:
    for name, dtype in _DTYPES.items():
        if arrays[name].dtype != dtype:
            raise SjasimError(f"skeleton model {path}: {name} is {arrays[name].dtype}, not {np.dtype(dtype)}")
    if arrays["support"].shape != (len(JOINTS),) or arrays["mean"].shape != (len(JOINTS), 3):
        raise SjasimError(f"skeleton model {path}: not for {len(JOINTS)} joints")
    return dict(arrays)


@cache
def default_model() -> SkeletonModel:
    """The model that comes with the package."""
    return load_model(Path(str(resources.files("sjasim.assets") / "skeleton.npz")))


@dataclass(frozen=True, slots=True)
class RuntimeModel:
    """A model in the types that the kernels take.

    Attributes:
        nodes: (N, 8) of the forest that votes for joints, see `forest.descend`.
        roots: (T,) its first nodes.
        votes: (L, K, 7) of its leaves, the surest first: offset forward, up and to the left, and to the sensor's left
            and away from it [mm], spread [4 mm], joint.
        yaw_nodes: (M, 8) of the forest that votes for the yaw.
        yaw_roots: (S,) its first nodes.
        yaw_vote: (V, 2) cosine and sine.
        support: (25,) threshold of a tracked joint.
        posture: (R, 75) regression.
        memory: (N, 75) postures, each less the mean one [m].
        mean: (25, 3) mean posture [m].
    """

    nodes: NDArray[np.int16]
    roots: NDArray[np.int32]
    votes: NDArray[np.int16]
    yaw_nodes: NDArray[np.int16]
    yaw_roots: NDArray[np.int32]
    yaw_vote: NDArray[np.float32]
    support: Array
    posture: Array
    memory: Array
    mean: Array


def runtime_model(model: SkeletonModel) -> RuntimeModel:
    """Prepare a model for use."""
    m = model
    nodes, roots = pack_nodes(m.probes, m.feature, m.threshold, m.left, m.right, m.roots)
    yaw_nodes, yaw_roots = pack_nodes(m.probes, m.yaw_feature, m.yaw_threshold, m.yaw_left, m.yaw_right, m.yaw_roots)
    votes = np.concatenate([m.offset, m.view, m.spread[..., None], m.joint[..., None]], axis=2, dtype=np.int16)
    return RuntimeModel(
        nodes, roots, votes, yaw_nodes, yaw_roots, m.yaw_vote.astype(np.float32) / np.float32(127),
        m.support.astype(float), m.posture.astype(float), m.memory.astype(float), m.mean.astype(float),
    )  # fmt: skip
