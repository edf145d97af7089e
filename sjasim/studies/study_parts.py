"""Parts of a study: the rows of a chunk of consecutive sessions, as the bytes of one file.

A chunk is the unit of work: what a process computes, and what is repeated after an interruption. Its sessions and its
bytes follow from the design alone.
"""

from __future__ import annotations

import hashlib
import io
import json
import traceback
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from .. import __version__
from ..analysis.study_tables import COLUMNS, FACTOR_PREFIX
from ..config import SessionConfig
from ..session.session import Session
from .design_file import design_from_toml
from .session_rows import SessionRows, session_rows
from .study_design import SessionSpec, StudyDesign, StudyPlan
from .table_format import TABLES, factor_types, factor_value, row_schema, rows_to_table

TIMING_CHUNK = 100
"""Sessions in a chunk if every session is of the fidelity ``timing``. Others take so long that each is a chunk."""

DIGEST_BYTES = 32
LENGTH_BYTES = 8


@dataclass(frozen=True, slots=True)
class Failure:
    """A session that failed.

    Attributes:
        session: its number.
        what: one line: which session it is, and the error.
        details: the traceback.
    """

    session: int
    what: str
    details: str


@dataclass(frozen=True, slots=True)
class Part:
    """The rows of a chunk.

    Attributes:
        tables: name -> rows of each table.
        failures: sessions that failed; their measures are NaN, and they have no rows in other tables.
    """

    tables: Mapping[str, pa.Table]
    failures: tuple[Failure, ...]


def chunk_size(design: StudyDesign) -> int:
    """Number of sessions in a chunk; the last chunk of a study may have fewer."""
    fidelities = {design.session.fidelity, *design.all_factors.get("fidelity", ())}
    return TIMING_CHUNK if fidelities == {"timing"} else 1


