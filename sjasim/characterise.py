"""``python -m sjasim.characterise``: measures the accuracy of the joints, the detectors and the robot."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

from .commands.flags import INLINE, Metavar
from .commands.main import main
from .commands.session_options import parse_session
from .config import SessionConfig
from .record.atomic_folder import check_target
from .studies import characterisation as study

ABOUT = "Measure how well joints are tracked, events detected and commands executed, over several sessions."

FIRST = ("sessions", "layouts", "sensings", "method", "humans", "seed", "dancers", "out")
OMITTED = ("layout", "sensing")  # --layouts and --sensings replace them


@dataclass(frozen=True)
class Options:
    """Options of this command.

    Attributes:
        session: what all sessions have in common.
        design: which sessions are simulated.
        out: folder to write characterise.json and report.html to; it must be new or empty.
        overwrite: replace an earlier report.
        json: print characterise.json on stdout, and nothing else.
        config: TOML file with fields of the sessions' configuration; flags override it.
    """

    session: Annotated[SessionConfig, INLINE]
    design: Annotated[study.Design, INLINE] = field(default_factory=study.Design)
    out: Annotated[Path | None, Metavar("DIR")] = None
    overwrite: bool = False
    json: bool = False
    config: Annotated[Path | None, Metavar("FILE.toml")] = None


def command(arguments: Sequence[str], program: str = "python -m sjasim.characterise") -> None:
    """Simulate the sessions, write the report if a folder is named, and print it."""
    options = parse_session(Options, arguments, program, ABOUT, FIRST, OMITTED)
    configs = study.checked_configs(options.design, options.session)
    if options.out is not None:
        check_target(options.out, options.overwrite, holds=study.FILE)
    report = study.characterise(configs)
    if options.out is not None:
        study.save_report(report, options.out, options.overwrite)
        sys.stderr.write(f"report written to {options.out}\n")
    study.print_report(report, options.json)


if __name__ == "__main__":
    sys.exit(main(command))
