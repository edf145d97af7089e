"""``python -m sjasim.calibrate``: fits the human timing model to recorded groups."""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

import tyro

from .analysis.calibration.fit_report import FitConfig, fit_as_dict, fit_recordings, fit_rows, fit_title, save_fit
from .commands.flags import INLINE, Metavar
from .commands.main import main
from .commands.options import parse
from .commands.tables import print_table
from .record.atomic_folder import check_file

ABOUT = "Fit the coupling and the noise of the human timing model to event tables or folders of sessions."


@dataclass(frozen=True)
class Options:
    """Options of this command.

    Attributes:
        paths: event tables (.csv, .parquet) or folders of sessions.
        out: file to write the fit to; `sjasim run --humans FILE.toml` reads it.
        fit: what is fitted.
        overwrite: replace an earlier file.
        json: print the fit as JSON on stdout, and nothing else.
    """

    paths: Annotated[tyro.conf.Positional[tuple[Path, ...]], Metavar("PATH ...")]
    out: Annotated[Path | None, Metavar("FILE.toml")] = None
    fit: Annotated[FitConfig, INLINE] = field(default_factory=FitConfig)
    overwrite: bool = False
    json: bool = False


def command(arguments: Sequence[str], program: str = "python -m sjasim.calibrate") -> None:
    """Fit the model, print the fit, and write it if a file is named."""
    options = parse(Options, arguments, None, program, ABOUT)
    if options.out is not None:
        check_file(options.out, options.overwrite)
    fit, warnings = fit_recordings(options.paths, options.fit)
    if options.json:
        sys.stdout.write(json.dumps(fit_as_dict(fit), allow_nan=False) + "\n")
    else:
        sys.stdout.write(f"{fit_title(fit)}\n")
        print_table(("parameter", "fitted", "95 % interval"), fit_rows(fit))
    sys.stderr.writelines(f"{line}\n" for line in warnings)
    if options.out is not None:
        save_fit(fit, options.out)


if __name__ == "__main__":
    sys.exit(main(command))
