"""Runs a study: computes the chunks that are missing, writes the data set, and analyses it."""

from __future__ import annotations

import contextlib
import os
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any

from ..analysis.study_tables import StudyTables
from ..commands.flags import Metavar
from ..commands.progress import progress_reporter
from ..config.checks import within
from .backends import BackendName
from .dataset import read_study, write_dataset
from .design_checks import checked_plan
from .study_design import StudyDesign, StudyPlan
from .study_folder import STUDY_FILE, StudyFolder, check_study_folder, open_study
from .study_parts import chunk_count
from .study_price import Price, check_room, price
from .study_results import read_results, results_as_json, study_results

WORTH_PROCESSES_S = 10.0
"""Computing time below which a study runs in this process, because starting others would take longer [s] (assumed)."""


@dataclass(frozen=True)
class Execution:
    """Where and how a study is computed; none of it changes the tables.

    Attributes:
        out: folder for the data set and study.json; it must be new or empty. Without it nothing is kept.
        backend: where sessions are computed: ``local``, ``dask``, ``dask://host:port``, ``ray`` or ``ray://host:port``.
        jobs: number of processes on this computer; 0 for one per core, or for this one if the study is small.
        resume: continue the study in the folder after an interruption.
        overwrite: replace an earlier study in the folder.
    """

    out: Annotated[Path | None, Metavar("DIR")] = None
    backend: str = "local"
    jobs: int = 0
    resume: bool = False
    overwrite: bool = False

    def __post_init__(self) -> None:
        within("jobs", self.jobs, 0, 4096)
        BackendName.parsed(self.backend)

    @property
    def processes(self) -> int:
        """Number of processes on this computer."""
        return self.jobs or os.cpu_count() or 1


def run_study(design: StudyDesign | None = None, out: str | Path | None = None, **execution: Any) -> StudyTables:
    """Run a study and return its tables.

    Args:
        design: the design; None for the published one, in fidelity ``timing``.
        out: folder for the data set and study.json; None to keep nothing on disk.
        **execution: fields of `Execution`: ``backend``, ``jobs``, ``resume``, ``overwrite``.

    Returns:
        all tables. A study that does not fit in memory is run with ``execute`` and read with `StudyReader`.

    Raises:
        SjasimError: the design is not allowed, a session failed, or the folder cannot be written.
    """
    with contextlib.ExitStack() as closing:
        folder = Path(out) if out is not None else Path(closing.enter_context(tempfile.TemporaryDirectory()))
        execute(design or StudyDesign(), Execution(out=folder, **execution))
        return read_study(folder)


def execute(design: StudyDesign, execution: Execution) -> dict[str, Any]:
    """Run a study, write its folder if one is named, and return the content of study.json.

    Progress is reported on stderr.

    Raises:
        SjasimError: see `run_study`.
    """
    with contextlib.ExitStack() as closing:
        target = execution.out or Path(closing.enter_context(tempfile.TemporaryDirectory()))
        plan, needed = priced_plan(design, replace(execution, out=target))
        folder = closing.enter_context(open_study(target, design, execution.resume, execution.overwrite))
        if not folder.is_complete:
            _compute(folder, plan, needed, execution)
        folder.remove_parts()
        return read_results(target)


def priced_plan(design: StudyDesign, execution: Execution) -> tuple[StudyPlan, Price]:
    """Check a design and its folder, and return all its sessions and its price. Nothing is written.

    Raises:
        ConfigError: the design is not allowed.
        RecordError: the folder cannot be used, or has too little room.
    """
    plan = checked_plan(design)
    needed = price(plan)
    target = Path(tempfile.gettempdir())
    if execution.out is not None:
        target = check_study_folder(execution.out, design, execution.resume, execution.overwrite)
    check_room(needed, target)
    return plan, needed


def _compute(folder: StudyFolder, plan: StudyPlan, needed: Price, execution: Execution) -> None:
    """Compute the missing chunks of a study, and write the data set and study.json."""
    from ..session.session import package_versions

    start_s = time.perf_counter()
    chunks = chunk_count(plan)
    missing = folder.missing_chunks(chunks)
    if len(missing) < chunks:
        sys.stderr.write(f"resuming: {chunks - len(missing)} of {chunks} chunks are finished\n")

    # A small study is finished before other processes have started; who names a number of processes gets it.
    is_small = needed.cpu_s * len(missing) / chunks < WORTH_PROCESSES_S
    jobs = 1 if is_small and execution.jobs == 0 and execution.backend == "local" else execution.processes
    try:
        _fill(folder, missing, jobs, execution.backend, f"simulating {len(plan):,} sessions")
    except (KeyboardInterrupt, SystemExit):
        if execution.out is not None:
            sys.stderr.write(f"finished chunks are kept: continue with --resume --out {execution.out}\n")
        raise

    failures = write_dataset(folder, chunks)
    results = study_results(folder.path, plan, failures)
    cost = {"wall_s": time.perf_counter() - start_s, "backend": execution.backend, "jobs": jobs}
    results |= {"versions": dict(package_versions()), "cost": cost}
    folder.write(STUDY_FILE, results_as_json(results))


def _fill(folder: StudyFolder, missing: Sequence[int], jobs: int, backend: str, what: str) -> None:
    """Compute chunks on a backend, and keep each as soon as it is there."""
    name = BackendName.parsed(backend)
    if not missing:
        return
    with (
        progress_reporter(what) as reporter,
        contextlib.closing(name.results()(folder.text, missing, jobs, name.address)) as results,
    ):
        reporter.simulating(0.0)
        for done, (chunk, data) in enumerate(results, start=1):
            folder.keep(chunk, data)
            reporter.simulating(done / len(missing))
