"""Studies from beginning to end, in this process: tables, interruptions, failures, and the folder's states."""

import json
import shutil
from dataclasses import replace

import numpy as np
import pytest

import sjasim
from sjasim.analysis.study_tables import COLUMNS
from sjasim.core.errors import ConfigError, PluginError, RecordError
from sjasim.session.session import Session
from sjasim.studies import backends, study_parts
from sjasim.studies.backends.local_processes import results as local_results
from sjasim.studies.dataset import StudyReader, read_study
from sjasim.studies.folder_lock import folder_lock
from sjasim.studies.session_rows import session_rows
from sjasim.studies.study_design import StudyPlan
from sjasim.studies.study_execution import Execution, execute, run_study
from sjasim.studies.study_folder import PARTS
from sjasim.studies.study_results import read_results

from .small_study import digests, small_design


@pytest.fixture(autouse=True)
def small_chunks(monkeypatch):
    """Chunks of two sessions, so that a small study has several."""
    monkeypatch.setattr(study_parts, "TIMING_CHUNK", 2)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Folder of a small study that ran without interruption."""
    folder = tmp_path_factory.mktemp("studies") / "whole"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(study_parts, "TIMING_CHUNK", 2)
        execute(small_design(), Execution(out=folder))
    return folder


def interrupt_after(monkeypatch, parts):
    """Let the local backend deliver so many parts, and then press Ctrl-C."""

    def interrupted(text, chunks, jobs, address=""):
        for done, result in enumerate(local_results(text, chunks, jobs, address)):
            if done == parts:
                raise KeyboardInterrupt
            yield result

    monkeypatch.setattr(backends.BackendName, "results", lambda self: interrupted)


def test_a_study_leaves_tables_with_all_columns_and_no_parts(whole):
    names = {path.name for path in whole.iterdir()}
    assert names == {
        "design.toml", "study.json", "codebook.md",
        "sessions.parquet", "iterations.parquet", "steps.parquet", "events.parquet",
    }  # fmt: skip
    tables = read_study(whole)
    for name, columns in COLUMNS.items():
        table = getattr(tables, name)
        assert list(table) == list(columns)
        assert {len(values) for values in table.values()} == {len(table["session"])}
    assert tables.sessions["session"].tolist() == list(range(9))
    assert tables.sessions["method"].tolist() == ["none", "eca", "sia", "none", "sia", "eca", "none", "eca", "sia"]
    assert len(tables.iterations["session"]) == 9
    assert len(tables.steps["session"]) == 6 * 9
    assert set(tables.events["agent"]) == {0, 1, 2, 3}


def test_every_row_is_that_of_its_session_alone(whole):
    tables = read_study(whole)
    for spec in StudyPlan(small_design()).sessions(3, 6):
        session = Session(spec.config)
        session.advance(session.end_s)
        rows = session_rows(session, spec.session)
        for name in ("iterations", "steps", "events"):
            stored = getattr(tables, name)
            chosen = stored["session"] == spec.session
            for column, values in getattr(rows, name).items():
                np.testing.assert_array_equal(stored[column][chosen], values)
        assert tables.sessions["gsi"][spec.session] == rows.session["gsi"]
        assert tables.sessions["seed"][spec.session] == spec.config.seed


def test_an_interrupted_study_is_continued_and_gives_the_same_bytes(whole, tmp_path, monkeypatch, capsys):
    folder = tmp_path / "study"
    with monkeypatch.context() as patch:
        interrupt_after(patch, 2)
        with pytest.raises(KeyboardInterrupt):
            execute(small_design(), Execution(out=folder))
    assert "continue with --resume" in capsys.readouterr().err
    assert sorted(path.name for path in (folder / PARTS).iterdir()) == ["chunk_000000.part", "chunk_000001.part"]
    finished = {path: path.stat().st_mtime_ns for path in (folder / PARTS).iterdir()}

    with pytest.raises(RecordError, match="unfinished study"):
        read_study(folder)
    with pytest.raises(RecordError, match="holds an unfinished study: continue it with --resume"):
        execute(small_design(), Execution(out=folder))

    # A draft of a part is what a kill leaves in the middle of writing; a damaged part is what a full disk may leave.
    (folder / PARTS / "chunk_000003.part.draft").write_bytes(b"half")
    (folder / PARTS / "chunk_000004.part").write_bytes(b"damaged")
    computed = []
    monkeypatch.setattr(backends.BackendName, "results", lambda self: counted(computed))
    execute(small_design(), Execution(out=folder, resume=True))
    assert computed == [2, 3, 4]
    assert len(finished) == 2
    assert digests(folder) == digests(whole)
    assert json.loads((folder / "study.json").read_text())["by_condition"] == read_results(whole)["by_condition"]


def counted(computed):
    """The local backend, which writes down the chunks that it computes, last one first."""

    def results(text, chunks, jobs, address=""):
        for chunk in reversed(chunks):
            computed.insert(0, chunk)
            yield from local_results(text, [chunk], jobs, address)

    return results


def test_a_finished_study_is_not_computed_again(whole, tmp_path, monkeypatch):
    folder = tmp_path / "study"
    shutil.copytree(whole, folder)
    interrupt_after(monkeypatch, 0)
    assert execute(small_design(), Execution(out=folder, resume=True)) == read_results(whole)
    with pytest.raises(RecordError, match="holds a study"):
        execute(small_design(), Execution(out=folder))


def test_a_study_is_not_continued_with_another_design(whole):
    session = replace(small_design().session, iterations=2)
    with pytest.raises(RecordError, match=r"session\.iterations = 1 instead of 2"):
        execute(small_design(session=session), Execution(out=whole, resume=True))
    with pytest.raises(RecordError, match="groups = 3 instead of 4"):
        execute(small_design(groups=4), Execution(out=whole, resume=True))


def test_another_study_replaces_it_only_when_asked(whole, tmp_path):
    folder = tmp_path / "study"
    shutil.copytree(whole, folder)
    execute(small_design(groups=2), Execution(out=folder, overwrite=True))
    assert len(read_study(folder).sessions["session"]) == 6


def test_a_folder_with_something_else_is_never_used(tmp_path):
    (tmp_path / "thesis.tex").write_text("mine")
    for execution in (Execution(out=tmp_path, overwrite=True), Execution(out=tmp_path, resume=True)):
        with pytest.raises(RecordError, match="holds no study"):
            execute(small_design(), execution)
    assert (tmp_path / "thesis.tex").read_text() == "mine"


def test_a_folder_has_one_writer(tmp_path):
    folder = tmp_path / "study"
    folder.mkdir()
    with folder_lock(folder), pytest.raises(RecordError, match=r"written by another process \(process \d+ on "):
        execute(small_design(), Execution(out=folder))
    execute(small_design(groups=2), Execution(out=folder))


def test_parts_of_another_version_are_computed_again(whole, tmp_path, monkeypatch):
    folder = tmp_path / "study"
    with monkeypatch.context() as patch:
        interrupt_after(patch, 2)
        patch.setattr(study_parts, "__version__", "0.0")
        with pytest.raises(KeyboardInterrupt):
            execute(small_design(), Execution(out=folder))
    computed = []
    monkeypatch.setattr(backends.BackendName, "results", lambda self: counted(computed))
    execute(small_design(), Execution(out=folder, resume=True))
    assert computed == [0, 1, 2, 3, 4]
    assert digests(folder) == digests(whole)


FAILING = f"{__package__}.failing_methods:FailsSometimes"


def test_a_failing_session_stops_the_study_and_is_named(tmp_path, capsys):
    design = small_design(groups=6, methods=("eca", FAILING))
    with pytest.raises(
        PluginError, match=r"session \d+ \(study 0, group \d, .*FailsSometimes, seed \d+\) failed: Hook"
    ):
        execute(design, Execution(out=tmp_path / "study"))
    assert 'raise RuntimeError("no idea' in capsys.readouterr().err


def test_a_study_that_goes_on_after_failures_names_them_and_leaves_out_their_groups(tmp_path):
    design = small_design(groups=6, methods=("eca", FAILING), on_error="continue")
    results = execute(design, Execution(out=tmp_path / "study"))
    count = results["failures"]["count"]
    assert 0 < count < 6
    assert len(results["failures"]["first"]) == count
    assert "no idea what to do" in results["failures"]["first"][0]
    assert results["notices"] == [f"{count} group(s) left out of the analysis because a session failed"]
    assert {row["sessions"] for row in results["by_condition"]} == {6 - count}

    tables = read_study(tmp_path / "study")
    failed = np.isnan(tables.sessions["gsi"])
    assert len(failed) == 18
    assert failed.sum() == count
    assert not np.isin(tables.iterations["session"], tables.sessions["session"][failed]).any()


def test_the_python_interface_returns_the_tables(whole, tmp_path):
    tables = run_study(small_design(), tmp_path / "study", jobs=1)
    assert digests(tmp_path / "study") == digests(whole)
    assert sjasim.read_study(whole).sessions["gsi"].tolist() == tables.sessions["gsi"].tolist()
    assert sjasim.run_study(small_design(groups=2)).sessions["group"].tolist() == [1, 1, 1, 2, 2, 2]


def test_without_events_the_other_tables_stay_as_they_are(whole):
    tables = run_study(small_design(events=False))
    assert len(tables.events["t_s"]) == 0
    assert tables.iterations["gsi"].tolist() == read_study(whole).iterations["gsi"].tolist()


def test_means_and_intervals_of_the_conditions(whole):
    from scipy import stats

    sessions = read_study(whole).sessions
    (row,) = [row for row in read_results(whole)["by_condition"] if row["method"] == "sia"]
    gsi = sessions["gsi"][sessions["method"] == "sia"]
    low, high = stats.t.interval(0.95, len(gsi) - 1, gsi.mean(), stats.sem(gsi))
    assert row["gsi"] == pytest.approx({"mean": gsi.mean(), "sd": gsi.std(ddof=1), "low": low, "high": high, "n": 3})


def test_a_reader_gives_each_replication(tmp_path, monkeypatch):
    folder = tmp_path / "study"
    design = small_design(groups=2, replications=3, factors={"synchrony.tau_s": (0.1, 0.25)})
    execute(design, Execution(out=folder))
    reader = StudyReader(folder)
    whole = read_study(folder)
    studies = list(reader)
    assert [study.sessions["study"][0] for study in studies] == [0, 1, 2]
    for name in COLUMNS:
        joined = np.concatenate([getattr(study, name)["session"] for study in studies])
        assert joined.tolist() == getattr(whole, name)["session"].tolist()
    assert set(whole.sessions["factor.synchrony.tau_s"]) == {0.1, 0.25}

    monkeypatch.setattr("sjasim.studies.dataset.BLOCK_SESSIONS", 14)
    sizes = [len(block.sessions["session"]) for block in reader.blocks(events=False)]
    assert sizes == [12, 12, 12]


@pytest.mark.parametrize("text", ["spark", "local://x", "dask://", "ray:10001"])
def test_an_unknown_backend_is_refused(text):
    with pytest.raises(ConfigError, match="local, dask, dask://host:port"):
        Execution(backend=text)
