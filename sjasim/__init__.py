"""sjasim simulates dancers and a robot who coordinate in a group, to try out methods before people are recruited.

Public names:
    SessionConfig: configuration of one session.
    run_session: simulates a session and returns its log.
    SessionLog: complete result of a session.
    measures: synchrony, timing and component measures of a log.
    StudyDesign: design of a study of many groups and several methods.
    run_study: simulates a study and returns its tables.
    read_study: reads the tables of a study from its folder.
    StudyReader: reads a study that does not fit in memory.
    synchrony: module with the synchrony equations for event times of any source.
    detect_events: detects events in recorded joints.
    fit_timing: fits the human timing model to recorded groups.
    __version__: version of the package.

A name is loaded when it is first used, so that ``import sjasim`` is quick and imports neither MuJoCo nor rerun. The
import also registers the Gymnasium environments.
"""

from __future__ import annotations

import ctypes
import importlib
import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from .core import compiled_cache as _compiled_cache

if TYPE_CHECKING:
    from .analysis.calibration.event_table_fit import fit_timing
    from .analysis.session_metrics import measures
    from .anticipation import synchrony
    from .config import SessionConfig
    from .core.session_log import SessionLog
    from .sensors.recordings.detect import detect_events
    from .session.session import run_session
    from .studies.dataset import StudyReader, read_study
    from .studies.study_design import StudyDesign
    from .studies.study_execution import run_study

__version__ = "0.1.0"

__all__ = [
    "SessionConfig",
    "SessionLog",
    "StudyDesign",
    "StudyReader",
    "__version__",
    "detect_events",
    "fit_timing",
    "measures",
    "read_study",
    "run_session",
    "run_study",
    "synchrony",
]

_PUBLIC = {
    "SessionConfig": (".config", "SessionConfig"),
    "SessionLog": (".core.session_log", "SessionLog"),
    "StudyDesign": (".studies.study_design", "StudyDesign"),
    "StudyReader": (".studies.dataset", "StudyReader"),
    "detect_events": (".sensors.recordings.detect", "detect_events"),
    "fit_timing": (".analysis.calibration.event_table_fit", "fit_timing"),
    "measures": (".analysis.session_metrics", "measures"),
    "read_study": (".studies.dataset", "read_study"),
    "run_session": (".session.session", "run_session"),
    "run_study": (".studies.study_execution", "run_study"),
    "synchrony": (".anticipation.synchrony", None),
}
"""Public name -> the module that holds it, and its name there; None for the module itself."""


def __getattr__(name: str) -> object:
    """Load a public name when it is first used."""
    if name not in _PUBLIC:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")

    module_name, attribute = _PUBLIC[name]
    module = importlib.import_module(module_name, __name__)
    value: object = getattr(module, attribute) if attribute else module
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})


def _choose_opengl() -> None:
    """Choose an off-screen OpenGL library for MuJoCo on a Linux machine without a display.

    MuJoCo reads the choice when it is imported. A choice of the user's stands. Without any such library rendering is
    disabled, but the sensors still work: they cast rays.
    """
    if "MUJOCO_GL" in os.environ or not sys.platform.startswith("linux") or os.environ.get("DISPLAY"):
        return

    for library, name in (("libEGL.so.1", "egl"), ("libOSMesa.so.8", "osmesa")):
        try:
            ctypes.CDLL(library)
        except OSError:
            continue
        os.environ["MUJOCO_GL"] = name
        return
    os.environ["MUJOCO_GL"] = "disable"


def _register_environments() -> None:
    """Register the Gymnasium ids; in a clone that is not installed the environments stand beside the package."""
    try:
        importlib.import_module("sjasim_envs")
    except ModuleNotFoundError as missing:
        folder = Path(__file__).absolute().parent.parent / "envs"
        if missing.name != "sjasim_envs" or not (folder / "sjasim_envs").is_dir():
            raise
        sys.path.append(str(folder))
        importlib.import_module("sjasim_envs")


_choose_opengl()
_folder = Path(__file__).parent
_compiled_cache.prepare(_folder, _folder.parent / "sjasim_envs", _folder.parent / "envs")
_register_environments()
