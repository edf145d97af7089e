"""``python -m sjasim.run``: simulate one session, print its figures, and write it to a folder if one is named."""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

from rich.console import Console

from .commands.flags import INLINE, Metavar
from .commands.main import main
from .commands.result_table import print_session
from .commands.session_options import parse_session
from .config import SessionConfig
from .studies.single_session import SessionOutputs, recorded_session, with_policy

ABOUT = "Simulate one session of dancers, sensors, server and robot, and print its figures as a table."

FIRST = ("method", "humans", "seed", "dancers", "sensing", "out", "view", "video")
"""Options that come first in the help."""


@dataclass(frozen=True)
class Options:
    """Options of this command.

    Attributes:
        session: configuration of the session.
        outputs: what is kept or shown.
        policy: npz file of a trained policy, for ``--method learned``.
        json: print session.json on stdout, and nothing else.
        config: TOML file with fields of the configuration; flags override it.
    """

    session: Annotated[SessionConfig, INLINE]
    outputs: Annotated[SessionOutputs, INLINE] = field(default_factory=SessionOutputs)
    policy: Annotated[Path | None, Metavar("FILE.npz")] = None
    json: bool = False
    config: Annotated[Path | None, Metavar("FILE.toml")] = None


def command(arguments: Sequence[str], program: str = "python -m sjasim.run") -> None:
    """Simulate the session that the arguments describe."""
    options = parse_session(Options, arguments, program, ABOUT, FIRST)
    config = with_policy(options.session, options.policy)
    with recorded_session(config, options.outputs) as summary:
        if options.json:
            sys.stdout.write(json.dumps(summary, indent=1, allow_nan=False) + "\n")
        else:
            print_session(summary, Console())


if __name__ == "__main__":
    sys.exit(main(command))
