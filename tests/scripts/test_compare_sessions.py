"""The comparison of two folders of sessions: what counts as equal, and what it says of a difference."""

import importlib.util
import json
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

PATH = Path(__file__).resolve().parents[2] / "scripts" / "compare_sessions.py"

EVENTS = {
    "iteration": [1, 1, 1],
    "person": ["dancer_1", "dancer_2", "dancer_1"],
    "kind": ["start_forward", "start_forward", "stop_forward"],
    "t_s": [1.0, 1.5, 3.0],
}
SUMMARY = {"gsi": 0.5, "iterations": [{"index": 1}], "config": {"group": 3}, "cpu_s": 4.0}


@pytest.fixture(scope="module")
def script():
    spec = importlib.util.spec_from_file_location("compare_sessions", PATH)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def compare(script, tmp_path, capsys):
    """Compares a session with another one of the given events and summary: the exit code and the lines printed."""

    def write(folder, events, summary):
        (folder / "sia").mkdir(parents=True)
        pq.write_table(pa.table(events), folder / "sia" / "events.parquet")
        (folder / "sia" / "session.json").write_text(json.dumps(summary))
        script.write_digests(folder / "sia.json", script.read_tables(folder / "sia"))

    def compared(events=EVENTS, summary=SUMMARY):
        write(tmp_path / "old", EVENTS, SUMMARY)
        write(tmp_path / "new", events, summary)
        code = script.compare(tmp_path / "old", tmp_path / "new")
        return code, capsys.readouterr().out.splitlines()

    return compared


def test_equal_sessions_are_equal(compare):
    lines = ["sia/events: equal", "sia/session.json: equal", "1 configurations, 2 tables, 0 of them different"]
    assert compare() == (0, lines)


def test_cost_and_configuration_may_differ(compare):
    code, _ = compare(summary={**SUMMARY, "config": {"dancers": 3}, "cost": {"cpu_s": 5.0}})
    assert code == 0


def test_renamed_and_reordered_columns_are_equal_and_listed(compare):
    renamed = {"agent" if key == "person" else key: EVENTS[key] for key in ("t_s", "person", "kind", "iteration")}
    code, lines = compare(events=renamed)
    assert code == 0
    assert lines[0] == "sia/events: equal; renamed: person to agent"


def test_the_first_difference_is_named_with_what_events_have_in_common(compare):
    code, lines = compare(events={**EVENTS, "t_s": [1.0, 1.75, 2.9]})
    assert code == 1
    assert lines[0] == (
        "sia/events: DIFFERENT; first at row 1, column t_s: 1.5 and 1.75; columns t_s; "
        "kinds equal; order equal; counts equal; largest time difference 0.25 s"
    )
    assert lines[-1] == "1 configurations, 2 tables, 1 of them different"


def test_a_missing_event_does_not_shift_the_others(compare):
    code, lines = compare(events={key: values[1:] for key, values in EVENTS.items()})
    assert code == 1
    assert "first at row 0, column person: dancer_1 and dancer_2" in lines[0]
    assert lines[0].endswith("kinds equal; order DIFFERENT; counts DIFFERENT; largest time difference 0 s")


def test_events_in_another_order_have_equal_counts(compare):
    _, lines = compare(events={key: [values[1], values[0], values[2]] for key, values in EVENTS.items()})
    assert lines[0].endswith("kinds equal; order DIFFERENT; counts equal; largest time difference 0 s")


def test_an_added_column_and_a_changed_figure_are_differences(compare):
    code, lines = compare({**EVENTS, "early": [False, False, True]}, {**SUMMARY, "gsi": 0.25})
    assert code == 1
    assert lines[0] == "sia/events: DIFFERENT; only in one: early"
    assert lines[1] == "sia/session.json: DIFFERENT; first at row 0, column gsi: 0.5 and 0.25; columns gsi"


def test_rows_without_an_identity_are_compared_by_their_place(script):
    found = list(script.describe({"t_s": [1.0, 2.0], "x_m": [0, 1]}, {"t_s": [1.0, 2.5], "x_m": [0, 1]}))
    assert found[0] == "first at row 1, column t_s: 2.0 and 2.5"
    assert found[-1] == "largest time difference 0.5 s"


def test_a_session_that_failed_is_a_difference(script, tmp_path, capsys):
    for folder in (tmp_path / "old", tmp_path / "new"):
        folder.mkdir()
        script.write_digests(folder / "sia.json", {})
    assert script.compare(tmp_path / "old", tmp_path / "new") == 1
    assert "no tables" in capsys.readouterr().out


def test_empty_folders_do_not_pass(script, tmp_path):
    assert script.compare(tmp_path, tmp_path) == 1
