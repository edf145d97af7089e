"""The table of a session says what a newcomer asks first, and fits 80 columns."""

import dataclasses
import io

import pytest
from rich.console import Console

from sjasim.analysis.session_metrics import measures
from sjasim.commands.result_table import print_session, session_title
from sjasim.config import DanceConfig, SessionConfig
from sjasim.config.toml_file import to_plain
from sjasim.core.session_log import Followed


def printed(log):
    """Lines of the table of a log on a terminal of 80 columns, and the cells of each iteration."""
    stream = io.StringIO()
    print_session(measures(log).as_dict(), Console(file=stream, width=80))
    lines = [line.rstrip() for line in stream.getvalue().splitlines()]
    return lines, [line.split() for line in lines if line.lstrip()[:2] in {f"{index} " for index in range(1, 5)}]


def test_the_table_says_whom_the_robot_followed_and_how_late_it_was(make_session_log):
    log = make_session_log(method="sia", spread_s=0.0, late_s=(0.3, 0.0, 0.0), joints=False)
    lines, rows = printed(dataclasses.replace(log, followed=(Followed(1, ""), Followed(2, "dancer_1"))))

    heading = [" ".join(line.split()) for line in lines[:6]]
    assert "full true robot late TA steps" in heading
    assert "iteration GSI edges onsets MSP followed [s] [s] missed" in heading
    # The robot answers dancer_1, .2 s behind the mean, with a lag of .18 s.
    assert [row[5:] for row in rows] == [["nobody", "+0.38", "0.38", "0"], ["dancer_1", "+0.38", "0.38", "0"]]
    assert next(line for line in lines if line.startswith("net latency:")).endswith("triggered the step (n = 9):")


def test_a_robot_ahead_of_the_dancers_has_a_negative_lateness(make_session_log):
    log = make_session_log(method="eca", spread_s=0.0, late_s=(-0.6, 0.0, 0.0), joints=False)
    lines, rows = printed(log)
    assert [row[5:8] for row in rows] == [["everyone", "-0.22", "0.22"]] * 2
    assert any("behind (+) or ahead of (-) the dancers' mean" in line for line in lines)
    assert not any(line.startswith("net latency") for line in lines)


def test_shares_have_their_counts(make_session_log):
    log = make_session_log(joints=False)
    lines, _ = printed(dataclasses.replace(log, events=log.events[1:], commands=log.commands[1:]))
    assert any("recall 0.988 (80 of 81) in sight, 0.988 (80 of 81) in all," in line for line in lines)
    assert any("precision 1.000 (80 of 80), 95 % of times within" in line for line in lines)
    assert any("17 of 17 commands executed, 0 steps missed" in line for line in lines)


@pytest.mark.parametrize("method", ["sia", "eca", "none"])
def test_every_line_fits_80_columns(make_session_log, method):
    log = make_session_log(method=method, iterations=4, late_s=(0.0,) * 3, robot=method != "none", joints=False)
    notice = dataclasses.replace(log.notices[0], what="a long explanation of what went wrong " * 5)
    lines, rows = printed(dataclasses.replace(log, notices=(notice,)))
    assert max(map(len, lines)) <= 80
    assert len(rows) == 4
    assert all(("…" not in line) for line in lines)


def test_the_event_level_world_has_no_lines_of_bodies_and_places(make_session_log):
    log = make_session_log(joints=False)
    lines, _ = printed(dataclasses.replace(log, truth={}, odometry={}))
    assert not any(line.startswith("bodies:") for line in lines)
    assert next(line for line in lines if line.startswith("robot:")).endswith("0 steps missed")
    lines, _ = printed(log)
    assert next(line for line in lines if line.startswith("robot:")).endswith(" m off at the end")
    assert any(line.startswith("bodies:") for line in lines)


def test_a_humans_only_session_has_dashes_for_the_robot(make_session_log):
    lines, rows = printed(make_session_log(method="none", robot=False, iterations=1, joints=False))
    assert rows[0][5:] == ["-"] * 4
    assert not any(line.startswith(("robot:", "net latency:", "late:")) for line in lines)


def test_the_title_says_what_is_unusual():
    usual = {"method": "eca", "seed": 1, "humans": "novices"}
    config = SessionConfig(sensing="joints", dancers=5, layout="rows", dance=DanceConfig(name="march"))
    assert session_title({**usual, "config": to_plain(SessionConfig())}) == "eca, seed 1, novices dancers"
    assert session_title({**usual, "config": to_plain(config)}) == (
        "eca, seed 1, novices dancers, march, sensing joints, layout rows, dancers 5"
    )
