"""What every command line shares: arguments from a dataclass, a configuration file beneath them, exit codes."""

from __future__ import annotations

import contextlib
import io
import re
import signal
import sys
import threading
import traceback
import warnings
from collections.abc import Callable, Iterator, Sequence
from typing import TypeVar

import tyro

from ..config import SessionConfig
from ..config.renamed_fields import present_name, renamed_message
from ..config.toml_file import read_toml
from ..core.errors import HookError, SjasimError

T = TypeVar("T")

DONE, BAD_INPUT, INTERRUPTED = 0, 2, 130

JARGON = {
    r"Error parsing (--\S+): invalid literal for int\(\) with base 10: ": r"\1 is to be a whole number, not ",
    r"Error parsing (--\S+): could not convert string to float: ": r"\1 is to be a number, not ",
}
"""What Python says of words that are no numbers, and what a user understands."""


class UsageError(SjasimError):
    """The command line's arguments cannot be understood."""


def main(command: Callable[[Sequence[str]], None], arguments: Sequence[str] | None = None) -> int:
    """Run a command and turn its end into an exit code.

    Args:
        command: takes the arguments; returns when it is done.
        arguments: the command line without the program's name; that of the process if None.

    Returns:
        0 when done, 2 after one line on stderr when the input was bad (and the traceback of a user's own code that
        failed), 130 on Ctrl-C.
    """
    warnings.showwarning = _warn
    try:
        with terminable():
            command(list(sys.argv[1:] if arguments is None else arguments))
    except SjasimError as error:
        sys.stderr.write(f"error: {' '.join(str(error).split())}\n")
        if isinstance(error, HookError):
            traceback.print_exception(error.__cause__, file=sys.stderr)
        return BAD_INPUT
    except KeyboardInterrupt:
        sys.stderr.write("interrupted\n")
        return INTERRUPTED
    return DONE


def _warn(
    message: Warning | str,
    category: type[Warning],
    filename: str,
    lineno: int,
    file: object = None,
    line: str | None = None,
) -> None:
    """Show a warning to a user as one line."""
    sys.stderr.write(f"warning: {message}\n")


@contextlib.contextmanager
def terminable() -> Iterator[None]:
    """While this lasts a request to end (SIGTERM) ends the process tidily: drafts of files and folders are removed."""

    def leave(number: int, frame: object) -> None:
        raise SystemExit(128 + number)

    plain = threading.current_thread() is threading.main_thread() and signal.getsignal(signal.SIGTERM) == signal.SIG_DFL
    if plain:
        signal.signal(signal.SIGTERM, leave)
    try:
        yield
    finally:
        if plain:
            signal.signal(signal.SIGTERM, signal.SIG_DFL)


def parse(options: type[T], arguments: Sequence[str], default: T | None, program: str, about: str) -> T:
    """Read arguments into a dataclass of options; ``--help`` prints and exits with 0.

    Args:
        options: the dataclass.
        arguments: the command line without the program's name.
        default: values of what is not given; None for the dataclass's own.
        program: what the user typed, for the help.
        about: one line for the help.

    Raises:
        UsageError: an argument is unknown or malformed; one line says which.
        ConfigError: a value is out of range.
    """
    arguments = present_flags(arguments)
    said = io.StringIO()
    try:
        with contextlib.redirect_stderr(said):
            return tyro.cli(
                options,
                args=list(arguments),
                default=tyro.MISSING_NONPROP if default is None else default,
                prog=program,
                description=about,
                config=(tyro.conf.FlagCreatePairsOff,),
            )
    except SystemExit as end:
        if end.code in (0, None):
            raise
        raise UsageError(f"{_one_line(said.getvalue())} (see {program} --help)") from None


def present_flags(arguments: Sequence[str]) -> list[str]:
    """The same arguments with the present names of renamed flags; each former one is named on stderr."""
    out = []
    for word in arguments:
        flag, equals, value = word.partition("=")
        field = flag.removeprefix("--").replace("-", "_")
        present = present_name(field) if flag.startswith("--") else field
        if present == field:
            out.append(word)
            continue
        present_flag = f"--{present.replace('_', '-')}"
        sys.stderr.write(f"warning: {renamed_message(flag, present_flag)}\n")
        out.append(present_flag + equals + value)
    return out


def config_from(arguments: Sequence[str]) -> SessionConfig:
    """The configuration that ``--config FILE.toml`` names, which flags then override; the defaults without one.

    Raises:
        ConfigError: the file cannot be read or holds a wrong field.
    """
    for index, word in enumerate(arguments):
        flag, equals, value = word.partition("=")
        if flag == "--config" and (equals or index + 1 < len(arguments)):
            return read_toml(value if equals else arguments[index + 1])
    return SessionConfig()


def counted(count: int, noun: str) -> str:
    """A number of things in words: 1 person, 2 persons."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def _one_line(text: str) -> str:
    """An error box as one line: without its frame, title, rules, and what it says of options at large."""
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith("╭")]
    if len(lines) > 1 and set(lines[1].strip()) == {"-"}:  # a title above its rule: boxes have no frames in ASCII
        lines = lines[2:]
    words = " ".join(re.sub(r"[─│╰╯]+|-{5,}", " ", line) for line in lines if "--help" not in line).split()
    said = " ".join(words).partition(" Argument helptext:")[0]
    said = re.sub(r" Perhaps you meant: (--\S+).*", r"; perhaps you meant \1", said)
    for jargon, plain in JARGON.items():
        said = re.sub(jargon, plain, said)
    return said or "these arguments are not understood"
