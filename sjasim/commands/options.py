"""Reads a command line into a dataclass of options."""

from __future__ import annotations

import contextlib
import io
import re
import shutil
import sys
import textwrap
from collections.abc import Sequence
from typing import TextIO, TypeVar

import tyro

from ..core.errors import SjasimError
from .flags import Flags
from .former_flags import present_flags

T = TypeVar("T")

PLAIN_WORDS = {
    r"Error parsing (--\S+): invalid literal for int\(\) with base 10: ": r"\1 must be a whole number, not ",
    r"Error parsing (--\S+): could not convert string to float: ": r"\1 must be a number, not ",
    r"^Missing from .*?: (\S+) (.*?)\.? \(required\).*": r"\1 is missing: \2",
    r"^Missing value for argument '(--\S+)'\..*": r"\1 needs a value",
    r"^Unrecognized options: ": "unknown options: ",
}
"""Pattern of an error message of Python or tyro -> message that users of the command line understand."""

HELP_WIDTH = 80
"""Widest line of the text above the options in a command's help."""

_COLOURS = r"(?:\x1b\[[\d;]*m)*"
"""Pattern of terminal codes that change colours."""


class UsageError(SjasimError):
    """The command line's arguments cannot be understood."""


def parse(options: type[T], arguments: Sequence[str], default: T | None, program: str, about: str) -> T:
    """Read arguments into a dataclass of options; ``--help`` prints and exits with 0.

    Args:
        options: the dataclass; see `Flags` for what its fields become.
        arguments: the command line without the program's name.
        default: values of what is not given; None for the dataclass's own.
        program: what the user typed, for the help and for messages.
        about: what the command does, for the help.

    Raises:
        UsageError: an argument is unknown or malformed; one line says which.
        ConfigError: a value is out of range.
    """
    return parse_flags(Flags(options, default), present_flags(arguments), program, about)


def parse_flags(flags: Flags[T], arguments: Sequence[str], program: str, about: str) -> T:
    """Read arguments whose flags have their present names; see `parse`."""
    errors = io.StringIO()
    printed = _HelpStream(sys.stdout)
    try:
        with contextlib.redirect_stderr(errors), contextlib.redirect_stdout(printed):
            parsed: object = tyro.cli(
                flags.parsed_type,
                args=list(arguments),
                prog=program,
                description=about,
                config=(tyro.conf.FlagCreatePairsOff,),
            )
    except SystemExit as end:
        if end.code in (0, None):
            sys.stdout.write(_edited_help(printed.getvalue(), about))
            raise
        raise UsageError(f"{_one_line(errors.getvalue())} (see {program} --help)") from None
    return flags.options(parsed)


class _HelpStream(io.StringIO):
    """Collects a help text that looks as it does on another stream: in colour on a terminal only.

    Args:
        stream: the other stream.
    """

    def __init__(self, stream: TextIO) -> None:
        super().__init__()
        self._stream = stream

    @property
    def encoding(self) -> str:  # type: ignore[override]
        """Encoding of the other stream, which decides whether there are box-drawing characters."""
        return self._stream.encoding or "ascii"

    def isatty(self) -> bool:
        """Whether the other stream is a terminal."""
        return self._stream.isatty()


def _edited_help(text: str, about: str) -> str:
    """Tyro's help with what the command does in lines that fit, and without a group titled "x-options options"."""
    width = min(HELP_WIDTH, shutil.get_terminal_size().columns)
    usage, _, rest = text.partition("\n")
    usage = textwrap.fill(usage, width, subsequent_indent=" " * len("usage: "), break_on_hyphens=False)
    text = f"{usage}\n{rest}".replace(about, textwrap.fill(about, width), 1)
    # In a frame the rule behind the title grows by the eight characters that the title loses.
    text = re.sub(rf"-options({_COLOURS} options{_COLOURS} {_COLOURS})(?=─)", rf"\1{'─' * 8}", text)
    return text.replace("-options options", " options")


def _one_line(text: str) -> str:
    """Tyro's error box as one line: without its frame, its title, and what it says of options at large."""
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith("╭")]
    # Where the terminal has no box-drawing characters, the title stands above a rule of dashes.
    if len(lines) > 1 and set(lines[1].strip()) == {"-"}:
        lines = lines[2:]

    words = " ".join(re.sub(r"[─│╰╯]+|-{5,}", " ", line) for line in lines if "--help" not in line).split()
    message = " ".join(words).partition(" Argument helptext:")[0]
    message = re.sub(r" Perhaps you meant: (--\S+).*", r"; perhaps you meant \1", message)
    for pattern, plain in PLAIN_WORDS.items():
        message = re.sub(pattern, plain, message)
    return message or "these arguments are not understood"
