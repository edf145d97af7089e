"""What a recording still knows that the tables do not: the joints, true and as the active client saw them."""

from __future__ import annotations

import dataclasses
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import rerun as rr

from ...assets.names import JOINTS
from ...config.toml_file import from_plain
from ...core import INFERRED, TRACKED, dancer_name
from ...core.errors import RecordError
from ...core.session_log import SessionLog
from ..session_folder import read
from .scene import TIMELINE

RECORDING = "session.rrd"


def read_with_joints(folder: Path) -> SessionLog:
    """A session's folder with the joints that its recording holds; without a recording they are None.

    Raises:
        RecordError: the folder or its recording is damaged or of another version.
    """
    log = read(folder)
    path = folder / RECORDING
    if not path.exists():
        return log
    config = from_plain(log.config)
    frames: dict[str, list[tuple[int, Any, Any]]] = {}
    for entity, batch in read_chunks(path):
        if entity.startswith("/world/dancer_") and "Points3D:positions" in batch.schema.names:
            _collect(frames, entity.removeprefix("/world/"), batch, config.sensors.rate_hz)
    true = [frames.get(f"{dancer_name(index)}/true", []) for index in range(config.dancers)]
    count = max((frame + 1 for rows in true for frame, _, _ in rows), default=0)
    if not count:
        return log
    joints = np.full((count, config.dancers, len(JOINTS), 3), np.nan, dtype=np.float32)
    skeletons = np.full((count, config.dancers, len(JOINTS), 4), np.nan, dtype=np.float32)
    for index, rows in enumerate(true):
        for frame, places, _ in rows:
            joints[frame, index] = places
        for part, state in (("tracked", TRACKED), ("inferred", INFERRED)):
            for frame, places, ids in frames.get(f"{dancer_name(index)}/{part}", []):
                skeletons[frame, index, ids, :3] = places
                skeletons[frame, index, ids, 3] = state
    return dataclasses.replace(log, joints=joints, skeletons=skeletons)


def read_chunks(path: Path) -> Iterator[tuple[str, Any]]:
    """Entity and record batch of every chunk of a recording that is on the session's clock.

    Raises:
        RecordError: the file is damaged.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # a file cut short is told of below
            stream = rr.chunk.RrdReader(str(path)).stream()
        for chunk in stream:
            batch = chunk.to_record_batch()
            if TIMELINE in batch.schema.names:
                yield str(chunk.entity_path), batch
    except (RuntimeError, ValueError, OSError) as error:
        raise RecordError(f"{path} cannot be read: {str(error).splitlines()[0]}") from None


def _collect(frames: dict[str, list[tuple[int, Any, Any]]], name: str, batch: Any, rate_hz: int) -> None:
    times = batch.column(TIMELINE).cast("int64").to_numpy()
    places = batch.column("Points3D:positions")
    flat = places.flatten().flatten().to_numpy().reshape(-1, 3)
    ends = np.cumsum(places.value_lengths().fill_null(0).to_numpy())
    ids = None
    if "Points3D:keypoint_ids" in batch.schema.names:
        ids = batch.column("Points3D:keypoint_ids").flatten().to_numpy()
    for row, t_ns in enumerate(times):
        part = slice(ends[row - 1] if row else 0, ends[row])
        frame = round(t_ns * 1e-9 * rate_hz)
        frames.setdefault(name, []).append((frame, flat[part], None if ids is None else ids[part]))
