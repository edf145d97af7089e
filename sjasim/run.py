"""``python -m sjasim.run``: dance one session, show its figures, keep it if a folder is named."""

from __future__ import annotations

import contextlib
import json
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any

import tyro
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from .anticipation import method
from .commands.options import config_from, main, parse
from .commands.progress import progress_reporter
from .config import SessionConfig
from .config.toml_file import to_plain
from .core.errors import ConfigError
from .core.session_log import SessionLog
from .record.rerun.explanation import DelayReport

ABOUT = "One dance session: dancers, sensors, server, robot; its figures as a table."


@dataclass(frozen=True)
class Options:
    """One dance session.

    Attributes:
        session: the whole configuration; every field is a flag.
        out: folder to keep the session in; new or empty.
        policy: npz file of a trained policy, for ``--method learned``.
        view: show the session in rerun's viewer while it is danced.
        video: film of the dance, with captions; an .mp4 file. Takes longer than the dance without a graphics card.
        plots: folder for the figures as pictures.
        log_depth: keep depth images of the active sensor, 5 a second, in the recording; needs --out.
        overwrite: replace an earlier session or film.
        json: print session.json, and nothing else, on stdout.
        config: TOML file of the session's fields; flags override it.
    """

    session: Annotated[SessionConfig, tyro.conf.arg(name="")]
    out: Path | None = None
    policy: Path | None = None
    view: bool = False
    video: Path | None = None
    plots: Path | None = None
    log_depth: bool = False
    overwrite: bool = False
    json: bool = False
    config: Path | None = None


def command(arguments: Sequence[str]) -> None:
    """Parse, check what can be checked beforehand, dance, measure, keep, show."""
    base = Options(config_from(arguments))
    options = parse(Options, arguments, base, "python -m sjasim.run", ABOUT)
    options = trained(options)
    config = options.session
    if config.method != method.HUMANS_ONLY:
        method.build_method(config.method, config.method_options)
    check(options)
    with contextlib.ExitStack() as watching:
        audience = SessionObservers(options, watching) if options.view or options.video or options.log_depth else None
        log = dance(config, audience)
        if audience is not None:
            log = audience.seen(log)
        summary = keep(log, options, audience)
        shown(summary, options)
        if audience is not None:
            audience.linger()


def trained(options: Options) -> Options:
    """The same, a policy that is named having become its method's option.

    Raises:
        ConfigError: the method takes none.
    """
    config = options.session
    if options.policy is None:
        return options
    if config.method != "learned":
        raise ConfigError("policy", str(options.policy), "only with --method learned")
    return replace(
        options, session=replace(config, method_options={**config.method_options, "policy": str(options.policy)})
    )


def check(options: Options) -> None:
    """Find out before the dance what would fail after it.

    Raises:
        SjasimError: a target cannot be written, or something that an option needs is missing.
    """
    if options.log_depth and options.out is None:
        raise ConfigError("log_depth", True, "only with --out DIR, in whose recording the images are kept")
    if options.out is not None:
        from .record.atomic_folder import check_target

        check_target(options.out, options.overwrite)
    if options.video is not None:
        from .record.atomic_folder import check_file
        from .simulation.video import check_writer

        if options.video.suffix != ".mp4":
            raise ConfigError("video", str(options.video), "a file whose name ends in .mp4")
        check_writer()
        check_file(options.video, options.overwrite)
    if options.plots is not None:
        from .analysis.plots import check_plots

        check_plots(options.plots, options.overwrite)
    if options.view:
        from .record.rerun.viewer import check_display

        check_display("keep the session with --out DIR, and look at it elsewhere")


class SessionObservers:
    """Who watches a session while it is danced: the viewer, the film.

    Args:
        options: which.
        closing: takes what has to be closed, whatever happens.
    """

    def __init__(self, options: Options, closing: contextlib.ExitStack) -> None:
        self._options = options
        self._closing = closing
        self._film: Any = None
        self._live: Any = None
        self._depth: Any = None

    def seen(self, log: SessionLog) -> SessionLog:
        """The log, with the depth images that were taken meanwhile."""
        return log if self._depth is None else replace(log, depth=tuple(self._depth.pictures))

    def prepare(self, session: Any) -> None:
        """Let them in, before the session begins."""
        if self._options.video is not None:
            from .simulation.video import VideoWriter

            film = self._film = VideoWriter(session, self._options.video)
            self._closing.callback(lambda: film.close(keep=False) if self._film is not None else None)
            session.world.watchers.append(film.tick)
        if self._options.log_depth:
            from .simulation.depth_recorder import DepthRecorder

            self._depth = DepthRecorder(session)
            session.world.watchers.append(self._depth.tick)
        if self._options.view:
            from .record.rerun.live_view import LiveView

            live = self._live = LiveView(self._options.session)
            self._closing.callback(live.close)
            session.world.watchers.append(lambda now: live.tick(now, session.log))

    def finish(self, log: SessionLog, report: DelayReport) -> None:
        """The dance is over."""
        if self._film is not None:
            self._film.close()
            self._film = None
            sys.stderr.write(f"film in {self._options.video}\n")
        if self._live is not None:
            self._live.finish(log, report)

    def linger(self) -> None:
        """Wait until the viewer is closed."""
        if self._live is not None:
            sys.stderr.write("close the viewer, or press Ctrl-C, to end\n")
            self._live.process.wait()


