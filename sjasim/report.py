"""``python -m sjasim.report``: writes one HTML page about a study, a session, a reproduction or a characterisation."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from .commands.flags import Metavar
from .commands.main import main
from .commands.options import parse

ABOUT = "Write one HTML page about the folder of a study, a session, a reproduction or a characterisation."


@dataclass(frozen=True)
class Options:
    """Options of this command.

    Attributes:
        folder: the folder to report on.
        out: file to write; by default report.html in the folder.
        overwrite: replace an earlier page.
    """

    folder: Annotated[tyro.conf.Positional[Path], Metavar("DIR")]
    out: Annotated[Path | None, Metavar("FILE.html")] = None
    overwrite: bool = False


def command(arguments: Sequence[str], program: str = "python -m sjasim.report") -> None:
    """Write the page, and print where it is."""
    options = parse(Options, arguments, None, program, ABOUT)
    from .studies.report.folders import write_report

    sys.stdout.write(f"{write_report(options.folder, options.out, options.overwrite)}\n")


if __name__ == "__main__":
    sys.exit(main(command))
