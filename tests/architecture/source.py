"""What the architecture tests know of the source: its modules, their rooms, what each imports."""

from __future__ import annotations

import ast
from dataclasses import dataclass
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "sjasim"

FACES = tuple(sorted(path.stem for path in PACKAGE.glob("*.py") if path.stem != "__init__"))
"""Modules beside the rooms: one command each."""


@dataclass(frozen=True)
class Import:
    """One import statement: the dotted target inside sjasim (without the package's name) or outside."""

    target: str
    inside: bool
    absolute: bool
    line: int


@dataclass(frozen=True)
class Module:
    """One file of the package; ``name`` is dotted and without ``sjasim.``, "" for the package itself."""

    name: str
    path: Path
    tree: ast.Module

    @property
    def room(self) -> str:
        return self.name.partition(".")[0]

    @property
    def where(self) -> str:
        return str(self.path.relative_to(ROOT))


@cache
def skin() -> tuple[Module, ...]:
    """Every module of the environments' package, which lies outside."""
    paths = sorted((ROOT / "envs" / "sjasim_envs").rglob("*.py"))
    return tuple(
        Module(f"sjasim_envs.{path.stem}", path, ast.parse(path.read_text(encoding="utf-8"))) for path in paths
    )


@cache
def modules() -> tuple[Module, ...]:
    """Every module of the package."""
    found = []
    for path in sorted(PACKAGE.rglob("*.py")):
        parts = list(path.relative_to(PACKAGE).with_suffix("").parts)
        if parts[-1] == "__init__":
            parts.pop()
        found.append(Module(".".join(parts), path, ast.parse(path.read_text(encoding="utf-8"))))
    return tuple(found)


def imports(module: Module) -> list[Import]:
    """Every import of a module, those inside functions included."""
    found = []
    for node in ast.walk(module.tree):
        if isinstance(node, ast.Import):
            found += [_outside(alias.name, node.lineno) for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            found.append(_outside(node.module or "", node.lineno))
        elif isinstance(node, ast.ImportFrom):
            found += [Import(target, True, False, node.lineno) for target in _relative(module, node)]
    return found


def _outside(name: str, line: int) -> Import:
    own = name.partition(".")[0] == "sjasim"
    return Import(name.removeprefix("sjasim").removeprefix(".") if own else name, own, True, line)


def _relative(module: Module, node: ast.ImportFrom) -> list[str]:
    """Dotted modules that a relative import reaches; ``from . import x`` may name modules or values."""
    package = module.name.split(".") if module.name else []
    if module.path.name != "__init__.py":
        package = package[:-1]
    base = package[: len(package) - (node.level - 1)] + (node.module.split(".") if node.module else [])
    names = {item.name for item in modules()}
    submodules = [".".join([*base, alias.name]) for alias in node.names]
    reached = [name for name in submodules if name in names]
    plain = len(reached) < len(submodules) or not submodules
    return reached + ([".".join(base)] if plain else [])
