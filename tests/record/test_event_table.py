"""Event tables: every row is read, or refused with its line and column."""

from __future__ import annotations

from pathlib import Path

import pytest

from sjasim.core import Cue, Kind, Move
from sjasim.core.errors import RecordError
from sjasim.core.session_log import natural_order
from sjasim.record.event_table import read_event_table
from sjasim.record.parquet import save_csv, write_rows

HEAD = "session,iteration,agent,kind,t_s\n"


def table(tmp_path: Path, text: str, head: str = HEAD) -> Path:
    path = tmp_path / "events.csv"
    path.write_text(head + text)
    return path


def test_each_row_gives_an_event(tmp_path):
    found = read_event_table(table(tmp_path, "s1,1,p1,clap,4.5\ns1, 1 ,p2, start_forward ,5\n"))
    assert [(e.session, e.iteration, e.agent, e.kind, e.t_s, e.line) for e in found] == [
        ("s1", 1, "p1", Kind.CLAP, 4.5, 2),
        ("s1", 1, "p2", Kind.START_FORWARD, 5.0, 3),
    ]


def test_columns_may_be_in_any_order_and_others_are_ignored(tmp_path):
    head = "t_s,early,kind,mood,agent,session,iteration\n"
    found = read_event_table(table(tmp_path, "2.5,true,clap,good,p1,s,0\n3,false,clap,bad,p1,s,0\n", head))
    assert [(e.early, e.t_s) for e in found] == [(True, 2.5), (False, 3.0)]


@pytest.mark.parametrize("delimiter", [";", "\t"])
def test_other_separators_allow_decimal_commas(tmp_path, delimiter):
    rows = (HEAD + "s,0,p 1,clap,4.5\n").replace(",", delimiter).replace(".", ",")
    assert [(e.agent, e.t_s) for e in read_event_table(table(tmp_path, rows, ""))] == [("p 1", 4.5)]


def test_a_sessions_cues_give_starts_and_stops(tmp_path):
    cues = [
        Cue("dancer_1", Move.FORWARD, 1, 0, 0.0, 4.0, 2.0),
        Cue("dancer_1", Move.CLAP, 1, 8, 32.0, 8.0, 0.0),
        Cue("dancer_1", Move.TURN, 1, 8, 32.5, 8.25, 1.8),
    ]
    write_rows(tmp_path / "cues.parquet", "cues", cues, {})
    found = read_event_table(tmp_path)
    assert [(e.agent, e.kind, e.t_s, e.line) for e in found] == [
        ("dancer_1", Kind.START_FORWARD, 4.0, 1),
        ("dancer_1", Kind.STOP_FORWARD, 6.0, 1),
        ("dancer_1", Kind.CLAP, 8.0, 2),
        ("dancer_1", Kind.TURN, 8.25, 3),
    ]
    save_csv({tmp_path / "cues.parquet": tmp_path / "cues.csv"})
    assert [(e.kind, e.t_s) for e in read_event_table(tmp_path / "cues.csv")] == [(e.kind, e.t_s) for e in found]


@pytest.mark.parametrize(
    ("row", "message"),
    [
        ("s,1,p1,jump,4", r"line 2, column 'kind': 'jump' is not one of start_forward"),
        ("s,1,p1,clap,soon", r"line 2, column 't_s': 'soon' is not a number of seconds"),
        ("s,1,p1,clap,nan", r"column 't_s': 'nan' is not a number"),
        ("s,-1,p1,clap,4", r"column 'iteration': '-1' is not a whole number, 0 or more"),
        ("s,1.5,p1,clap,4", r"column 'iteration'"),
        ("s,1,,clap,4", r"column 'agent': '' is not a name"),
        ("s,1,p1,clap", r"line 2: 5 values"),
        ("s,1,p1,clap,4,9", r"line 2: 5 values"),
        ("s,1,p1,clap,5\ns,1,p2,clap,1\ns,1,p1,clap,4.5", r"line 4, column 't_s': 4.5 is not at least .* line 2: 5 s"),
        ("s,2,p1,clap,5\ns,1,p1,clap,6", r"line 3, column 'iteration': 1 is not at least .*2 or higher"),
        ("", "holds no events"),
    ],
)
def test_an_invalid_row_is_named_by_file_line_and_column(tmp_path, row, message):
    with pytest.raises(RecordError, match=message) as caught:
        read_event_table(table(tmp_path, row))
    assert "events.csv" in str(caught.value)


def test_early_events_may_be_in_any_order(tmp_path):
    rows = "s,1,p1,clap,5,false\ns,1,p1,clap,4.5,true\n"
    assert len(read_event_table(table(tmp_path, rows, HEAD.strip() + ",early\n"))) == 2
    with pytest.raises(RecordError, match="column 'early': 'perhaps' is not true or false"):
        read_event_table(table(tmp_path, "s,1,p1,clap,5,perhaps\n", HEAD.strip() + ",early\n"))


def test_files_that_are_no_event_table_are_refused(tmp_path):
    with pytest.raises(RecordError, match="lacks the column 'agent'"):
        read_event_table(table(tmp_path, "s,1,clap,4\n", "session,iteration,kind,t_s\n"))
    for name, text, says in (
        ("absent.csv", None, "does not exist"),
        ("broken.parquet", "no parquet", "cannot be read"),
        ("notes.txt", "words", "name a .csv or .parquet file"),
    ):
        if text is not None:
            (tmp_path / name).write_text(text)
        with pytest.raises(RecordError, match=says):
            read_event_table(tmp_path / name)


def test_agents_are_sorted_in_natural_order():
    assert sorted(["p10", "p2", "robot", "p1"], key=natural_order) == ["p1", "p2", "p10", "robot"]
