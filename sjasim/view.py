"""``python -m sjasim.view``: shows a recorded session in rerun, or two side by side, or saves pictures."""

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
from .core.errors import ConfigError

ABOUT = "Show a recorded session in the rerun viewer, or two sessions side by side on one time axis."


@dataclass(frozen=True)
class Options:
    """Options of this command.

    Attributes:
        folder: the session's folder.
        other: folder of a second session, to compare.
        screenshot: write a picture of the viewer to this file instead of opening a window; needs no display.
        plots: write the figures to this folder as pictures instead of opening a window.
        at: session time that the picture shows [s]; by default amid the last iteration but one.
        overwrite: replace earlier pictures.
        bind: address that the viewer listens on.
    """

    folder: Annotated[tyro.conf.Positional[Path], Metavar("DIR")]
    other: Annotated[tyro.conf.Positional[Path | None], Metavar("[DIR]")] = None
    screenshot: Annotated[Path | None, Metavar("FILE.png")] = None
    plots: Annotated[Path | None, Metavar("DIR")] = None
    at: float | None = None
    overwrite: bool = False
    bind: str = "127.0.0.1"


def command(arguments: Sequence[str], program: str = "python -m sjasim.view") -> None:
    """Check the folders, then open the viewer or save the pictures."""
    options = parse(Options, arguments, None, program, ABOUT)
    if options.at is not None and options.screenshot is None:
        raise ConfigError("at", options.at, "only with --screenshot FILE.png")
    from .analysis.viewing import open_viewer, save_pictures

    folders = [folder for folder in (options.folder, options.other) if folder is not None]
    if options.screenshot is None and options.plots is None:
        open_viewer(folders, options.bind)
    else:
        save_pictures(folders, options.screenshot, options.at, options.plots, options.overwrite)


if __name__ == "__main__":
    sys.exit(main(command))
