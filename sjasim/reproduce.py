"""``python -m sjasim.reproduce``: simulates a published study and compares its values with people's."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Literal

import tyro

from .commands.flags import INLINE, Metavar
from .commands.main import main
from .commands.options import parse
from .record.atomic_folder import check_target
from .studies.reproduction import reproduce
from .studies.reproduction_options import ReproductionOptions
from .studies.reproduction_report import FILE

ABOUT = "Simulate a published study many times, and compare its values with those that people produced."


@dataclass(frozen=True)
class Options:
    """Options of this command.

    Attributes:
        study: paper: the study of Iqbal, Rack and Riek; ashle: tasks that show people's pull to their spontaneous
            tempo; quartet: string players with an assigned leader.
        data: folder with the onsets of the quartet, which you fetch yourself.
        simulated: what is simulated.
        out: folder to write reproduce.json to; it must be new or empty.
        overwrite: replace an earlier report.
        json: print reproduce.json on stdout, and nothing else.
    """

    study: Annotated[tyro.conf.Positional[Literal["paper", "ashle", "quartet"]], Metavar("STUDY")] = "paper"
    data: Annotated[Path | None, Metavar("DIR")] = None
    simulated: Annotated[ReproductionOptions, INLINE] = field(default_factory=ReproductionOptions)
    out: Annotated[Path | None, Metavar("DIR")] = None
    overwrite: bool = False
    json: bool = False


def command(arguments: Sequence[str], program: str = "python -m sjasim.reproduce") -> None:
    """Simulate the study, print its values beside people's, and write them if a folder is named."""
    options = parse(Options, arguments, None, program, ABOUT)
    if options.out is not None:
        check_target(options.out, options.overwrite, holds=FILE)
    found = reproduce(options.study, options.simulated, options.data)
    found.print(options.json)
    if options.out is not None:
        found.save(options.out, options.overwrite)
        sys.stderr.write(f"report written to {options.out}\n")


if __name__ == "__main__":
    sys.exit(main(command))
