"""A long session is not silent, whether somebody sits before it or reads it from a pipe."""

import pytest

from sjasim.commands import progress


@pytest.fixture
def clock(monkeypatch):
    """Seconds that pass when the test says so."""
    now = [0.0]
    monkeypatch.setattr(progress.time, "monotonic", lambda: now[0])
    return now


def test_compiling_is_told_at_once_and_then_every_twenty_seconds(clock, capsys):
    with progress.progress_reporter("dancing (sia)") as on_compile:
        for second in range(50):
            clock[0] = float(second)
            on_compile.compiling(second + 1)
        for second in range(50, 91):
            clock[0] = float(second)
            on_compile.dancing((second - 50) / 40)
    assert capsys.readouterr().err.splitlines() == [
        "compiling for this machine, the first time only (1 function)",
        "compiling for this machine, the first time only (21 functions)",
        "compiling for this machine, the first time only (41 functions)",
        "dancing (sia): 25 %",
        "dancing (sia): 75 %",
    ]


def test_a_short_session_says_nothing(clock, capsys):
    with progress.progress_reporter("dancing (sia)") as on_compile:
        for second in range(20):
            clock[0] = float(second)
            on_compile.dancing(second / 20)
    assert capsys.readouterr().err == ""


def test_a_terminal_gets_a_bar(monkeypatch, capsys):
    monkeypatch.setenv("FORCE_COLOR", "1")
    with progress.progress_reporter("dancing (sia)") as on_compile:
        on_compile.compiling(1)
        on_compile.dancing(0.5)
    assert "dancing (sia)" in capsys.readouterr().err
