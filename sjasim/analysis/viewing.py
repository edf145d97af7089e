"""Shows one or two recorded sessions in the rerun viewer, or saves a picture of the viewer, or figures."""

from __future__ import annotations

import contextlib
import sys
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

from ..choreography.timetable import timetable
from ..config import SessionConfig
from ..config.toml_file import from_plain
from ..core.errors import ConfigError, RecordError
from ..record.atomic_folder import check_file
from ..record.session_folder import read, read_summary

PICTURE_BEAT = 25.0
"""Beat of an iteration that a picture shows unless a time is given: all four move between their slots then."""


def open_viewer(folders: Sequence[Path], bind: str) -> None:
    """Open the viewer, and wait until the user closes it.

    Args:
        folders: one or two sessions' folders.
        bind: address that the viewer listens on.

    Raises:
        RecordError: a folder is not a session's, a recording is damaged, or there is no display.
    """
    read_configs(folders)  # refuses what is no session's folder before a missing display is reported
    from ..record.rerun.viewer import check_display, start

    check_display("a picture needs none: --screenshot FILE.png")
    with _temporary_folder() as temporary:
        process, _ = start(viewable_recording(folders, temporary), bind=bind)
        sys.stderr.write("close the viewer, or press Ctrl-C, to end\n")
        try:
            process.wait()
        finally:
            process.terminate()


def save_pictures(
    folders: Sequence[Path], screenshot: Path | None, time_s: float | None, plots: Path | None, overwrite: bool
) -> None:
    """Save a picture of the viewer, or the figures, or both; see `save_picture` and `save_figures`."""
    if plots is not None:
        save_figures(folders, plots, overwrite)
    if screenshot is not None:
        save_picture(folders, screenshot, time_s, overwrite)


def save_picture(folders: Sequence[Path], picture: Path, time_s: float | None, overwrite: bool) -> None:
    """Save a picture of the viewer; it needs no display.

    Args:
        folders: one or two sessions' folders.
        picture: .png file to write.
        time_s: session time to show; None for `picture_time_s` of the first session [s].
        overwrite: whether an earlier picture may be replaced.

    Raises:
        RecordError: a folder is not a session's, a recording is damaged, or the picture cannot be written.
        ConfigError: the time is not in any of the sessions.
    """
    configs = read_configs(folders)
    if time_s is None:
        time_s = picture_time_s(configs[0])
    else:
        check_picture_time(time_s, configs)
    check_file(picture, overwrite)

    from ..record.rerun.viewer import screenshot

    with _temporary_folder() as temporary:
        for report in screenshot(viewable_recording(folders, temporary), picture, time_s):
            sys.stderr.write(f"{report}\n")
    sys.stderr.write(f"picture written to {picture}\n")


def save_figures(folders: Sequence[Path], target: Path, overwrite: bool) -> None:
    """Save the figures of one or two sessions.

    Args:
        folders: the sessions' folders.
        target: folder to write into.
        overwrite: whether earlier figures may be replaced.

    Raises:
        RecordError: a folder is not a session's, or the figures cannot be written.
    """
    from .delay_breakdown import delay_report
    from .plots.files import check_plots, save_plots

    check_plots(target, overwrite)
    logs = [read(folder) for folder in folders]
    labels = session_labels([from_plain(log.config) for log in logs])
    sessions = {label: (log, delay_report(log)) for label, log in zip(labels, logs, strict=True)}
    names = ", ".join(path.name for path in save_plots(sessions, target, overwrite))
    sys.stderr.write(f"plots written to {target}: {names}\n")


def read_configs(folders: Sequence[Path]) -> list[SessionConfig]:
    """Configurations of sessions' folders.

    Raises:
        RecordError: a folder is not a session's.
    """
    return [from_plain(read_summary(folder)["config"]) for folder in folders]


def check_picture_time(time_s: float, configs: Sequence[SessionConfig]) -> None:
    """Refuse a time at which no session goes on.

    Raises:
        ConfigError: the time is not in any of the sessions.
    """
    end_s = max(timetable(config).end_s() + config.dance.tail_s for config in configs)
    if not 0.0 <= time_s <= end_s:
        raise ConfigError("at", time_s, f"a session time from 0 to {end_s:.1f} s")


def picture_time_s(config: SessionConfig) -> float:
    """Session time that a picture shows unless another is given: amid the last iteration but one [s]."""
    table = timetable(config)
    return table.time_s(max(1, table.last - 1), PICTURE_BEAT)


def viewable_recording(folders: Sequence[Path], temporary: Path) -> Path:
    """The recording to open: that of the session's folder, or a new one.

    A folder without a recording gets one from its tables, without joints. Two sessions get one on a common time axis.

    Args:
        folders: one or two sessions' folders.
        temporary: folder for a new recording.

    Raises:
        RecordError: a folder is not a session's, or a recording is damaged.
    """
    from ..record.rerun.recording import save_all
    from ..record.rerun.rrd_reader import RECORDING, read_chunks, read_with_joints
    from .delay_breakdown import delay_report

    stored = folders[0] / RECORDING
    if len(folders) == 1 and stored.exists():
        if not any(True for _ in read_chunks(stored)):
            raise RecordError(f"{stored} cannot be read: it is empty")
        return stored

    logs = [read_with_joints(folder) for folder in folders]
    prefixes = session_labels(read_configs(folders)) if len(folders) > 1 else [""]
    new = temporary / RECORDING
    save_all({prefix: (log, delay_report(log)) for prefix, log in zip(prefixes, logs, strict=True)}, new)
    return new


@contextlib.contextmanager
def _temporary_folder() -> Iterator[Path]:
    """Give a folder that is removed at the end of the block."""
    with tempfile.TemporaryDirectory(prefix="sjasim-") as folder:
        yield Path(folder)


def session_labels(configs: Sequence[SessionConfig]) -> list[str]:
    """Short names of sessions that are shown together: method and seed, with a letter before them if they are equal."""
    names = [f"{config.method}-{config.seed}" for config in configs]
    if len(set(names)) < len(names):
        names = [f"{letter}-{name}" for letter, name in zip("AB", names, strict=False)]
    return names
