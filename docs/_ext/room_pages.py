"""Writes one page of the API reference for each room of the package, before Sphinx reads its sources.

The pages stand in ``docs/reference/api`` and are not kept in the repository. Each lists the modules of a room in the
order of their names; autodoc fills in what their docstrings say.
"""

from __future__ import annotations

import ast
import inspect
from pathlib import Path
from typing import TYPE_CHECKING

import sjasim

if TYPE_CHECKING:
    from sphinx.application import Sphinx

ROOT = Path(__file__).resolve().parents[2]
PLACE = "reference/api"


def rooms() -> dict[str, list[str]]:
    """Name of each room -> its modules, as they are imported; the room's own package comes first."""
    found = {}
    for package in [*sorted((ROOT / "sjasim").iterdir()), ROOT / "envs" / "sjasim_envs"]:
        if not (package / "__init__.py").exists():
            continue
        paths = [path for path in package.rglob("*.py") if not path.stem.startswith("_") or path.stem == "__init__"]
        names = (_module_name(path) for path in paths)
        found[package.name] = sorted(names)
    return found


def _module_name(path: Path) -> str:
    base = ROOT / "envs" if "envs" in path.relative_to(ROOT).parts[:1] else ROOT
    parts = path.relative_to(base).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def source_path(module: str) -> Path:
    """The file of a module."""
    base = ROOT / "envs" if module.startswith("sjasim_envs") else ROOT
    path = base.joinpath(*module.split("."))
    return path / "__init__.py" if path.is_dir() else path.with_suffix(".py")


def summary(module: str) -> str:
    """First line of a module's docstring, without the full stop."""
    text = ast.get_docstring(ast.parse(source_path(module).read_text(encoding="utf-8"))) or ""
    return text.partition("\n")[0].rstrip(".")


def _heading(text: str, mark: str) -> list[str]:
    return [text, mark * len(text), ""]


def _room_page(room: str, modules: list[str]) -> str:
    lines = _heading(room, "=")
    for module in modules:
        # A package whose file only holds a docstring says what the room is for, and has no members.
        is_room = source_path(module).name == "__init__.py"
        if not is_room:
            lines += _heading(module, "-")
        lines += [f".. automodule:: {module}"]
        lines += ["   :no-index:" if is_room else "   :members:", ""]
    return "\n".join(lines)


def _index_page(found: dict[str, list[str]]) -> str:
    lines = _heading("API reference", "=")
    lines += _heading("Public names", "-")
    lines += ["``import sjasim`` gives these names. They are loaded when they are first used.", ""]
    lines += _table("name", "meaning", _public_names())
    lines += _heading("Rooms", "-")
    lines += ["Each page documents the modules of one room, from their docstrings.", ""]
    lines += _table("room", "contents", {f":doc:`{room}`": summary(modules[0]) for room, modules in found.items()})
    lines += [".. toctree::", "   :hidden:", ""]
    lines += [f"   {room}" for room in found]
    return "\n".join([*lines, ""])


def _public_names() -> dict[str, str]:
    """A link to each public name -> the first line of its docstring."""
    rows = {}
    for name in sjasim.__all__:
        value = getattr(sjasim, name)
        if isinstance(value, str):
            continue
        place = value.__name__ if inspect.ismodule(value) else f"{value.__module__}.{value.__qualname__}"
        first = (inspect.getdoc(value) or "").partition("\n")[0]
        rows[f":py:obj:`sjasim.{name} <{place}>`"] = first.rstrip(".")
    return rows


def _table(left: str, right: str, rows: dict[str, str]) -> list[str]:
    lines = [".. list-table::", "   :header-rows: 1", "   :widths: 25 75", "", f"   * - {left}", f"     - {right}"]
    for first, second in rows.items():
        lines += [f"   * - {first}", f"     - {second}"]
    return [*lines, ""]


def write_pages(app: Sphinx) -> None:
    """Write the pages that have changed, and remove those of rooms that are gone."""
    folder = Path(app.srcdir) / PLACE
    folder.mkdir(parents=True, exist_ok=True)
    found = rooms()
    pages = {f"{room}.rst": _room_page(room, modules) for room, modules in found.items()}
    pages["index.rst"] = _index_page(found)

    for path in folder.glob("*.rst"):
        if path.name not in pages:
            path.unlink()
    for name, text in pages.items():
        path = folder / name
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")


class PlainDescriptions:
    """Keeps the descriptions of constants and properties as they are written.

    Napoleon takes what stands before a colon in their first line for a type, which none of ours is.
    """

    def __init__(self) -> None:
        self._lines: list[str] = []

    def before(self, app: Sphinx, what: str, name: str, item: object, options: object, lines: list[str]) -> None:
        """Remember a docstring that napoleon has not seen, with bars escaped, which would mark substitutions."""
        lines[:] = [line if "``" in line else line.replace("|", r"\|") for line in lines]
        self._lines = list(lines)

    def after(self, app: Sphinx, what: str, name: str, item: object, options: object, lines: list[str]) -> None:
        """Put the docstring of a constant or property back."""
        if what in ("data", "attribute", "property"):
            lines[:] = self._lines


def setup(app: Sphinx) -> dict[str, object]:
    """Write the pages when the builder has started, and edit docstrings as they are read."""
    app.connect("builder-inited", write_pages)
    descriptions = PlainDescriptions()
    app.connect("autodoc-process-docstring", descriptions.before, priority=400)
    app.connect("autodoc-process-docstring", descriptions.after, priority=600)
    return {"parallel_read_safe": True}
