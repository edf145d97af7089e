"""``python -m sjasim.power``: the number of groups that a study needs."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

from .commands.flags import INLINE, Metavar
from .commands.main import main
from .commands.options import parse
from .studies import power as study

ABOUT = "Compute how many groups a study needs to find a difference between two methods, by simulation."


@dataclass(frozen=True)
class Options:
    """Options of this command.

    Attributes:
        design: what is compared.
        study: folder of a study whose groups are used; without it groups are simulated.
        jobs: number of processes; 0 for one per core.
        out: folder to write power.json to; the folder of a study is one, and its report then shows the power.
        overwrite: replace an earlier report.
        json: print power.json on stdout, and nothing else.
        config: TOML file with the common configuration of the sessions.
    """

    design: Annotated[study.PowerDesign, INLINE] = field(default_factory=study.PowerDesign)
    study: Annotated[Path | None, Metavar("DIR")] = None
    jobs: int = 0
    out: Annotated[Path | None, Metavar("DIR")] = None
    overwrite: bool = False
    json: bool = False
    config: Annotated[Path | None, Metavar("FILE.toml")] = None


def command(arguments: Sequence[str], program: str = "python -m sjasim.power") -> None:
    """Simulate the groups, write the report if a folder is named, and print it."""
    options = parse(Options, arguments, None, program, ABOUT)
    if options.out is not None:
        study.check_folder(options.out, options.overwrite)
    report = study.power(options.design, options.study, options.config, options.jobs)
    if options.out is not None:
        study.save_power(report, options.out)
        sys.stderr.write(f"report written to {options.out}\n")
    if options.json:
        sys.stdout.write(study.as_json(report))
    else:
        study.print_power(report)


if __name__ == "__main__":
    sys.exit(main(command))
