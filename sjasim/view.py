"""``python -m sjasim.view``: shows a recorded session in rerun, or two on one time axis, or saves a picture."""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from .commands.flags import Metavar
from .commands.main import main
from .commands.options import parse
from .core.errors import ConfigError

ABOUT = "Show a recorded session in the rerun viewer, or two sessions side by side on one time axis."


@dataclass(frozen=True)
class Options:
    """Options of this command.

    Attributes:
        folder: the session's folder.
        other: folder of a second session, to compare.
        screenshot: write a picture of the viewer to this file instead of opening a window; needs no display.
        at: session time that the picture shows [s]; by default amid the last iteration but one.
        overwrite: replace an earlier picture.
        bind: address that the viewer listens on.
    """

    folder: Annotated[tyro.conf.Positional[Path], Metavar("DIR")]
    other: Annotated[tyro.conf.Positional[Path | None], Metavar("[DIR]")] = None
    screenshot: Annotated[Path | None, Metavar("FILE.png")] = None
    at: float | None = None
    overwrite: bool = False
    bind: str = "127.0.0.1"


def command(arguments: Sequence[str], program: str = "python -m sjasim.view") -> None:
    """Check the folders, then open the viewer or save the picture."""
    options = parse(Options, arguments, None, program, ABOUT)
    if options.at is not None and options.screenshot is None:
        raise ConfigError("at", options.at, "only with --screenshot FILE.png")
    folders = [options.folder, *([options.other] if options.other else [])]
    from .analysis.viewing import open_viewer, save_picture

    with tempfile.TemporaryDirectory(prefix="sjasim-") as temporary:
        if options.screenshot is None:
            open_viewer(folders, Path(temporary), options.bind)
        else:
            save_picture(folders, Path(temporary), options.screenshot, options.at, options.overwrite)


if __name__ == "__main__":
    sys.exit(main(command))
