"""``sjasim COMMAND ...`` and ``python -m sjasim COMMAND ...``: runs a command, or lists all of them."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Sequence
from functools import partial
from pathlib import Path

from . import __version__
from .commands.command_list import COMMANDS, overview, unknown_command


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command that the first argument names, and return its exit code.

    Args:
        arguments: the command line without the program's name; that of the process if None.
    """
    words = list(sys.argv[1:] if arguments is None else arguments)
    program = "python -m sjasim" if Path(sys.argv[0]).name == "__main__.py" else "sjasim"
    name = words[0] if words else ""

    if name in ("-h", "--help", "help"):
        sys.stdout.write(overview(program))
        return 0
    if name == "--version":
        sys.stdout.write(f"sjasim {__version__}\n")
        return 0
    if name not in COMMANDS:
        sys.stderr.write(unknown_command(name, program))
        return 2

    # Imported only now: --help and --version need neither numpy nor tyro.
    run = importlib.import_module(".commands.main", __package__).main
    face = importlib.import_module(f".{name.replace('-', '_')}", __package__)
    return int(run(partial(face.command, program=f"{program} {name}"), words[1:]))


if __name__ == "__main__":
    sys.exit(main())
