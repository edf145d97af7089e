"""Imports go down one ordered list of rooms, siblings do not meet, and heavy libraries stay in the rooms that own them.

The list covers every module of the package: a module that no floor names fails the test.
"""

from __future__ import annotations

import ast
import subprocess
import sys

import pytest

from .source import FACES, Import, Module, imports, modules, skin

FLOORS = (
    ("assets", "core"),
    ("config",),
    ("anticipation", "choreography", "robot", "commands"),
    ("humans", "sensors", "server", "record"),
    ("analysis",),
    ("session",),
    ("simulation",),
    ("interop", "studies", "skeleton_training"),
    FACES,
)
"""Rooms from the lowest floor to the highest; a module imports from its own room and from lower floors."""

FLOOR = {room: floor for floor, rooms in enumerate(FLOORS) for room in rooms}

SIBLINGS = {
    ("core", "assets"),
}
"""(room, room of the same floor that it may import)."""

ONLY = {
    "analysis": {
        "anticipation": {
            "anticipation.coincidences",
            "anticipation.pair_kernel",
            "anticipation.synchrony",
            "anticipation.timing_appropriateness",
        },
        "humans": {"humans.timing.parameters"},
        "robot": set(),
        "sensors": set(),
        "server": set(),
    },
}
"""Room -> lower room -> the modules of it that may be imported. A lower room without a row may be imported whole."""

OWNERS = {
    "mujoco": ("simulation", "humans.body.body_model", "humans.body.mjcf", "robot.mjcf", "interop"),
    "gymnasium": (),
    "rerun": ("record.rerun",),
    "rerun_cli": ("record.rerun",),
    "dm_control": ("interop",),
    "dm_env": ("interop",),
    "mcap": ("record.ros2",),
    "mcap_ros2": ("record.ros2",),
    "imageio_ffmpeg": ("simulation.video",),
    "PIL": ("simulation.video",),
    "matplotlib": ("analysis.plots",),
    "joblib": ("studies.backends.local_processes",),
    "distributed": ("studies.backends.dask_workers",),
    "ray": ("studies.backends.ray_workers",),
    "tomli_w": ("config.toml_file",),
    "jinja2": ("studies.report",),
    "markupsafe": ("studies.report",),
}
"""Library -> the rooms or modules that may import it."""

HEAVY = (
    "mujoco", "rerun", "matplotlib", "scipy.stats", "numba", "dm_control", "mcap", "mcap_ros2", "imageio_ffmpeg",
    "joblib", "distributed", "ray", "jinja2",
)  # fmt: skip


def fault(module: Module, item: Import) -> str | None:
    """What is wrong with one import inside the package, or None."""
    if item.absolute:
        return "inside sjasim, import relatively"
    room, target = module.room, item.target.partition(".")[0]
    if target in ("", room):
        return None
    if FLOOR[target] > FLOOR[room]:
        return f"{room} may not import {item.target} of a higher floor"
    if FLOOR[target] == FLOOR[room] and (room, target) not in SIBLINGS:
        return f"{room} may not import its sibling {item.target}"
    allowed = ONLY.get(room, {}).get(target)
    return f"{room} may not import {item.target}" if allowed is not None and item.target not in allowed else None


def test_every_module_stands_in_a_room_or_is_a_face():
    assert not [module.where for module in modules() if module.name and module.room not in FLOOR]


@pytest.mark.parametrize("module", modules(), ids=lambda module: module.name or "sjasim")
def test_imports_go_down(module):
    if not module.name:
        return
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


def test_no_face_imports_another():
    crossing = [
        f"{module.where}:{item.line}: {item.target}"
        for module in modules()
        if module.name in FACES
        for item in imports(module)
        if item.inside and item.target in FACES and item.target != module.name
    ]
    assert not crossing


@pytest.mark.parametrize("module", skin(), ids=lambda module: module.name)
def test_the_environments_stand_on_sjasim_and_gymnasium(module):
    found = {node.module or "" for node in ast.walk(module.tree) if isinstance(node, ast.ImportFrom) and not node.level}
    found |= {alias.name for node in ast.walk(module.tree) if isinstance(node, ast.Import) for alias in node.names}
    rooms = {name.partition(".")[0] for name in found}
    assert rooms <= {"sjasim", "gymnasium", "numpy", "numba", *sys.stdlib_module_names}
    above = {"studies", "skeleton_training", "interop", *FACES}
    assert not {name for name in found if name.startswith("sjasim.") and name.split(".")[1] in above}
    if module.path.name == "__init__.py":
        assert rooms <= {"gymnasium", "__future__"}


def test_core_needs_numpy_alone_but_for_the_decorators_of_compiled_functions():
    outside = {
        (module.name, item.target.partition(".")[0])
        for module in modules()
        if module.room == "core"
        for item in imports(module)
        if not item.inside and item.target.partition(".")[0] not in {*sys.stdlib_module_names, "numpy"}
    }
    assert outside == {("core.compiled", "numba")}


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
