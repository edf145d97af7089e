"""Imports go down, siblings never meet, and heavy libraries stay in the rooms that own them."""

from __future__ import annotations

import ast
import subprocess
import sys

import pytest

from .source import Import, Module, imports, modules, skin

LEVELS = {
    **dict.fromkeys(("types", "tempo", "answers", "logs", "errors"), 0),
    **dict.fromkeys(("registry", "clock", "link", "memory", "rays", "contacts", "addresses"), 1),
    **dict.fromkeys(("config", "config_io"), 2),
    **dict.fromkeys(("choreography", "assets"), 3),
    **dict.fromkeys(("humans", "robot", "sensors", "server", "anticipation", "record"), 4),
    **dict.fromkeys(("stage", "recorder", "turns", "render", "window", "people", "worlds", "analysis"), 5),
    "session": 6,
}
"""Room -> level; every other top-level module is a command line or a study, at level 7."""

TOP = 7

SAME_LEVEL = {
    ("errors", "types"), ("types", "errors"), ("logs", "types"), ("tempo", "errors"), ("answers", "types"),
    ("answers", "tempo"),
    ("config_io", "config"), ("addresses", "memory"),
    ("choreography", "assets"),
    ("render", "stage"), ("window", "render"), ("window", "stage"),
    ("recorder", "stage"), ("turns", "stage"), ("turns", "recorder"), ("worlds", "turns"),
    ("worlds", "stage"), ("worlds", "recorder"), ("worlds", "people"),
}  # fmt: skip
"""(room, room of the same level that it may import)."""

ONLY = {
    "stage": {"humans": {"humans.body", "humans.anatomy"}, "robot": {"robot.body"}},
    "analysis": {
        "anticipation": {"anticipation.synchrony", "anticipation.appropriateness"},
        "record": None,
        "humans": {"humans.parameters"}, "robot": set(), "sensors": set(), "server": set(),
    },
}  # fmt: skip
"""Room -> room below -> the modules of it that may be imported (None: all)."""

OWNERS = {
    "mujoco": ("stage", "render", "window", "humans.body", "robot.body", "interop", "profiling"),
    "gymnasium": (),
    "rerun": ("record", "view"),
    "dm_control": ("interop",),
    "mcap": ("record",), "mcap_ros2": ("record",), "rerun_cli": ("record",),
    "imageio_ffmpeg": ("film",), "PIL": ("film",),
    "dm_env": ("interop",),
    "matplotlib": ("analysis.plots",),
}  # fmt: skip
"""Library -> the rooms or modules that may import it."""

HEAVY = ("mujoco", "rerun", "matplotlib", "scipy.stats", "numba", "dm_control", "mcap", "mcap_ros2", "imageio_ffmpeg")


def level(name: str) -> int:
    """Level of a module, by its room; the package itself may name anything."""
    return LEVELS.get(name.partition(".")[0], TOP) if name else TOP + 1


def fault(module: Module, item: Import) -> str | None:
    """What is wrong with one import inside the package, or None."""
    if item.absolute:
        return "inside sjasim, import relatively"
    room, target = module.room, item.target.partition(".")[0]
    if room == target:
        return None
    own, other = level(module.name), level(item.target)
    if other > own or (other == own < TOP and (room, target) not in SAME_LEVEL):
        return f"level {own} may not import {item.target} of level {other}"
    allowed = ONLY.get(room, {}).get(target)
    if target in ONLY.get(room, {}) and allowed is not None and item.target not in allowed:
        return f"{room} may not import {item.target}"
    return None


@pytest.mark.parametrize("module", modules(), ids=lambda module: module.name or "sjasim")
def test_imports_go_down(module):
    items = [(item, fault(module, item)) for item in imports(module) if item.inside]
    assert not [f"{module.where}:{item.line}: {wrong}" for item, wrong in items if wrong]


@pytest.mark.parametrize("module", modules(), ids=lambda module: module.name or "sjasim")
def test_libraries_stay_in_their_rooms(module):
    wrong = []
    for item in imports(module):
        owners = OWNERS.get(item.target.partition(".")[0])
        if owners is None or item.inside:
            continue
        if not any(module.name == owner or module.name.startswith(f"{owner}.") for owner in owners):
            wrong.append(f"{module.where}:{item.line}: {item.target} belongs to {owners or 'envs'}")
    assert not wrong


@pytest.mark.parametrize("module", skin(), ids=lambda module: module.name)
def test_the_environments_stand_on_sjasim_and_gymnasium(module):
    found = {node.module or "" for node in ast.walk(module.tree) if isinstance(node, ast.ImportFrom) and not node.level}
    found |= {alias.name for node in ast.walk(module.tree) if isinstance(node, ast.Import) for alias in node.names}
    rooms = {name.partition(".")[0] for name in found}
    assert rooms <= {"sjasim", "gymnasium", "numpy", "numba", *sys.stdlib_module_names}
    assert not {name for name in found if name.startswith(("sjasim.run", "sjasim.study", "sjasim.interop"))}
    if module.path.name == "__init__.py":
        assert rooms <= {"gymnasium", "__future__"}


def test_foundation_stands_on_numpy_alone():
    outside = {
        (module.name, item.target.partition(".")[0])
        for module in modules()
        if module.room in ("types", "tempo", "answers", "logs", "errors")
        for item in imports(module)
        if not item.inside and item.target.partition(".")[0] not in {*sys.stdlib_module_names, "numpy"}
    }
    assert not outside


def test_there_are_no_cycles():
    graph = {module.name: {item.target for item in imports(module) if item.inside} for module in modules()}
    graph.pop("")
    done: set[str] = set()

    def visit(name: str, path: tuple[str, ...]) -> None:
        assert name not in path, " -> ".join([*path, name])
        if name in done:
            return
        for target in graph.get(name, ()):
            if target != name:
                visit(target, (*path, name))
        done.add(name)

    for name in graph:
        visit(name, ())


def test_import_sjasim_is_light():
    probe = f"import sys, sjasim; print([name for name in {HEAVY!r} if name in sys.modules])"
    answer = subprocess.run([sys.executable, "-c", probe], capture_output=True, text=True, check=True)
    assert answer.stdout.strip() == "[]"
