"""Entry point of every command: runs it and turns its end into an exit code."""

from __future__ import annotations

import contextlib
import signal
import sys
import threading
import traceback
import warnings
from collections.abc import Callable, Iterator, Sequence

from ..core.errors import HookError, SjasimError

DONE = 0
"""Exit code of a command that did what was asked."""

BAD_INPUT = 2
"""Exit code after wrong arguments, a wrong file, or a plug-in that failed."""

INTERRUPTED = 130
"""Exit code after Ctrl-C, as shells use it."""


def main(command: Callable[[Sequence[str]], None], arguments: Sequence[str] | None = None) -> int:
    """Run a command and return its exit code.

    Args:
        command: takes the arguments; returns when it is done.
        arguments: the command line without the program's name; that of the process if None.

    Returns:
        0 when done; 2 after one line on stderr when the input was bad, followed by the traceback where a user's own
        code failed; 130 on Ctrl-C.
    """
    warnings.showwarning = _print_warning
    try:
        with sigterm_as_exit():
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


@contextlib.contextmanager
def sigterm_as_exit() -> Iterator[None]:
    """Raise `SystemExit` on SIGTERM inside the block, so that unfinished files and folders are removed.

    A handler that the caller has installed is left alone.
    """

    def leave(number: int, frame: object) -> None:
        raise SystemExit(128 + number)

    # Python allows signal handlers in the main thread only.
    in_main_thread = threading.current_thread() is threading.main_thread()
    replace = in_main_thread and signal.getsignal(signal.SIGTERM) == signal.SIG_DFL

    if replace:
        signal.signal(signal.SIGTERM, leave)
    try:
        yield
    finally:
        if replace:
            signal.signal(signal.SIGTERM, signal.SIG_DFL)


def _print_warning(
    message: Warning | str,
    category: type[Warning],
    filename: str,
    lineno: int,
    file: object = None,
    line: str | None = None,
) -> None:
    """Print a warning as one line, without the place in the code that means nothing to a user."""
    sys.stderr.write(f"warning: {message}\n")
