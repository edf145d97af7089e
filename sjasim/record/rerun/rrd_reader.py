"""Reads joints and skeletons from the rerun recording of a session; the tables do not contain them."""

from __future__ import annotations

import dataclasses
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import rerun as rr

from ...assets.names import JOINTS
from ...config.toml_file import from_plain
from ...core import INFERRED, TRACKED, Array, IntArray, dancer_name
from ...core.errors import RecordError
from ...core.session_log import SessionLog
from ..session_folder import read
from .entity_stream import TIMELINE

RECORDING = "session.rrd"
"""Name of the recording in a session's folder."""


class _FramePoints(NamedTuple):
    """Points of one entity in one frame.

    Attributes:
        frame: number of the sensors' frame.
        positions_m: (K, 3) positions.
        joints: (K,) indices of the joints, or None if the entity holds all joints in order.
    """

    frame: int
    positions_m: Array
    joints: IntArray | None


def read_with_joints(folder: Path) -> SessionLog:
    """Read a session's log from its folder, with the joints and skeletons that its recording holds.

    Args:
        folder: a session's folder.

    Returns:
        The log. Joints and skeletons are None if the folder has no recording, or the recording has no joints.

    Raises:
        RecordError: the folder or its recording is damaged or of another version.
    """
    log = read(folder)
    path = folder / RECORDING
    if not path.exists():
        return log

    config = from_plain(log.config)
    points = _dancers_points(path, config.sensors.rate_hz)
    true = [points.get(f"{dancer_name(index)}/true", []) for index in range(config.dancers)]
    frame_count = max((item.frame + 1 for items in true for item in items), default=0)
    if not frame_count:
        return log

    joints = np.full((frame_count, config.dancers, len(JOINTS), 3), np.nan, dtype=np.float32)
    skeletons = np.full((frame_count, config.dancers, len(JOINTS), 4), np.nan, dtype=np.float32)
    for index, items in enumerate(true):
        for item in items:
            joints[item.frame, index] = item.positions_m

        for part, state in (("tracked", TRACKED), ("inferred", INFERRED)):
            for item in points.get(f"{dancer_name(index)}/{part}", []):
                skeletons[item.frame, index, item.joints, :3] = item.positions_m
                skeletons[item.frame, index, item.joints, 3] = state

    return dataclasses.replace(log, joints=joints, skeletons=skeletons)


def read_chunks(path: Path) -> Iterator[tuple[str, Any]]:
    """Yield (entity, Arrow record batch) of every chunk of a recording that has session times.

    Args:
        path: the .rrd file.

    Raises:
        RecordError: the file is damaged.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # rerun warns of a truncated file; the error below says it
            stream = rr.chunk.RrdReader(str(path)).stream()
        for chunk in stream:
            batch = chunk.to_record_batch()
            if TIMELINE in batch.schema.names:
                yield str(chunk.entity_path), batch
    except (RuntimeError, ValueError, OSError) as error:
        raise RecordError(f"{path} cannot be read: {str(error).splitlines()[0]}") from None


def _dancers_points(path: Path, rate_hz: int) -> dict[str, list[_FramePoints]]:
    """Entity below ``world``, such as ``dancer_1/true`` -> its points by frame."""
    points: dict[str, list[_FramePoints]] = {}
    for entity, batch in read_chunks(path):
        if entity.startswith("/world/dancer_") and "Points3D:positions" in batch.schema.names:
            points.setdefault(entity.removeprefix("/world/"), []).extend(_batch_points(batch, rate_hz))
    return points


def _batch_points(batch: Any, rate_hz: int) -> Iterator[_FramePoints]:
    """The points of a record batch, split by its rows."""
    times_ns = batch.column(TIMELINE).cast("int64").to_numpy()
    positions = batch.column("Points3D:positions")

    # Positions are nested lists: one list of points a row, three numbers a point.
    flat_positions = positions.flatten().flatten().to_numpy().reshape(-1, 3)
    row_ends = np.cumsum(positions.value_lengths().fill_null(0).to_numpy())

    joints = None
    if "Points3D:keypoint_ids" in batch.schema.names:
        joints = batch.column("Points3D:keypoint_ids").flatten().to_numpy()

    for row, t_ns in enumerate(times_ns):
        part = slice(row_ends[row - 1] if row else 0, row_ends[row])
        # Times of frames are rounded to nanoseconds.
        frame = round(t_ns * 1e-9 * rate_hz)
        yield _FramePoints(frame, flat_positions[part], None if joints is None else joints[part])
