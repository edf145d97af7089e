"""Replaces flags by their present names, with one warning line for each former one."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from ..config.renamed_fields import RENAMED_SIA_OPTIONS, present_name, renamed_message

METHOD_OPTIONS = "--method-options"


def present_flags(arguments: Sequence[str], method: str = "") -> list[str]:
    """The same arguments with the present names of renamed flags; a warning line on stderr names each former one.

    Args:
        arguments: the command line without the program's name.
        method: the session's anticipation method, whose own options may have been renamed.
    """
    out: list[str] = []
    renamed: dict[str, str] = {}

    for word in _one_flag_each(arguments, renamed, method):
        flag, equals, value = word.partition("=")
        present = _present_flag(flag, method)
        if present != flag:
            renamed.setdefault(flag, present)
        out.append(present + equals + value)

    for former, present in renamed.items():
        sys.stderr.write(f"warning: {renamed_message(former, present)}\n")
    return out


def _present_flag(flag: str, method: str) -> str:
    """Present name of a flag; the word itself if it is no flag or has not been renamed."""
    if not flag.startswith("--"):
        return flag

    field = flag.removeprefix("--").replace("-", "_")
    present = RENAMED_SIA_OPTIONS.get(field, field) if method == "sia" else field
    present = present_name(present)
    # A flag that has not been renamed stays as it was typed, with underscores or hyphens.
    return flag if present == field else f"--{present.replace('_', '-')}"


def _one_flag_each(arguments: Sequence[str], renamed: dict[str, str], method: str) -> list[str]:
    """Replace the former ``--method-options NAME VALUE NAME VALUE ...`` by one flag for each option."""
    out: list[str] = []
    words = list(arguments)

    while words:
        word = words.pop(0)
        if word != METHOD_OPTIONS:
            out.append(word)
            continue

        while len(words) >= 2 and not words[0].startswith("--"):
            name = words.pop(0)
            value = words.pop(0)
            flag = _present_flag(f"{METHOD_OPTIONS}.{name.replace('_', '-')}", method)
            renamed[f"{METHOD_OPTIONS} {name}"] = flag
            out.append(f"{flag}={value}")  # in one word, as the value may be a negative number
    return out
