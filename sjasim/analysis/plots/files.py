"""Writes the figures of one session, or of several that are compared, as pictures."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ...core.errors import RecordError
from ...core.session_log import SessionLog
from ...record.rerun.explanation import DelayReport
from .delays import delays_figure
from .graphs import graphs_figure
from .raster import raster_figure
from .timing import timing_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FILES = ("raster.png", "timing.png", "graph.png", "delays.png")
"""Names of the files that `save_plots` may write for one session."""

Sessions = Mapping[str, tuple[SessionLog, DelayReport]]
"""Label of a session, such as its method and seed -> its log, and its report from `delay_breakdown.delay_report`."""


def check_plots(folder: Path, overwrite: bool) -> None:
    """Check that figures can be drawn and written without losing earlier ones.

    Args:
        folder: the folder to write into.
        overwrite: whether earlier figures may be replaced.

    Raises:
        RecordError: matplotlib is missing, the path is a file, or the folder holds figures already.
    """
    try:
        import matplotlib  # noqa: F401
    except ImportError:
        raise RecordError("plots need matplotlib: pip install matplotlib") from None

    if folder.exists() and not folder.is_dir():
        raise RecordError(f"{folder} is a file: name a folder")
    existing = sorted(path for name in FILES for path in folder.glob(f"*{name}"))
    if existing and not overwrite:
        raise RecordError(f"{existing[0]} exists: name another folder, or allow it with --overwrite")


def save_plots(sessions: Sessions, folder: Path, overwrite: bool = False) -> list[Path]:
    """Write every figure for which there are data.

    Timing is drawn in one figure, with the sessions laid over one another. The other figures show one session each; if
    there are several sessions, their names begin with the session's label.

    Args:
        sessions: one or several sessions.
        folder: the folder to write into; it is created if absent.
        overwrite: whether earlier figures may be replaced.

    Returns:
        The files; a humans-only session has neither timing nor delays.

    Raises:
        RecordError: as in `check_plots`, or the folder cannot be written.
    """
    check_plots(folder, overwrite)

    figures: dict[str, Figure] = {}
    for label, (log, report) in sessions.items():
        prefix = f"{label}-" if len(sessions) > 1 else ""
        figures[f"{prefix}raster.png"] = raster_figure(log)
        figures[f"{prefix}graph.png"] = graphs_figure(report.graphs)
        if any(np.isfinite(step.late_s) for step in report.steps):
            figures[f"{prefix}delays.png"] = delays_figure(report)

    timing_s = {label: [value for _, value in report.ta] for label, (_, report) in sessions.items() if report.ta}
    if timing_s:
        figures["timing.png"] = timing_figure(timing_s)

    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, figure in figures.items():
            figure.savefig(folder / name, dpi=140)
    except OSError as error:
        raise RecordError(f"{folder} cannot be written: {error.strerror or error}") from None
    return [folder / name for name in figures]
