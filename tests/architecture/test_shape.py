"""Sizes, air, documentation and sources: what the house style asks of every file.

The numbers are signs of readable code, not its goal. A limit that makes a piece of code worse is broken: the function
then stands in `EXCEPTIONS` with its reason.
"""

from __future__ import annotations

import ast
import io
import re
import tokenize

import pytest

from .source import FACES, PACKAGE, ROOT, modules, skin

FILE_LINES = 400
"""Largest number of lines of a file that are not blank."""

FACE_LINES = 60
"""Largest number of lines of a command face."""

FUNCTION_LINES = 40
"""Largest number of lines of a function's body; compiled kernels may be longer."""

PARAMETERS = 8
"""Largest number of parameters of a function; compiled kernels and constructors of plug-ins may have more."""

LONG_BODY = 20
"""Bodies of at least this many lines should have a blank line or a comment."""

COMMENTS_PER_100 = 2.0
AIRLESS_SHARE = 0.10
PACKED_SHARE = 0.02

EXCEPTIONS: dict[str, str] = {}
"""``file:function`` -> why it may break a limit."""

FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)
COMPILED = ("compiled_entry", "compiled_inner", "njit")


def files(*folders):
    """Every Python file in some folders."""
    return sorted(path for folder in folders for path in (ROOT / folder).rglob("*.py"))


SHIPPED = files("sjasim", "envs", "scripts")
ALL = files("sjasim", "envs", "scripts", "tests", "docs")


def functions(path):
    """Every function of a file."""
    return [node for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))) if isinstance(node, FUNCTIONS)]


def body(node):
    """Statements of a function after its docstring."""
    return node.body[1:] if ast.get_docstring(node) else node.body


def is_compiled(node):
    """Whether numba compiles a function."""
    return any(name in ast.unparse(decorator) for decorator in node.decorator_list for name in COMPILED)


def is_excepted(path, node):
    """Whether a function is allowed to break a limit."""
    return f"{path.relative_to(ROOT)}:{node.name}" in EXCEPTIONS


@pytest.mark.parametrize("path", ALL, ids=lambda path: str(path.relative_to(ROOT)))
def test_files_and_functions_are_short(path):
    filled = sum(1 for line in path.read_text(encoding="utf-8").splitlines() if line.strip())
    assert filled <= FILE_LINES, f"{filled} lines that are not blank"

    too_long = {}
    for node in functions(path):
        statements = body(node)
        if statements and not is_compiled(node) and not is_excepted(path, node):
            lines = statements[-1].end_lineno - statements[0].lineno + 1
            if lines > FUNCTION_LINES:
                too_long[node.name] = lines
    assert not too_long


@pytest.mark.parametrize("name", FACES)
def test_command_faces_are_thin(name):
    text = (PACKAGE / f"{name}.py").read_text(encoding="utf-8")
    assert len(text.splitlines()) <= FACE_LINES


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: str(path.relative_to(ROOT)))
def test_parameter_lists_are_short(path):
    crowded = {}
    for node in functions(path):
        arguments = node.args.posonlyargs + node.args.args + node.args.kwonlyargs
        count = sum(1 for argument in arguments if argument.arg not in ("self", "cls"))
        if count > PARAMETERS and not is_compiled(node) and not is_excepted(path, node):
            crowded[node.name] = count
    assert not crowded


def test_code_is_commented():
    """Comments in 100 lines of code, over all shipped files; directives to tools do not count."""
    comments = 0
    code = 0
    for path in SHIPPED:
        text = path.read_text(encoding="utf-8")
        documented = docstring_lines(text)
        for number, line in enumerate(text.splitlines(), start=1):
            if line.strip() and number not in documented and not line.strip().startswith("#"):
                code += 1
        for token in tokenize.generate_tokens(io.StringIO(text).readline):
            if token.type == tokenize.COMMENT and not re.match(r"#\s*(fmt|noqa|type):", token.string):
                comments += 1
    assert 100 * comments / code >= COMMENTS_PER_100


def docstring_lines(text):
    """Numbers of the lines that hold docstrings and documented constants."""
    lines = set()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str):
            lines |= set(range(node.lineno, node.end_lineno + 1))
    return lines


def test_long_bodies_have_air():
    """Share of bodies of `LONG_BODY` lines or more without a blank line or a comment."""
    long = 0
    airless = []
    for path in SHIPPED:
        lines = path.read_text(encoding="utf-8").splitlines()
        for node in functions(path):
            statements = body(node)
            if not statements:
                continue
            inner = lines[statements[0].lineno - 1 : statements[-1].end_lineno]
            if len(inner) >= LONG_BODY:
                long += 1
                if all(line.strip() and not line.strip().startswith("#") for line in inner):
                    airless.append(f"{path.relative_to(ROOT)}:{node.lineno} {node.name}")
    assert long > 0
    assert len(airless) < AIRLESS_SHARE * long, airless


def test_assignments_are_not_packed():
    """Share of assignments of the form ``a, b = x, y``, swaps excepted."""
    assignments = 0
    packed = []
    for path in SHIPPED:
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if not isinstance(node, ast.Assign):
                continue
            assignments += 1
            target = node.targets[0]
            if isinstance(target, ast.Tuple) and isinstance(node.value, ast.Tuple) and not is_swap(target, node.value):
                packed.append(f"{path.relative_to(ROOT)}:{node.lineno}")
    assert len(packed) < PACKED_SHARE * assignments, packed


def is_swap(target, value):
    """Whether an assignment exchanges or rotates values."""
    return sorted(map(ast.unparse, target.elts)) == sorted(map(ast.unparse, value.elts))


def test_every_exception_exists():
    known = {f"{path.relative_to(ROOT)}:{node.name}" for path in ALL for node in functions(path)}
    assert set(EXCEPTIONS) <= known
    assert all(EXCEPTIONS.values())


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
    cited = 0
    unknown = []
    for path in sorted(PACKAGE.rglob("*.py")):
        keys = re.findall(r"Source: ([\w:-]+)", path.read_text(encoding="utf-8"))
        cited += len(keys)
        unknown += [f"{path.name}: {key}" for key in keys if key not in known]
    assert cited > 0
    assert not unknown
