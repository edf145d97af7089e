"""Runs one session, and keeps or shows what was asked for."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from ..commands.flags import Metavar
from ..commands.progress import progress_reporter
from ..config import HUMANS_ONLY, SessionConfig
from ..core.errors import ConfigError
from ..core.session_log import SessionLog
from ..simulation.session_observers import SessionObservers

if TYPE_CHECKING:
    from ..record.rerun.explanation import DelayReport


@dataclass(frozen=True)
class SessionOutputs:
    """What is kept or shown of a session.

    Attributes:
        out: folder to write the session to; it must be new or empty.
        view: show the session in the rerun viewer while it is simulated.
        video: write a video with captions to this .mp4 file. Rendering takes longer than the session itself on a
            computer without a graphics card.
        plots: folder to write the figures to as pictures.
        log_depth: keep depth images of the active sensor, 5 a second, in the recording; needs --out.
        overwrite: replace an earlier session, video or picture.
    """

    out: Annotated[Path | None, Metavar("DIR")] = None
    view: bool = False
    video: Annotated[Path | None, Metavar("FILE.mp4")] = None
    plots: Annotated[Path | None, Metavar("DIR")] = None
    log_depth: bool = False
    overwrite: bool = False


@contextlib.contextmanager
def recorded_session(config: SessionConfig, outputs: SessionOutputs) -> Iterator[Mapping[str, Any]]:
    """Simulate a session, write its outputs, and give the content of session.json.

    Whether the outputs can be written is checked before the session. At the end of the block the viewer, if there is
    one, stays until the user closes it.

    Raises:
        SjasimError: the configuration is not usable, or an output cannot be written.
    """
    _check_names(config)
    check_outputs(outputs)
    with contextlib.ExitStack() as closing:
        observers = SessionObservers(closing, view=outputs.view, video=outputs.video, log_depth=outputs.log_depth)
        log = observers.with_depth(_simulate(config, observers))
        # The caller prints the figures before the viewer is waited for.
        yield _write_outputs(log, outputs, observers)
        observers.wait_until_closed()


def with_policy(config: SessionConfig, policy: Path | None) -> SessionConfig:
    """The configuration with a trained policy as the option of the method ``learned``.

    Raises:
        ConfigError: another method is configured.
    """
    if policy is None:
        return config
    if config.method != "learned":
        raise ConfigError("policy", str(policy), "only with --method learned")
    return replace(config, method_options={**config.method_options, "policy": str(policy)})


def check_outputs(outputs: SessionOutputs) -> None:
    """Find out before a session what would fail after it.

    Raises:
        SjasimError: a target cannot be written, or an optional package or a display is missing.
    """
    if outputs.log_depth and outputs.out is None:
        raise ConfigError("log_depth", True, "only with --out DIR, in whose recording the images are kept")

    if outputs.out is not None:
        from ..record.atomic_folder import check_target

        check_target(outputs.out, outputs.overwrite)

    if outputs.video is not None:
        from ..record.atomic_folder import check_file
        from ..simulation.video import check_writer

        if outputs.video.suffix != ".mp4":
            raise ConfigError("video", str(outputs.video), "a file whose name ends in .mp4")
        check_writer()
        check_file(outputs.video, outputs.overwrite)

    if outputs.plots is not None:
        from ..analysis.plots.files import check_plots

        check_plots(outputs.plots, outputs.overwrite)

    if outputs.view:
        from ..record.rerun.viewer import check_display

        check_display("write the session with --out DIR, and view it on another computer")


def _check_names(config: SessionConfig) -> None:
    """Make the method once and find the sensing, so that wrong names are refused before anything is compiled."""
    from ..anticipation.method import build_method
    from ..core.registry import resolve

    resolve("sensing", config.sensing)
    if config.method != HUMANS_ONLY:
        build_method(config.method, config.method_options)


def _simulate(config: SessionConfig, observers: SessionObservers) -> SessionLog:
    """Run the session, with its progress on stderr."""
    from ..commands.compile_listener import on_compile
    from ..session.session import run_session

    what = f"simulating ({config.method}, {config.sensing} sensing, seed {config.seed})"
    with progress_reporter(what) as reporter, on_compile(reporter.compiling):
        return run_session(config, reporter.simulating, observers.attach)


def _write_outputs(log: SessionLog, outputs: SessionOutputs, observers: SessionObservers) -> Mapping[str, Any]:
    """Write what was asked for, and return the content of session.json."""
    from ..analysis.session_metrics import measures

    summary = measures(log).as_dict()
    if outputs == SessionOutputs():
        return summary  # the report below takes a while, and nobody would see it

    from ..analysis.delay_breakdown import delay_report

    report = delay_report(log)
    observers.finish(log, report)
    if outputs.out is not None:
        _write_folder(log, outputs.out, summary, report, outputs.overwrite)
    if outputs.plots is not None:
        _write_plots(log, report, outputs.plots, outputs.overwrite)
    return summary


def _write_folder(
    log: SessionLog, folder: Path, summary: Mapping[str, Any], report: DelayReport, overwrite: bool
) -> None:
    from ..record.session_folder import write

    place = write(log, folder, summary, report=report, overwrite=overwrite)
    sys.stderr.write(f"session written to {place}\n")


def _write_plots(log: SessionLog, report: DelayReport, folder: Path, overwrite: bool) -> None:
    from ..analysis.plots.files import save_plots

    label = f"{log.config['method']}-{log.config['seed']}"
    names = ", ".join(path.name for path in save_plots({label: (log, report)}, folder, overwrite))
    sys.stderr.write(f"plots written to {folder}: {names}\n")