def keep(log: SessionLog, options: Options, audience: SessionObservers | None) -> Mapping[str, Any]:
    """Measure the session and write what was asked for; gives session.json's content."""
    from .analysis.session_metrics import measures

    summary = measures(log).as_dict()
    if options.out is None and options.plots is None and audience is None:
        return summary
    from .analysis.delay_breakdown import delay_report

    found = delay_report(log)
    if audience is not None:
        audience.finish(log, found)
    if options.out is not None:
        from .record.session_folder import write

        place = write(log, options.out, summary, report=found, overwrite=options.overwrite)
        sys.stderr.write(f"kept in {place}\n")
    if options.plots is not None:
        from .analysis.plots import save_plots

        names = ", ".join(path.name for path in save_plots(log, found, options.plots, options.overwrite))
        sys.stderr.write(f"plots in {options.plots}: {names}\n")
    return summary


def shown(summary: Mapping[str, Any], options: Options) -> None:
    """Print the figures, as a table or as session.json."""
    if options.json:
        sys.stdout.write(json.dumps(summary, indent=1, allow_nan=False) + "\n")
    else:
        show(summary, Console())


def dance(config: SessionConfig, audience: SessionObservers | None = None) -> SessionLog:
    """Run the session, and say on stderr how far it is."""
    from .commands.compile_listener import on_compile
    from .session.session import run_session

    watched = {} if audience is None else {"prepare": audience.prepare}
    dancing = f"dancing ({config.method}, {config.sensing} sensing, seed {config.seed})"
    with progress_reporter(dancing) as signs, on_compile(signs.compiling):
        return run_session(config, signs.dancing, **watched)


def show(summary: Mapping[str, Any], console: Console) -> None:
    """Print a session's figures for people: a table by iteration, then a line for each part's work."""
    alone = summary["method"] == method.HUMANS_ONLY
    table = Table(title=escape(title(summary)))
    for name in ("iteration", "GSI", "GSI, full edges", "GSI, true onsets", "MSP", "TA [s]", "missed"):
        table.add_column(escape(name), justify="right")  # [s] is a unit, not a style
    for row in summary["iterations"]:
        indices = (_number(row[key]) for key in ("gsi", "gsi_full_edges", "gsi_truth"))
        missed = "-" if alone else str(row["robot_missed"])
        table.add_row(str(row["index"]), *indices, row["msp"], _number(row["ta_mean_s"], 2), missed)
    table.add_section()
    indices = (_number(summary[key]) for key in ("gsi", "gsi_full_edges", "gsi_truth"))
    missed = "-" if alone else f"{summary['robot']['missed']} in all"
    table.add_row("mean", *indices, "", _number(summary["ta_mean_s"], 2), missed)
    console.print(table)
    for line in remarks(summary):
        console.print(line, markup=False, highlight=False)


def title(summary: Mapping[str, Any]) -> str:
    """Method, seed, people, and what else a session has of its own."""
    config, usual = summary["config"], to_plain(SessionConfig())
    parts = [summary["method"], f"seed {summary['seed']}", f"{summary['humans']} dancers"]
    if config["dance"]["name"] != SessionConfig().dance.name:
        parts.append(config["dance"]["name"])
    own = (name for name in ("sensing", "layout", "dancers") if config[name] != usual[name])
    return ", ".join([*parts, *(f"{name} {config[name]}" for name in own)])


def remarks(summary: Mapping[str, Any]) -> list[str]:
    """What the table does not hold, one line each."""
    detector, robot = summary["detector"], summary["robot"]
    lines = [
        f"detectors: recall {_number(detector['recall'])} in sight, precision {_number(detector['precision'])}, "
        f"95 % of times within {_number(detector['timing_p95_s'])} s"
    ]
    if robot["commands"]:
        lines.append(
            f"robot: {robot['commands']} commands, {_number(robot['executed'])} of them executed, "
            f"ended {_number(robot['end_distance_m'], 2)} m from its slot"
        )
    latencies = summary["net_latency_s"]
    if latencies:
        total = sum(item["n"] for item in latencies.values())
        pooled = sum(item["mean"] * item["n"] for item in latencies.values()) / total
        parts = ", ".join(f"{kind} {item['mean']:+.2f}" for kind, item in latencies.items())
        lines.append(f"net latency: {pooled:+.2f} s ({parts})")
    lines.append(
        f"bodies: {summary['falls']} falls, feet carry {_number(summary['feet_load_share'])} of the weight, "
        f"tether {_number(summary['tether_rms_n'], 1)} N"
    )
    return lines + [f"notice at {item['t_s']:.1f} s: {item['source']}: {item['what']}" for item in summary["notices"]]


def _number(value: float | None, digits: int = 3) -> str:
    return "-" if value is None else f"{value:.{digits}f}"


if __name__ == "__main__":
    sys.exit(main(command))
