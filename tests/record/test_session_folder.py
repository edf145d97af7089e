"""A session's folder is complete or absent, and reading it gives the same log."""

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest

from sjasim.analysis.session_metrics import measures
from sjasim.config.toml_file import from_plain
from sjasim.core.errors import RecordError
from sjasim.record import atomic_folder, session_folder
from sjasim.record.parquet import COLUMN_TABLES, ROW_TYPES


@pytest.fixture(scope="module")
def log(make_session_log):
    return make_session_log(iterations=1, joints=False)


@pytest.fixture(scope="module")
def written(log, tmp_path_factory):
    target = tmp_path_factory.mktemp("runs") / "deep" / "er" / "one"
    return session_folder.write(log, target, measures(log).as_dict(), recording=False)


def assert_equal(a, b):
    """Compare two logs, arrays and their types included; joints are in no table."""
    for field in dataclasses.fields(a):
        x = getattr(a, field.name)
        y = getattr(b, field.name)
        if field.name in COLUMN_TABLES:
            assert list(x) == list(y)
            for name in x:
                assert x[name].dtype == y[name].dtype
                np.testing.assert_array_equal(x[name], y[name])
        elif field.name != "joints":
            assert x == y, field.name


def test_reading_gives_the_written_log(log, written):
    assert_equal(session_folder.read(written), log)


def test_measures_can_be_recomputed_from_the_tables(written):
    assert measures(session_folder.read(written)).as_dict() == json.loads((written / "session.json").read_text())


def test_the_folder_holds_the_documented_files_and_no_other(written):
    tables = {f"{name}.parquet" for name in (*ROW_TYPES, *COLUMN_TABLES)}
    assert {path.name for path in written.iterdir()} == {*tables, "session.json"}
    assert [path.name for path in written.parent.iterdir()] == ["one"]


def test_event_tables_have_the_common_columns(written):
    import pyarrow.parquet as pq

    for name in ("events", "robot_events"):
        assert {"session", "iteration", "agent", "kind", "t_s"} <= set(
            pq.read_schema(written / f"{name}.parquet").names
        )


def test_empty_tables_keep_their_columns(log, tmp_path):
    bare = dataclasses.replace(log, events=(), robot_events=(), commands=(), notices=(), odometry={})
    folder = session_folder.write(bare, tmp_path / "bare", measures(bare).as_dict(), recording=False)
    assert_equal(session_folder.read(folder), bare)


def test_an_empty_folder_is_accepted_and_a_filled_one_is_refused(log, tmp_path):
    (tmp_path / "empty").mkdir()
    session_folder.write(log, tmp_path / "empty", measures(log).as_dict(), recording=False)
    with pytest.raises(RecordError, match="not empty"):
        atomic_folder.check_target(tmp_path / "empty")


@pytest.mark.parametrize("error", [OSError(28, "No space left on device"), KeyboardInterrupt()])
def test_a_failure_while_writing_leaves_nothing(log, tmp_path, monkeypatch, error):
    def fail(path, columns):
        raise error

    monkeypatch.setattr(session_folder, "write_columns", fail)
    with pytest.raises((RecordError, KeyboardInterrupt)):
        session_folder.write(log, tmp_path / "one", {}, recording=False)
    assert list(tmp_path.iterdir()) == []


def damaged(written, tmp_path, name, content):
    """A copy of a folder with one file replaced, or without it if ``content`` is None."""
    copy = tmp_path / "copy"
    copy.mkdir()
    for path in written.iterdir():
        (copy / path.name).write_bytes(path.read_bytes())
    (copy / name).unlink()
    if content is not None:
        (copy / name).write_bytes(content(written / name))
    return copy


@pytest.mark.parametrize(
    ("name", "content", "says"),
    [
        ("session.json", None, "not a session's folder"),
        ("session.json", lambda path: b"{", "damaged"),
        ("session.json", lambda path: b'{"schema": 99}', "version 1 or 2"),
        ("session.json", lambda path: b'{"schema": 1}', "lacks config"),
        ("truth.parquet", None, "missing"),
        ("truth.parquet", lambda path: path.read_bytes()[:1000], "cannot be read"),
        ("odometry.parquet", lambda path: (path.parent / "truth.parquet").read_bytes(), "lacks the column 'step_m'"),
        ("events.parquet", lambda path: (path.parent / "cues.parquet").read_bytes(), "lacks the column"),
    ],
)
def test_foreign_and_damaged_folders_give_an_error_of_one_line(written, tmp_path, name, content, says):
    with pytest.raises(RecordError, match=says) as caught:
        session_folder.read(damaged(written, tmp_path, name, content))
    assert "\n" not in str(caught.value)
    assert name in str(caught.value)


def test_an_unknown_kind_names_file_row_and_column(written, tmp_path):
    import pyarrow as pa
    import pyarrow.parquet as pq

    def with_unknown_kind(path: Path) -> bytes:
        table = pq.read_table(path)
        kinds = table.column("kind").to_pylist()
        kinds[3] = "jump"
        changed = table.set_column(table.column_names.index("kind"), "kind", pa.array(kinds))
        pq.write_table(changed, tmp_path / "changed.parquet")
        return (tmp_path / "changed.parquet").read_bytes()

    with pytest.raises(RecordError, match=r"events.parquet, row 3, column 'kind': 'jump'"):
        session_folder.read(damaged(written, tmp_path, "events.parquet", with_unknown_kind))


def test_costs_are_read_from_their_former_places_too(log, written, tmp_path):
    folder = damaged(written, tmp_path, "session.json", Path.read_bytes)
    summary = json.loads((folder / "session.json").read_text(encoding="utf-8"))
    cost = summary.pop("cost")
    assert cost == log.cost
    (folder / "session.json").write_text(json.dumps({**summary, **cost}), encoding="utf-8")

    assert session_folder.read(folder).cost == log.cost
    assert session_folder.read_summary(folder) == {**summary, "cost": cost}


def test_a_session_json_of_version_1_is_read_with_present_names(written, tmp_path, recwarn):
    folder = damaged(written, tmp_path, "session.json", Path.read_bytes)
    summary = json.loads((folder / "session.json").read_text(encoding="utf-8"))
    config = summary["config"]
    config["group"] = config.pop("dancers")
    config["room"] = {**config.pop("scene"), "side_m": 1.5, "move_m": config["dance"].pop("step_m")}
    config["method_options"] = {"effective_from": 1, "tau_s": 0.5}
    config["synchrony"].pop("tau_s")
    (folder / "session.json").write_text(json.dumps({**summary, "schema": 1}), encoding="utf-8")

    read = from_plain(session_folder.read(folder).config)
    assert (read.dancers, read.scene.side_m, read.dance.step_m) == (3, 1.5, 0.5)
    assert (read.method_options, read.synchrony.tau_s) == ({"first_followed_iteration": 1}, 0.5)
    assert len(recwarn) == 0
