"""The trained skeleton model: two forests, thresholds, a posture regression and remembered postures, in one npz file.

Source: girshick2011, section 3 (the leaves of a forest of depth differences vote for joint positions).
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
"""Version of the file format; a file of another version is refused."""

MODEL_STATURE_M = 1.75
"""Stature of the model's person, to which all scales refer."""

OFFSET_UNIT_M = 0.001
"""Unit of stored offsets."""

SPREAD_UNIT_M = 0.004
"""Unit of stored spreads."""


@dataclass(frozen=True, slots=True)
class SkeletonModel:
    """Arrays of the file, as they are stored.

    Lengths are those of a person of 1.75 m. A node's children are rows of the same forest; a negative left child
    -1 - k means that the node is leaf k.

    Attributes:
        probes: (F, 4) pairs of offsets, each to the left and up in the image plane, in metres at the pixel's depth;
            the second offset may be 0.
        feature: (N,) feature that a node of the joints' forest tests.
        threshold: (N,) values up to this go left.
        left: (N,) left child.
        right: (N,) right child.
        roots: (T,) roots of the trees.
        joint: (L, K) joints that a leaf votes for.
        offset: (L, K, 3) from the pixel's point forward, up and to the left in the person's frame [mm].
        view: (L, K, 2) part of the offset that does not rotate with the yaw: to the sensor's left and away from it
            [mm].
        spread: (L, K) standard deviation of the offset, smallest first [4 mm].
        yaw_feature: (M,) as above, for the forest that votes for the yaw.
        yaw_threshold: (M,) the same.
        yaw_left: (M,) the same.
        yaw_right: (M,) the same.
        yaw_roots: (S,) the same.
        yaw_vote: (V, 2) mean cosine and sine of a leaf [1/127].
        support: (25,) weight of votes from which on a joint is tracked.
        posture: (R, 75) weights of the posture regression, see `posture_prior`.
        memory: (N, 75) remembered postures, each less the mean one [m].
        mean: (25, 3) mean posture: forward, up from the floor, left of SpineBase [m].
        info: JSON with version, seed, training configuration and the hash of all other arrays.
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
        """The decoded ``info``."""
        return dict(json.loads(self.info))

    def digest(self) -> str:
        """Return the SHA-256 of all arrays, in order of their names."""
        total = hashlib.sha256()
        for name in _DTYPES:
            array = np.ascontiguousarray(getattr(self, name))
            total.update(f"{name} {array.dtype.str} {array.shape}".encode())
            total.update(array.tobytes())
        return total.hexdigest()

    def save(self, path: Path) -> None:
        """Write the file, with version and hash in its ``info``."""
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
        SjasimError: the file is missing, truncated, of another version, or its arrays do not match its hash.
    """
    try:
        with np.load(path, allow_pickle=False) as file:
            arrays = {name: file[name] for name in _DTYPES}
            info = str(file["info"])
        about = json.loads(info)
    except (OSError, ValueError, KeyError, EOFError) as error:
        raise SjasimError(f"skeleton model {path}: cannot be read ({error})") from error
    except Exception as error:  # zipfile and zlib raise exceptions of their own for a truncated file
        raise SjasimError(f"skeleton model {path}: broken ({error})") from error

    if about.get("version") != FORMAT_VERSION:
        raise SjasimError(f"skeleton model {path}: version {about.get('version')!r}, expected {FORMAT_VERSION}")
    model = SkeletonModel(**_check_arrays(path, arrays), info=info)
    if model.digest() != about.get("sha256"):
        raise SjasimError(f"skeleton model {path}: the arrays do not match the hash that was stored with them")
    return model


def _check_arrays(path: Path, arrays: Mapping[str, NDArray[Any]]) -> dict[str, Any]:
    """Return the arrays if their types and their number of joints are right, else raise `SjasimError`."""
    for name, dtype in _DTYPES.items():
        if arrays[name].dtype != dtype:
            raise SjasimError(
                f"skeleton model {path}: {name} has type {arrays[name].dtype}, expected {np.dtype(dtype)}"
            )
    if arrays["support"].shape != (len(JOINTS),) or arrays["mean"].shape != (len(JOINTS), 3):
        raise SjasimError(f"skeleton model {path}: expected arrays for {len(JOINTS)} joints")
    return dict(arrays)


@cache
def default_model() -> SkeletonModel:
    """Return the model that comes with the package."""
    return load_model(Path(str(resources.files("sjasim.assets") / "skeleton.npz")))


@dataclass(frozen=True, slots=True)
class RuntimeModel:
    """A model in the types that the compiled functions take.

    Attributes:
        nodes: (N, 8) nodes of the joints' forest, see `forest.find_leaves`.
        roots: (T,) roots of its trees.
        votes: (L, K, 7) votes of its leaves, smallest spread first: offset forward, up and to the left, offset to the
            sensor's left and away from it [mm], spread [4 mm], joint.
        yaw_nodes: (M, 8) nodes of the yaw's forest.
        yaw_roots: (S,) roots of its trees.
        yaw_vote: (V, 2) mean cosine and sine of a leaf.
        support: (25,) weight of votes from which on a joint is tracked.
        posture: (R, 75) weights of the posture regression.
        memory: (N, 75) remembered postures, each less the mean one [m].
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
    """Return a stored model in the types that the compiled functions take."""
    m = model
    nodes, roots = pack_nodes(m.probes, m.feature, m.threshold, m.left, m.right, m.roots)
    yaw_nodes, yaw_roots = pack_nodes(
        m.probes, m.yaw_feature, m.yaw_threshold, m.yaw_left, m.yaw_right, m.yaw_roots
    )  # fmt: skip
    votes = np.concatenate([m.offset, m.view, m.spread[..., None], m.joint[..., None]], axis=2, dtype=np.int16)
    return RuntimeModel(
        nodes=nodes,
        roots=roots,
        votes=votes,
        yaw_nodes=yaw_nodes,
        yaw_roots=yaw_roots,
        yaw_vote=m.yaw_vote.astype(np.float32) / np.float32(127),
        support=m.support.astype(float),
        posture=m.posture.astype(float),
        memory=m.memory.astype(float),
        mean=m.mean.astype(float),
    )
