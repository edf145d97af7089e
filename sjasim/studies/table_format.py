"""Format of a study's tables: Arrow types of the columns, and Parquet files whose bytes depend on the rows alone."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from ..analysis.study_tables import COLUMNS, FACTOR_PREFIX, Columns
from .study_design import Level, StudyDesign, level_text

ROWS_PER_GROUP = 2**17
"""Rows in a row group of a table: few enough to hold in memory, enough to compress well."""

ROW_TYPES = {"int64": pa.int64(), "float64": pa.float64(), "str": pa.string()}
"""Type of a column -> Arrow type of its values in a part of a study."""

CATEGORY = pa.dictionary(pa.int32(), pa.string())
"""Arrow type of strings in a table: a categorical of pandas and polars, and a factor of R."""

TABLES = tuple(COLUMNS)
"""Names of the tables, in the order of the files."""


def row_schema(table: str, factors: Mapping[str, str]) -> pa.Schema:
    """Schema of a table with plain strings.

    Args:
        table: name of the table.
        factors: name -> type of the design's factors, from `factor_types`.
    """
    columns = {name: column.dtype for name, column in COLUMNS[table].items()}
    if table == "sessions":
        columns |= {FACTOR_PREFIX + name: dtype for name, dtype in factors.items()}
    return pa.schema([(name, ROW_TYPES[dtype]) for name, dtype in columns.items()])


def factor_types(design: StudyDesign) -> dict[str, str]:
    """Name -> type of the column of each factor: float64 if all its levels are numbers, else str."""
    return {
        name: "float64" if all(_is_number(level) for level in levels) else "str"
        for name, levels in design.all_factors.items()
    }


def factor_value(levels: Mapping[str, Level], name: str, dtype: str) -> float | str:
    """Value of a factor's column for a session; NaN or "" if the factor does not matter to the session."""
    if dtype == "float64":
        level = levels.get(name, np.nan)
        assert isinstance(level, float | int)
        return float(level)
    return level_text(levels[name]) if name in levels else ""


def rows_to_table(columns: Columns, schema: pa.Schema) -> pa.Table:
    """Convert columns to an Arrow table of a schema."""
    arrays = [pa.array(columns[field.name], type=field.type) for field in schema]
    return pa.table(arrays, schema=schema)


def table_to_columns(table: pa.Table) -> dict[str, NDArray[np.generic]]:
    """Convert an Arrow table to columns; the strings of a column share their objects."""
    return {name: _values(table.column(name)) for name in table.column_names}


class TableWriter:
    """Writes a table as a Parquet file, in row groups of `ROWS_PER_GROUP` rows however the rows arrive.

    Args:
        path: the file to write.
        schema: schema of the rows, from `row_schema`.
    """

    def __init__(self, path: Path, schema: pa.Schema) -> None:
        self._names = schema.names
        fields = [field.with_type(CATEGORY) if pa.types.is_string(field.type) else field for field in schema]
        self._schema = pa.schema(fields)
        self._writer = pq.ParquetWriter(path, self._schema, compression="zstd", version="2.6", store_schema=True)
        self._waiting: list[pa.Table] = []
        self._rows = 0

    def add(self, rows: pa.Table) -> None:
        """Append rows."""
        self._waiting.append(rows)
        self._rows += rows.num_rows
        while self._rows >= ROWS_PER_GROUP:
            self._write(ROWS_PER_GROUP)

    def close(self) -> None:
        """Write the rows that wait, and complete the file."""
        if self._rows:
            self._write(self._rows)
        self._writer.close()

    def _write(self, count: int) -> None:
        """Write the first ``count`` rows that wait as one row group."""
        rows = pa.concat_tables(self._waiting)
        group = rows.slice(0, count).combine_chunks()
        self._waiting = [rows.slice(count)]
        self._rows -= count

        columns = [self._encoded(group.column(name)) for name in self._names]
        self._writer.write_table(pa.table(columns, schema=self._schema), row_group_size=count)

    @staticmethod
    def _encoded(column: pa.ChunkedArray) -> pa.ChunkedArray:
        """The column with strings as codes, in the order in which they first appear in the row group."""
        return column.dictionary_encode().cast(CATEGORY) if pa.types.is_string(column.type) else column


def _values(column: pa.ChunkedArray) -> NDArray[np.generic]:
    if not pa.types.is_dictionary(column.type) and not pa.types.is_string(column.type):
        return np.asarray(column.to_numpy())
    encoded = column.cast(CATEGORY).unify_dictionaries().combine_chunks()
    if isinstance(encoded, pa.ChunkedArray):
        encoded = encoded.chunk(0) if encoded.num_chunks else pa.array([], CATEGORY)
    names = np.array(encoded.dictionary.to_pylist(), dtype=object)
    codes = np.asarray(encoded.indices.to_numpy(zero_copy_only=False))
    return names[codes] if len(codes) else np.array([], dtype=object)


def _is_number(level: Level) -> bool:
    return isinstance(level, float | int) and not isinstance(level, bool)
