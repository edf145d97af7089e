"""Directive ``command-help``: the help text of every command, as the command itself prints it.

The width is fixed and colours are off, so that the page does not depend on the terminal of the build.
"""

from __future__ import annotations

import contextlib
import importlib
import io
import os
from typing import TYPE_CHECKING
from unittest import mock

from docutils import nodes
from sphinx.util.docutils import SphinxDirective

from sjasim.commands.command_list import COMMANDS

if TYPE_CHECKING:
    from sphinx.application import Sphinx

WIDTH = 88
"""Characters a line."""


def help_text(name: str) -> str:
    """What ``sjasim NAME --help`` prints.

    Args:
        name: name of the command.
    """
    terminal = {"COLUMNS": str(WIDTH), "NO_COLOR": "1", "TERM": "dumb"}
    face = importlib.import_module(f"sjasim.{name.replace('-', '_')}")
    printed = io.TextIOWrapper(io.BytesIO(), encoding="utf-8")
    ended = contextlib.suppress(SystemExit)
    with mock.patch.dict(os.environ, terminal), contextlib.redirect_stdout(printed), ended:
        face.command(["--help"], program=f"sjasim {name}")
    printed.seek(0)
    return printed.read().rstrip()


class CommandHelp(SphinxDirective):
    """A section for each command, with its help text in a literal block."""

    def run(self) -> list[nodes.Node]:
        """Make the sections."""
        return [self._section(name) for name in COMMANDS]

    def _section(self, name: str) -> nodes.section:
        text = help_text(name)
        block = nodes.literal_block(text, text, language="text")
        section = nodes.section("", nodes.title("", "", nodes.literal("", name)), block, ids=[f"command-{name}"])
        section["names"] = [f"command-{name}"]
        self.state.document.note_explicit_target(section)
        return section


def setup(app: Sphinx) -> dict[str, object]:
    """Register the directive."""
    app.add_directive("command-help", CommandHelp)
    return {"parallel_read_safe": True}
