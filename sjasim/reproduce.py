"""``python -m sjasim.reproduce``: simulates a published study and compares its values with people's."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import tyro

from .commands.flags import Metavar
from .commands.main import main
from .commands.options import parse
from .commands.progress import progress_reporter
from .record.atomic_folder import check_target
from .studies import reproduction_report as report
from .studies.second_studies import reproduce

ABOUT = "Simulate a published study many times, and compare its values with those that people produced."


@dataclass(frozen=True)
class Options:
    """Options of this command.

    Attributes:
        study: ashle: tasks that show people's pull to their spontaneous tempo.
        studies: number of simulated studies.
        seed: seed of all random numbers.
        out: folder to write reproduce.json to; it must be new or empty.
        overwrite: replace an earlier report.
        json: print reproduce.json on stdout, and nothing else.
    """

    study: Annotated[tyro.conf.Positional[Literal["ashle"]], Metavar("STUDY")]
    studies: int = 1000
    seed: int = 0
    out: Annotated[Path | None, Metavar("DIR")] = None
    overwrite: bool = False
    json: bool = False


def command(arguments: Sequence[str], program: str = "python -m sjasim.reproduce") -> None:
    """Simulate the study, print its values beside people's, and write them if a folder is named."""
    options = parse(Options, arguments, None, program, ABOUT)
    if options.out is not None:
        check_target(options.out, options.overwrite, holds=report.FILE)
    with progress_reporter("simulating") as progress:
        found = reproduce(options.study, options.studies, options.seed, progress.simulating)
    report.print_report(found, options.json)
    if options.out is not None:
        report.save_report(found, options.out, options.overwrite)
        sys.stderr.write(f"report written to {options.out}\n")


if __name__ == "__main__":
    sys.exit(main(command))
