"""All commands, in the order in which somebody new needs them."""

from __future__ import annotations

import difflib

COMMANDS = {
    "run": "simulate one session and print its figures",
    "study": "simulate many groups and compare methods",
    "view": "show a recorded session in the rerun viewer",
    "report": "write one HTML page about a study, a session or another result",
    "export": "write a recorded session as ROS 2 messages (MCAP) or CSV tables",
    "detect": "detect events in recorded joints",
    "calibrate": "fit the human timing model to recorded groups",
    "characterise": "measure the accuracy of the detectors and of the robot",
    "reproduce": "simulate a published study and compare its values with people's",
    "power": "compute how many groups a study needs",
    "benchmark": "measure the computing time of sessions and environments",
}
"""Name -> what the command does, in one line. ``sjasim NAME`` is ``python -m sjasim.NAME``."""


def overview(program: str) -> str:
    """The help of the console script: all commands, one line each.

    Args:
        program: what the user typed for the script.
    """
    width = max(map(len, COMMANDS)) + 2
    return "\n".join(
        [
            f"usage: {program} [-h] [--version] COMMAND ...",
            "",
            "Simulate groups of dancers and a robot, and analyse what they did.",
            "",
            "commands:",
            *(f"  {name:<{width}}{about}" for name, about in COMMANDS.items()),
            "",
            f"Options of a command: {program} COMMAND --help",
            "",
        ]
    )


def unknown_command(name: str, program: str) -> str:
    """One line for a command that does not exist, with the closest one that does.

    Args:
        name: what the user typed for the command; "" for nothing.
        program: what the user typed for the script.
    """
    close = difflib.get_close_matches(name, COMMANDS, n=1)
    hint = f"; did you mean {close[0]}?" if close else ""
    what = f"no command named {name!r}{hint}" if name else "no command given"
    return f"error: {what} (see {program} --help)\n"
