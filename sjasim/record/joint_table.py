"""Recorded joints from a table of anybody's: one row per frame, person and joint."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np
import pyarrow as pa
import pyarrow.csv
import pyarrow.parquet as pq
from numpy.typing import NDArray

from ..assets.names import JOINT_INDEX, JOINTS
from ..errors import RecordError
from ..types import INFERRED, NOT_TRACKED, TRACKED, Array, BoolArray, IntArray

COLUMNS = ("t_s", "person", "joint", "x_m", "y_m", "z_m")
"""What a table must have; ``state`` may be added."""

STATES = {"tracked": TRACKED, "inferred": INFERRED, "not_tracked": NOT_TRACKED,
          "2": TRACKED, "1": INFERRED, "0": NOT_TRACKED}  # fmt: skip
"""Words or Kinect codes of tracking states."""


class RecordedJoints(NamedTuple):
    """Skeletons over time.

    Attributes:
        t_s: (T,) times of the frames [s].
        joints_m: (T, P, 25, 3) joints; NaN where the table has none [m].
        state: (T, P, 25) 2 tracked, 1 inferred, 0 not tracked.
        persons: (P,) who is in which row.
    """

    t_s: Array
    joints_m: Array
    state: NDArray[np.int8]
    persons: IntArray


def read_joints(path: str | Path) -> RecordedJoints:
    """Read a CSV or Parquet file with the columns `COLUMNS`, joints by the Kinect's names.

    Without a column ``state`` a joint is tracked wherever it has a row.

    Raises:
        RecordError: the file cannot be read, or a row is wrong, which is named by its line.
    """
    table = _table(Path(path))
    missing = [name for name in COLUMNS if name not in table]
    if missing:
        raise RecordError(f"{path}: no column {', '.join(missing)}; wanted {', '.join(COLUMNS)} and perhaps state")
    joint = table["joint"].astype(str)
    _refuse(path, "joint", table, ~np.isin(joint, JOINTS), "a joint's name, such as SpineBase")
    state = table["state"].astype(str) if "state" in table else np.full(len(joint), "tracked")
    _refuse(path, "state", table, ~np.isin(state, list(STATES)), "tracked, inferred or not_tracked")
    numbers = {name: _numbers(path, name, table) for name in COLUMNS if name != "joint"}
    for name in ("t_s", "person"):
        _refuse(path, name, table, ~np.isfinite(numbers[name]), "a finite number")
    _refuse(path, "person", table, numbers["person"] % 1 != 0, "a whole number")
    times, frame = np.unique(numbers["t_s"], return_inverse=True)
    persons, row = np.unique(numbers["person"].astype(np.int64), return_inverse=True)
    place = frame, row, np.array([JOINT_INDEX[name] for name in joint.tolist()], dtype=np.int64)
    shape = (len(times), len(persons), len(JOINTS))
    flat = np.ravel_multi_index(place, shape) if len(joint) else np.zeros(0, dtype=np.int64)
    once = np.zeros(len(flat), dtype=bool)
    once[np.unique(flat, return_index=True)[1]] = True
    _refuse(path, "joint", table, ~once, "each joint once per time and person")
    joints, codes = np.full((*shape, 3), np.nan), np.zeros(shape, dtype=np.int8)
    joints[place] = np.stack([numbers[name] for name in COLUMNS[3:]], axis=1)
    codes[place] = [STATES[word] for word in state.tolist()]
    return RecordedJoints(times, joints, codes, persons)


def _table(path: Path) -> dict[str, NDArray[np.generic]]:
    """Columns by name."""
    try:
        stored: pa.Table = pq.read_table(path) if path.suffix == ".parquet" else pyarrow.csv.read_csv(path)
    except (OSError, pa.ArrowException) as error:
        raise RecordError(f"{path} cannot be read as a table: {str(error).splitlines()[0]}") from None
    return {name: stored[name].to_numpy(zero_copy_only=False) for name in stored.column_names}


def _numbers(path: str | Path, name: str, table: dict[str, NDArray[np.generic]]) -> Array:
    """A column as numbers; names the first row that is none."""
    try:
        return table[name].astype(np.float64)
    except (TypeError, ValueError):
        wrong = np.array([not _is_number(value) for value in table[name].tolist()])
        _refuse(path, name, table, wrong, "a number")
        raise


def _is_number(value: object) -> bool:
    try:
        float(str(value))
    except ValueError:
        return False
    return True


def _refuse(path: str | Path, name: str, table: dict[str, NDArray[np.generic]], wrong: BoolArray, wanted: str) -> None:
    """Name the first wrong row; a header is line 1."""
    rows = np.flatnonzero(wrong)
    if len(rows):
        raise RecordError(f"{path}, line {rows[0] + 2}, {name}: {table[name].tolist()[rows[0]]!r}, wanted {wanted}")
