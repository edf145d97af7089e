"""The page of a session's folder names every column of every table and every key of session.json, and no other."""

import dataclasses

import pyarrow.parquet as pq
import pytest

from sjasim.analysis.session_metrics import measures
from sjasim.humans.timing.parameters import TimingParameters, preset_names
from sjasim.record.parquet import COLUMN_TABLES, ROW_TYPES
from sjasim.record.session_folder import write
from sjasim.simulation.ground_truth_recorder import ODOMETRY_COLUMNS, TRUTH_COLUMNS

from .pages import table_rows, text_of

PAGE = "docs/session-folder.md"


@pytest.fixture
def folder(tmp_path, make_session_log):
    log = make_session_log(iterations=1, joints=False)
    return write(log, tmp_path / "session", measures(log).as_dict(), recording=False)


@pytest.mark.parametrize("table", ROW_TYPES)
def test_columns_of_tables_with_one_value_a_row(folder, table):
    stored = set(pq.read_schema(folder / f"{table}.parquet").names)
    assert set(table_rows(PAGE, f"## Table `{table}`")) == stored


@pytest.mark.parametrize(("table", "columns"), [("truth", TRUTH_COLUMNS), ("odometry", ODOMETRY_COLUMNS)])
def test_columns_of_recorded_tables(table, columns):
    assert set(table_rows(PAGE, f"## Table `{table}`")) == set(columns)


def test_every_table_has_a_section():
    assert text_of(PAGE).count("\n## Table `") == len(ROW_TYPES) + len(COLUMN_TABLES)


def test_keys_of_session_json(make_session_log):
    summary = measures(make_session_log(iterations=1, joints=False)).as_dict()
    rows = table_rows(PAGE, "## File `session.json`")
    assert set(rows) >= set(summary)
    for part in ("detector", "robot"):
        own = " ".join(rows[part].split())
        assert all(f"`{key}`" in own for key in summary[part]), part
    entry = table_rows(PAGE, "Each entry of `iterations` has:")
    assert set(entry) == set(summary["iterations"][0])


def test_people_page_has_every_parameter_and_preset():
    assert set(table_rows("docs/people.md", "## The timing model")) == {
        field.name for field in dataclasses.fields(TimingParameters)
    }
    assert set(table_rows("docs/people.md", "## Presets")) == set(preset_names())
