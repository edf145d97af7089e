"""Progress of a session on a terminal and in a pipe."""

import pytest

from sjasim.commands import progress


@pytest.fixture
def clock(monkeypatch):
    """Seconds that pass when the test says so."""
    now = [0.0]
    monkeypatch.setattr(progress.time, "monotonic", lambda: now[0])
    return now


def test_a_line_is_printed_at_once_and_then_every_twenty_seconds(clock, capsys):
    with progress.progress_reporter("simulating (sia)") as reporter:
        for second in range(50):
            clock[0] = float(second)
            reporter.compiling(second + 1)
        for second in range(50, 91):
            clock[0] = float(second)
            reporter.simulating((second - 50) / 40)
    assert capsys.readouterr().err.splitlines() == [
        "compiling for this machine, the first time only (1 function)",
        "compiling for this machine, the first time only (21 functions)",
        "compiling for this machine, the first time only (41 functions)",
        "simulating (sia): 25 %",
        "simulating (sia): 75 %",
    ]


def test_a_short_session_prints_nothing(clock, capsys):
    with progress.progress_reporter("simulating (sia)") as reporter:
        for second in range(20):
            clock[0] = float(second)
            reporter.simulating(second / 20)
    assert capsys.readouterr().err == ""


def test_a_terminal_shows_a_bar(monkeypatch, capsys):
    monkeypatch.setenv("FORCE_COLOR", "1")
    with progress.progress_reporter("simulating (sia)") as reporter:
        reporter.compiling(1)
        reporter.simulating(0.5)
    assert "simulating (sia)" in capsys.readouterr().err
