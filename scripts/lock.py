#!/usr/bin/env python3
"""Write the lock files in requirements/: the exact version and the hashes of every package that is installed.

    python scripts/lock.py                                # after a change of pyproject.toml
    python scripts/lock.py --upgrade-package rerun-sdk    # take the newest version of one package
    python scripts/lock.py --upgrade                      # take the newest version of all packages

Needs uv on the path. Versions that still satisfy pyproject.toml stay, unless an option says otherwise, and
requirements/numerics.in holds the four packages that simulated figures depend on. The files hold for Python 3.11 and
newer on Linux, macOS and Windows, and name no package index.
"""

import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PACKAGE = ["pyproject.toml", "--group=build"]
OPTIONAL = [*PACKAGE, "--extra=plots", "--extra=video", "--extra=ros"]
SETS = {
    "test": [*OPTIONAL, "--extra=train", "--group=dev"],
    "optional": OPTIONAL,
    "run": PACKAGE,
    "simulation": ["--group=simulation", "--group=build"],
}
"""Lock file -> what it is made of: the package's dependencies, extras, groups. Each set contains those below it."""

COMPILE = ["pip", "compile", "--universal", "--python-version=3.11", "--generate-hashes"]
QUIET = ["--quiet", "--no-header", "--no-emit-index-url", "--no-emit-find-links"]


def main(options: list[str]) -> int:
    """Lock the largest set first, then the smaller ones with the same versions."""
    uv = shutil.which("uv")
    if uv is None:
        sys.stderr.write("error: uv is not on the path: pip install uv\n")
        return 2

    fixed = "requirements/numerics.in"
    for name, contents in SETS.items():
        files = [f"--constraints={fixed}", f"--output-file=requirements/{name}.txt"]
        command = [uv, *COMPILE, *QUIET, *contents, *files, *options]
        code = subprocess.call(command, cwd=ROOT, stdout=subprocess.DEVNULL)
        if code != 0:
            return code

        # The smaller sets take their versions from the largest.
        fixed = "requirements/test.txt"
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