def chunk_count(plan: StudyPlan) -> int:
    """Number of chunks of a study."""
    return -(-len(plan) // chunk_size(plan.design))


def compute_chunk(text: str, chunk: int) -> bytes:
    """Simulate the sessions of a chunk and return them as the bytes of a part.

    This function is what backends run in other processes. It takes the design as text, which is the same for every
    version of Python and of the packages that carry it.

    Args:
        text: the design as TOML.
        chunk: number of the chunk, from 0.
    """
    plan = _plan(text)
    size = chunk_size(plan.design)
    rows = ChunkRows(plan.design)
    for spec in plan.sessions(chunk * size, (chunk + 1) * size):
        rows.add(spec)
    return rows.pack(part_key(text), chunk)


def simulated(config: SessionConfig, number: int) -> SessionRows:
    """Simulate a session and return its rows.

    Args:
        config: configuration of the session.
        number: its number in the study.
    """
    session = Session(config)
    session.advance(session.end_s)
    return session_rows(session, number)


def part_key(text: str) -> str:
    """Return a digest of the design and of sjasim's version; parts with another one belong to another study."""
    return hashlib.sha256(f"{__version__}\n{text}".encode()).hexdigest()


def failures_in(data: bytes, key: str, chunk: int) -> tuple[Failure, ...]:
    """Check the bytes of a part and return the sessions that failed; see `unpack`."""
    head, _ = _head(memoryview(data), key, chunk)
    return tuple(Failure(**failure) for failure in head["failures"])


def unpack(data: bytes, key: str, chunk: int) -> Part:
    """Read the bytes of a part.

    Args:
        data: the bytes.
        key: the study's, from `part_key`.
        chunk: number of the chunk.

    Raises:
        ValueError: the bytes are damaged, or belong to another study or chunk.
    """
    failures = failures_in(data, key, chunk)
    _, rows = _head(memoryview(data), key, chunk)
    stream = pa.BufferReader(rows)
    return Part({name: pa.ipc.open_stream(stream).read_all() for name in TABLES}, failures)


class ChunkRows:
    """Collects the rows of a chunk.

    Args:
        design: design of the study.
    """

    def __init__(self, design: StudyDesign) -> None:
        self._design = design
        self._types = factor_types(design)
        self._sessions: list[dict[str, object]] = []
        self._columns: dict[str, dict[str, list[NDArray[np.generic]]]] = {
            table: {name: [] for name in COLUMNS[table]} for table in TABLES if table != "sessions"
        }
        self._failures: list[Failure] = []

    def add(self, spec: SessionSpec) -> None:
        """Simulate a session and append its rows. A session that fails has a row without measures."""
        measures: Mapping[str, object] = {}
        try:
            rows = simulated(spec.config, spec.session)
        except Exception as error:
            self._failures.append(_failure(spec, error))
        else:
            measures = rows.session
            self._add_columns("iterations", rows.iterations)
            self._add_columns("steps", rows.steps)
            if self._design.events:
                self._add_columns("events", rows.events)
        self._sessions.append(self._session_row(spec, measures))

    def pack(self, key: str, chunk: int) -> bytes:
        """Return the bytes of the part: a digest, a head of JSON with its length, and an Arrow stream per table."""
        head = {
            "key": key,
            "chunk": chunk,
            "failures": [
                {"session": item.session, "what": item.what, "details": item.details} for item in self._failures
            ],
        }
        packed_head = json.dumps(head).encode()
        body = io.BytesIO()
        body.write(len(packed_head).to_bytes(LENGTH_BYTES, "big"))
        body.write(packed_head)

        options = pa.ipc.IpcWriteOptions(compression="zstd")
        for table in TABLES:
            schema = row_schema(table, self._types)
            with pa.ipc.new_stream(body, schema, options=options) as stream:
                stream.write_table(rows_to_table(self._gathered(table), schema))
        return hashlib.sha256(body.getvalue()).digest() + body.getvalue()

    def _add_columns(self, table: str, columns: Mapping[str, NDArray[np.generic]]) -> None:
        for name, arrays in self._columns[table].items():
            arrays.append(columns[name])

    def _session_row(self, spec: SessionSpec, measures: Mapping[str, object]) -> dict[str, object]:
        """The row of the table of sessions: the place in the design, then the measures."""
        row: dict[str, object] = {
            "session": spec.session,
            "study": spec.study,
            "group": spec.group,
            "order": spec.order,
            "condition": spec.condition,
            "method": spec.config.method,
            "humans": spec.config.humans,
            "seed": spec.config.seed,
        }
        for name, column in COLUMNS["sessions"].items():
            if name not in row:
                row[name] = measures.get(name, np.nan if column.dtype == "float64" else 0)
        for name, dtype in self._types.items():
            row[FACTOR_PREFIX + name] = factor_value(spec.levels, name, dtype)
        return row

    def _gathered(self, table: str) -> dict[str, NDArray[np.generic]]:
        """Columns of a table over all sessions of the chunk."""
        if table == "sessions":
            return {name: np.array([row[name] for row in self._sessions]) for name in self._sessions[0]}
        return {
            name: np.concatenate(arrays) if arrays else np.empty(0, dtype=COLUMNS[table][name].dtype)
            for name, arrays in self._columns[table].items()
        }


def _head(data: memoryview, key: str, chunk: int) -> tuple[dict[str, Any], memoryview]:
    """The head of a part, and the bytes behind it; raises as `unpack` does."""
    body = data[DIGEST_BYTES:]
    if hashlib.sha256(body).digest() != bytes(data[:DIGEST_BYTES]):
        raise ValueError("it is damaged")

    length = int.from_bytes(body[:LENGTH_BYTES], "big")
    head: dict[str, Any] = json.loads(bytes(body[LENGTH_BYTES : LENGTH_BYTES + length]))
    if (head["key"], head["chunk"]) != (key, chunk):
        raise ValueError("it belongs to another study")
    return head, body[LENGTH_BYTES + length :]


@lru_cache(maxsize=4)
def _plan(text: str) -> StudyPlan:
    """The plan of a design; a process needs the same one for every chunk."""
    return StudyPlan(design_from_toml(text))


def _failure(spec: SessionSpec, error: Exception) -> Failure:
    """Name a failed session and what happened in it."""
    place = (
        f"session {spec.session} (study {spec.study}, group {spec.group}, {spec.condition}, seed {spec.config.seed})"
    )
    cause = error.__cause__ or error
    details = "".join(traceback.format_exception(cause))
    return Failure(spec.session, f"{place} failed: {type(error).__name__}: {' '.join(str(error).split())}", details)
