"""Former flags are replaced by their present names, each with one warning line."""

import pytest

from sjasim.commands.former_flags import present_flags


def warned(capsys):
    """Former and present names of the warnings on stderr."""
    lines = capsys.readouterr().err.splitlines()
    assert all(line.startswith("warning: ") and line.endswith(" until sjasim 0.3") for line in lines)
    return [tuple(line.removeprefix("warning: ").partition(";")[0].split(" is now called ")) for line in lines]


def test_former_names_are_replaced(capsys):
    given = ["--group", "5", "--room.side-m=1.5", "--network.loss", "0.1", "--seed", "3", "--group", "4"]
    assert present_flags(given) == [
        "--dancers", "5", "--scene.side-m=1.5", "--network.packet-loss", "0.1", "--seed", "3", "--dancers", "4",
    ]  # fmt: skip
    assert warned(capsys) == [
        ("--group", "--dancers"),
        ("--room.side-m", "--scene.side-m"),
        ("--network.loss", "--network.packet-loss"),
    ]


@pytest.mark.parametrize(
    ("former", "present"),
    [("tau-s", "--synchrony.tau-s"), ("effective-from", "--method-options.first-followed-iteration")],
)
def test_former_options_of_sia_are_replaced(former, present, capsys):
    flag = f"--method-options.{former}"
    assert present_flags([flag, "1"], "sia") == [present, "1"]
    assert warned(capsys) == [(flag, present)]
    assert present_flags([flag, "1"], "my:Own") == [flag, "1"]
    assert warned(capsys) == []


def test_pairs_of_name_and_value_become_flags(capsys):
    given = ["--method-options", "window_s", "1.5", "tau_s", "0.3", "--seed", "1"]
    assert present_flags(given, "sia") == ["--method-options.window-s=1.5", "--synchrony.tau-s=0.3", "--seed", "1"]
    assert warned(capsys) == [
        ("--method-options window_s", "--method-options.window-s"),
        ("--method-options tau_s", "--synchrony.tau-s"),
    ]
