"""Sizes, documentation and sources: what the house style asks of every file."""

from __future__ import annotations

import ast
import re

import pytest

from .source import FACES, PACKAGE, ROOT, modules, skin

FILE_LINES = 400
FUNCTION_LINES = 50
FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)


def files():
    """Every Python file that is ours: the package, its skin, scripts and tests."""
    return sorted(
        path for room in ("sjasim", "envs", "scripts", "tests", "docs") for path in (ROOT / room).rglob("*.py")
    )


@pytest.mark.parametrize("path", files(), ids=lambda path: str(path.relative_to(ROOT)))
def test_files_and_functions_are_short(path):
    text = path.read_text(encoding="utf-8")
    filled = sum(1 for line in text.splitlines() if line.strip())
    assert filled <= FILE_LINES, f"{filled} lines that are not blank"
    functions = [node for node in ast.walk(ast.parse(text)) if isinstance(node, FUNCTIONS)]
    lengths = {node.name: node.end_lineno - node.lineno + 1 for node in functions}
    assert not {name: length for name, length in lengths.items() if length > FUNCTION_LINES}


@pytest.mark.parametrize("module", [*modules(), *skin()], ids=lambda module: module.name or "sjasim")
def test_public_names_are_documented(module):
    assert ast.get_docstring(module.tree), f"{module.where} has no docstring"
    assert not [f"{module.where}:{line} {name}" for name, line in undocumented(module.tree)]


def undocumented(tree: ast.Module | ast.ClassDef) -> list[tuple[str, int]]:
    """Public functions, classes and methods without a docstring; a property's setter shares its getter's."""
    found = []
    for node in tree.body:
        if not isinstance(node, (*FUNCTIONS, ast.ClassDef)) or node.name.startswith("_"):
            continue
        setter = any(isinstance(item, ast.Attribute) for item in node.decorator_list)
        if not ast.get_docstring(node) and not setter:
            found.append((node.name, node.lineno))
        if isinstance(node, ast.ClassDef):
            found += undocumented(node)
    return found


def test_sources_are_in_the_bibliography():
    known = set(re.findall(r"^@\w+\{([\w:-]+),", (ROOT / "docs" / "references.bib").read_text(encoding="utf-8"), re.M))
    assert "iqbal2016" in known
    unknown = []
    for path in sorted(PACKAGE.rglob("*.py")):
        text = path.read_text(encoding="utf-8")
        unknown += [f"{path.name}: {key}" for key in re.findall(r"Source: ([\w:-]+)", text) if key not in known]
    assert not unknown


FACE_LINES = 60


@pytest.mark.parametrize("face", FACES)
def test_a_face_is_thin(face):
    """A command's module holds its options, one call and the printing; what it does stands in a room."""
    text = (PACKAGE / f"{face}.py").read_text(encoding="utf-8")
    assert len(text.splitlines()) <= FACE_LINES
