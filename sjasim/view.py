"""``python -m sjasim.view``: a session in rerun, two sessions on one time axis, or a picture of the viewer."""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import tyro

from .choreography.timetable import timetable
from .commands.options import main, parse
from .config.toml_file import from_plain
from .core.errors import ConfigError, RecordError
from .record.atomic_folder import check_file

ABOUT = "Open a session's folder in rerun's viewer; two folders stand side by side on one time axis."


@dataclass(frozen=True)
class Options:
    """Look at a session.

    Attributes:
        folder: the session's folder.
        other: a second one, to compare.
        screenshot: write a picture of the viewer here instead of opening a window; needs no display.
        at: session time that the picture shows [s]; by default amid the last iteration but one.
        overwrite: replace the picture if it exists.
        bind: address that the viewer listens on.
    """

    folder: tyro.conf.Positional[Path]
    other: tyro.conf.Positional[Path | None] = None
    screenshot: Path | None = None
    at: float | None = None
    overwrite: bool = False
    bind: str = "127.0.0.1"


def command(arguments: Sequence[str]) -> None:
    """Check the folders, then open the viewer or take the picture."""
    from .record.session_folder import read_summary

    options = parse(Options, arguments, None, "python -m sjasim.view", ABOUT)
    picture = options.screenshot
    folders = [options.folder, *([options.other] if options.other else [])]
    check_moment(options, [read_summary(folder) for folder in folders])
    if picture is None:
        from .record.rerun.viewer import check_display

        check_display("a picture needs none: --screenshot FILE.png")
    else:
        check_file(picture, options.overwrite)
    with tempfile.TemporaryDirectory(prefix="sjasim-") as place:
        recording, moment = prepared(folders, Path(place))
        if picture is None:
            _open(recording, options.bind)
            return
        from .record.rerun.viewer import screenshot

        for report in screenshot(recording, picture, moment if options.at is None else options.at):
            sys.stderr.write(f"{report}\n")
        sys.stderr.write(f"picture in {picture}\n")


def check_moment(options: Options, summaries: Sequence[Mapping[str, Any]]) -> None:
    """Make sure that there is something to see at the time asked for.

    Raises:
        ConfigError: no picture is asked for, or the time is not in any of the sessions.
    """
    if options.at is None:
        return
    if options.screenshot is None:
        raise ConfigError("at", options.at, "only with --screenshot FILE.png")
    configs = [from_plain(summary["config"]) for summary in summaries]
    end_s = max(timetable(config).end_s() + config.dance.tail_s for config in configs)
    if not 0.0 <= options.at <= end_s:
        raise ConfigError("at", options.at, f"a session time from 0 to {end_s:.1f} s")


def prepared(folders: Sequence[Path], place: Path) -> tuple[Path, float]:
    """The recording to open, and a session time worth showing.

    A folder without a recording gets one from its tables, without joints.

    Args:
        folders: one or two sessions' folders.
        place: where recordings may be written to.

    Raises:
        RecordError: a folder is not a session's, or a recording is damaged.
    """
    from .analysis.delay_breakdown import delay_report
    from .record.rerun.recording import save_all
    from .record.rerun.rrd_reader import RECORDING, read_chunks, read_with_joints
    from .record.session_folder import read_summary

    configs = [from_plain(read_summary(folder)["config"]) for folder in folders]
    table = timetable(configs[0])
    moment = table.time_s(max(1, table.last - 1), 25.0)
    stored = folders[0] / RECORDING
    if len(folders) == 1 and stored.exists():
        if not any(True for _ in read_chunks(stored)):
            raise RecordError(f"{stored} cannot be read: it holds nothing")
        return stored, moment
    logs = [read_with_joints(folder) for folder in folders]
    names = [f"{config.method}-{config.seed}" for config in configs]
    if len(set(names)) < len(names):
        names = [f"{letter}-{name}" for letter, name in zip("AB", names, strict=False)]
    prefixes = names if len(names) > 1 else [""]
    save_all({prefix: (log, delay_report(log)) for prefix, log in zip(prefixes, logs, strict=True)}, place / RECORDING)
    return place / RECORDING, moment


def _open(recording: Path, bind: str) -> None:
    from .record.rerun.viewer import start

    process, _ = start(recording, bind=bind)
    sys.stderr.write("close the viewer, or press Ctrl-C, to end\n")
    try:
        process.wait()
    finally:
        process.terminate()


if __name__ == "__main__":
    sys.exit(main(command))
