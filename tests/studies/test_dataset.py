"""Files of a data set: their types for other programs, and folders that are refused."""

import json
import shutil
from dataclasses import replace

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from sjasim.analysis.study_tables import COLUMNS
from sjasim.core.errors import RecordError
from sjasim.studies import table_format
from sjasim.studies.dataset import codebook, read_study
from sjasim.studies.study_execution import Execution, execute
from sjasim.studies.table_format import TableWriter, factor_types, factor_value, row_schema

from .small_study import SHORT, small_design


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Folder of a small study with two factors."""
    place = tmp_path_factory.mktemp("dataset") / "study"
    # SIA follows nobody in the first iteration, so that its window matters only with a second one.
    factors = {"synchrony.tau_s": (0.1, 0.25), "method_options.window_s": (0.2, 1.5)}
    session = replace(SHORT, iterations=2)
    execute(small_design(groups=2, factors=factors, session=session), Execution(out=place))
    return place


def test_text_is_categorical_for_every_reader(folder):
    schema = pq.read_schema(folder / "sessions.parquet")
    assert schema.field("method").type == pa.dictionary(pa.int32(), pa.string())
    assert schema.field("seed").type == pa.int64()
    assert pq.ParquetFile(folder / "events.parquet").metadata.row_group(0).column(0).compression == "ZSTD"


def test_pandas_reads_categories(folder):
    pandas = pytest.importorskip("pandas", reason="pandas is not installed")
    sessions = pandas.read_parquet(folder / "sessions.parquet")
    assert str(sessions["method"].dtype) == "category"
    steps = pandas.read_parquet(folder / "steps.parquet").merge(sessions, on="session")
    assert set(steps.groupby("method", observed=True)["ta_s"].mean().index) == {"eca", "sia"}


def test_polars_reads_categories(folder):
    polars = pytest.importorskip("polars", reason="polars is not installed")
    sessions = polars.read_parquet(folder / "sessions.parquet")
    assert sessions.filter(polars.col("method") == "sia").height == 8


def test_factors_have_columns_that_are_empty_where_they_do_not_matter(folder):
    sessions = read_study(folder).sessions
    window_s = sessions["factor.method_options.window_s"]
    assert np.isnan(window_s[sessions["method"] != "sia"]).all()
    assert set(window_s[sessions["method"] == "sia"]) == {0.2, 1.5}
    assert factor_types(small_design(factors={"sensing": ("joints", "depth"), "dancers": (3, 4)})) == {
        "sensing": "str", "dancers": "float64",
    }  # fmt: skip
    assert factor_value({}, "sensing", "str") == ""


def test_the_codebook_names_every_column(folder):
    text = (folder / "codebook.md").read_text(encoding="utf-8")
    assert text == codebook(small_design(factors={"synchrony.tau_s": (0.1, 0.2), "method_options.window_s": (1, 2)}))
    for table, columns in COLUMNS.items():
        section = text.partition(f"## {table}.parquet")[2].partition("\n## ")[0]
        assert all(f"| `{name}` |" in section and column.meaning in section for name, column in columns.items())
    assert "| `factor.synchrony.tau_s` | number |" in text


def test_row_groups_do_not_depend_on_how_rows_arrive(tmp_path, monkeypatch):
    monkeypatch.setattr(table_format, "ROWS_PER_GROUP", 10)
    schema = row_schema("events", {})
    rows = pa.table(
        {
            "session": np.arange(37),
            "iteration": np.ones(37, dtype=int),
            "agent": np.arange(37) % 4,
            "kind": [f"kind {number % 5}" for number in range(37)],
            "t_s": np.linspace(0.0, 1.0, 37),
        },
        schema=schema,
    )
    written = []
    for name, cuts in (("one", [37]), ("many", [1, 2, 9, 20, 21, 37]), ("empty", [0, 30, 30, 37])):
        writer = TableWriter(tmp_path / name, schema)
        for first, last in zip([0, *cuts], cuts, strict=False):
            writer.add(rows.slice(first, last - first))
        writer.close()
        written.append((tmp_path / name).read_bytes())
    assert written[0] == written[1] == written[2]
    assert pq.ParquetFile(tmp_path / "one").metadata.num_row_groups == 4
    assert pq.read_table(tmp_path / "one").column("kind").to_pylist() == rows.column("kind").to_pylist()


def spoil_missing(place):
    (place / "steps.parquet").unlink()


def spoil_text(place):
    (place / "events.parquet").write_text("no table")


def spoil_column(place):
    table = pq.read_table(place / "iterations.parquet")
    pq.write_table(table.drop_columns(["gsi"]), place / "iterations.parquet")


def spoil_type(place):
    table = pq.read_table(place / "steps.parquet")
    index = table.schema.get_field_index("ta_s")
    pq.write_table(table.set_column(index, "ta_s", table.column("ta_s").cast(pa.string())), place / "steps.parquet")


def spoil_keys(place):
    table = pq.read_table(place / "sessions.parquet")
    pq.write_table(table.slice(0, 4).take([0, 1, 3]), place / "sessions.parquet")


def spoil_order(place):
    table = pq.read_table(place / "sessions.parquet")
    pq.write_table(table.take([1, 0]), place / "sessions.parquet")


def spoil_state(place):
    (place / "study.json").unlink()
    (place / "parts").mkdir()


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (spoil_missing, "steps.parquet is missing"),
        (spoil_text, "events.parquet cannot be read"),
        (spoil_column, "iterations.parquet lacks the column 'gsi'"),
        (spoil_type, "the column 'ta_s' holds string, not numbers"),
        (spoil_keys, "session 2 is not in the table of sessions"),
        (spoil_order, "the column 'session' does not rise"),
        (spoil_state, "unfinished study"),
    ],
)
def test_a_spoiled_data_set_is_refused_in_one_line(folder, tmp_path, spoil, words):
    place = tmp_path / "study"
    shutil.copytree(folder, place)
    spoil(place)
    with pytest.raises(RecordError, match=words) as caught:
        read_study(place)
    assert "\n" not in str(caught.value)


def test_a_folder_that_does_not_exist_is_named(tmp_path):
    with pytest.raises(RecordError, match="is no folder"):
        read_study(tmp_path / "nothing")


def test_the_results_are_plain_json(folder):
    results = json.loads((folder / "study.json").read_text(encoding="utf-8"))
    assert results["schema"] == 1
    assert set(results["cost"]) == {"wall_s", "backend", "jobs"}
    assert len(results["by_condition"]) == 2 + 2 + 4
