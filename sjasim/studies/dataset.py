"""The data set of a study: four Parquet tables and a codebook, written as a stream, and read whole or in blocks."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

from ..analysis.study_tables import COLUMNS, FACTOR_PREFIX, StudyTables
from ..core.errors import RecordError
from .study_design import StudyDesign
from .study_folder import DRAFT, PARTS, STUDY_FILE, StudyFolder, publish
from .study_parts import Failure
from .table_format import TABLES, TableWriter, factor_types, row_schema, table_to_columns

CODEBOOK_FILE = "codebook.md"

BLOCK_SESSIONS = 2000
"""Sessions that `StudyReader.blocks` reads at a time, rounded down to whole groups."""

_ARROW_WORDS = {"int64": "integer", "float64": "number", "str": "text"}


def table_file(table: str) -> str:
    """Name of the file of a table."""
    return f"{table}.parquet"


def write_dataset(folder: StudyFolder, chunks: int) -> list[Failure]:
    """Write the tables and the codebook of a study from its parts, one part at a time.

    Args:
        folder: folder of the study, with all parts.
        chunks: number of the parts.

    Returns:
        the sessions that failed.

    Raises:
        RecordError: a part cannot be read.
    """
    types = factor_types(folder.design)
    paths = {table: folder.path / table_file(table) for table in TABLES}
    drafts = {table: path.with_name(path.name + DRAFT) for table, path in paths.items()}
    writers = {table: TableWriter(draft, row_schema(table, types)) for table, draft in drafts.items()}

    failures: list[Failure] = []
    for chunk in range(chunks):
        part = folder.read_part(chunk)
        failures += part.failures
        for table, writer in writers.items():
            writer.add(part.tables[table])

    for table, writer in writers.items():
        writer.close()
        publish(drafts[table], paths[table])
    folder.write(CODEBOOK_FILE, codebook(folder.design))
    return failures


def codebook(design: StudyDesign) -> str:
    """The codebook of a data set: every column with its type and meaning, as a page of Markdown."""
    lines = [
        "# Codebook",
        "",
        "Four tables share the key `session`. Text columns are categorical. A number that was not measured is NaN. A "
        "session that failed has a row in `sessions` without measures, and no rows elsewhere; `study.json` names it.",
    ]
    for table, columns in COLUMNS.items():
        rows = [(name, column.dtype, column.meaning) for name, column in columns.items()]
        if table == "sessions":
            rows += [
                (FACTOR_PREFIX + name, dtype, f"level of the factor {name}; empty or NaN where it does not matter")
                for name, dtype in factor_types(design).items()
            ]
        lines += ["", f"## {table_file(table)}", "", "| column | type | meaning |", "|---|---|---|"]
        lines += [f"| `{name}` | {_ARROW_WORDS[dtype]} | {meaning} |" for name, dtype, meaning in rows]
    return "\n".join(lines) + "\n"


def read_study(folder: str | Path, *, events: bool = True) -> StudyTables:
    """Read the tables of a study.

    A study of very many sessions does not fit in memory; see `StudyReader`.

    Args:
        folder: folder of a complete study.
        events: whether the table of events is read; otherwise it has no rows.

    Returns:
        the tables.

    Raises:
        RecordError: the folder holds no complete study, a table cannot be read or lacks a column, or its rows belong to
            sessions that do not exist.
    """
    reader = StudyReader(folder)
    return reader.sessions(0, reader.last, events=events)


class StudyReader:
    """Reads the tables of a study group by group, for data that do not fit in memory.

    Args:
        folder: folder of a complete study.
        complete: whether the folder must have study.json, which is written last.

    Raises:
        RecordError: see `read_study`.

    Attributes:
        folder: as given.
        last: number behind that of the last session.
    """

    def __init__(self, folder: str | Path, *, complete: bool = True) -> None:
        self.folder = Path(folder).expanduser()
        if complete:
            _check_folder(self.folder)
        self._files = {table: _opened(self.folder / table_file(table), table) for table in TABLES}

        keys = self._files["sessions"].read(columns=["session", "study", "group"])
        self._session = keys.column("session").to_numpy()
        self._study = keys.column("study").to_numpy()
        group = keys.column("group").to_numpy()
        if len(self._session) == 0 or (np.diff(self._session) <= 0).any():
            raise RecordError(f"{self.folder / table_file('sessions')}: the column 'session' does not rise")

        # First session of each group: neither group nor study are the same as in the row before.
        changes = (np.diff(group) != 0) | (np.diff(self._study) != 0)
        self._group_starts = self._session[np.concatenate([[True], changes])]
        self.last = int(self._session[-1]) + 1

    def __iter__(self) -> Iterator[StudyTables]:
        """Yield the tables of each replication of the study."""
        for study in np.unique(self._study):
            inside = self._session[self._study == study]
            yield self.sessions(int(inside[0]), int(inside[-1]) + 1)

    def blocks(self, *, events: bool = True) -> Iterator[StudyTables]:
        """Yield the tables of consecutive whole groups, about `BLOCK_SESSIONS` sessions at a time."""
        starts = [int(start) for start in self._group_starts]
        first = starts[0]
        for start, following in zip(starts, [*starts[1:], self.last], strict=True):
            if following - first > BLOCK_SESSIONS and start > first:
                yield self.sessions(first, start, events=events)
                first = start
        yield self.sessions(first, self.last, events=events)

    def sessions(self, first: int, last: int, *, events: bool = True) -> StudyTables:
        """Return the tables of the sessions from number ``first`` to ``last``, which is not included."""
        known = self._session[(self._session >= first) & (self._session < last)]
        tables = {}
        for table, file in self._files.items():
            rows = _rows_of(file, first, last if events or table != "events" else first)
            tables[table] = table_to_columns(rows)
            strangers = np.setdiff1d(tables[table]["session"], known)
            if len(strangers):
                path = self.folder / table_file(table)
                raise RecordError(f"{path}: session {strangers[0]} is not in the table of sessions")
        return StudyTables(**tables)


def concatenated(parts: Sequence[StudyTables]) -> StudyTables:
    """Join the tables of disjoint sessions, in the given order."""
    joined = {}
    for table in TABLES:
        columns = [getattr(part, table) for part in parts]
        joined[table] = {name: np.concatenate([column[name] for column in columns]) for name in columns[0]}
    return StudyTables(**joined)


def _rows_of(file: pq.ParquetFile, first: int, last: int) -> pa.Table:
    """The rows of a table whose session is ``first`` to ``last``, not included. Other row groups are not read."""
    wanted = [
        group
        for group in range(file.num_row_groups)
        if _overlaps(file.metadata.row_group(group), file.schema_arrow.get_field_index("session"), first, last)
    ]
    rows = file.read_row_groups(wanted) if wanted else file.schema_arrow.empty_table()
    session = rows.column("session")
    return rows.filter(pc.and_(pc.greater_equal(session, first), pc.less(session, last)))


def _overlaps(group: pq.RowGroupMetaData, column: int, first: int, last: int) -> bool:
    """Whether a row group may hold sessions from ``first`` to ``last``, not included."""
    statistics = group.column(column).statistics
    return statistics is None or not statistics.has_min_max or (statistics.max >= first and statistics.min < last)


def _check_folder(folder: Path) -> None:
    """Refuse a folder without a complete study."""
    if not folder.is_dir():
        raise RecordError(f"{folder} is no folder")
    if not (folder / STUDY_FILE).exists() and (folder / PARTS).exists():
        raise RecordError(f"{folder} holds an unfinished study: continue it with sjasim study --resume --out {folder}")


def _opened(path: Path, table: str) -> pq.ParquetFile:
    """Open a table and check its columns."""
    try:
        file = pq.ParquetFile(path)
    except FileNotFoundError:
        raise RecordError(f"{path} is missing: this is no complete study") from None
    except (OSError, pa.ArrowException) as error:
        raise RecordError(f"{path} cannot be read: {str(error).splitlines()[0]}") from None

    for name, column in COLUMNS[table].items():
        if name not in file.schema_arrow.names:
            raise RecordError(f"{path} lacks the column {name!r}")
        found = file.schema_arrow.field(name).type
        if not _has_type(found, column.dtype):
            raise RecordError(f"{path}: the column {name!r} holds {found}, not {_ARROW_WORDS[column.dtype]}s")
    return file


def _has_type(found: pa.DataType, dtype: str) -> bool:
    if dtype == "str":
        return bool(pa.types.is_dictionary(found) or pa.types.is_string(found) or pa.types.is_large_string(found))
    return bool(found == (pa.int64() if dtype == "int64" else pa.float64()))
