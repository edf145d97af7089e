#!/usr/bin/env python3
"""Run any sjasim command on a fresh machine: makes .venv, installs once, then does what was asked.

    python3 scripts/launch.py run --method sia      # python -m sjasim.run --method sia
    python3 scripts/launch.py test                  # pytest

Standard library only, and written so that an old Python can still read it and say what it lacks.
"""

import hashlib
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
VENV = ROOT / ".venv"
STAMP = VENV / "sjasim-install.json"
WINDOWS = os.name == "nt"
PYTHON = VENV / ("Scripts/python.exe" if WINDOWS else "bin/python")
OLDEST = (3, 11)
SIGN_OF_LIFE_S = 20
PROBE = "import json, struct, sys; print(json.dumps([list(sys.version_info[:2]), struct.calcsize('P') * 8]))"
USAGE = """usage: launch.py [--python PYTHON] NAME [ARGS ...]

  launch.py NAME ARGS   python -m sjasim.NAME ARGS inside .venv, which is made and filled first if need be
  launch.py test ARGS   pytest ARGS (without ARGS: -n 2 -m "not slow")
  --python PYTHON       the Python to make .venv with (3.11 or newer, 64 bits)
"""


class ProblemError(Exception):
    """Something the user can put right; its message says how."""


def main(arguments: list) -> int:
    """Install if need be, run the command, return its exit code."""
    python, name, rest = split_arguments(arguments)
    if name in ("", "-h", "--help"):
        (sys.stdout if name else sys.stderr).write(USAGE + "commands: " + ", ".join(commands()) + "\n")
        return 0 if name else 2
    try:
        command = command_line(name, rest)
        install(python)
    except ProblemError as problem:
        say(f"error: {problem}")
        return 2
    return run(command, ROOT if name == "test" else Path.cwd())


def split_arguments(arguments: list) -> tuple:
    """(Python to use or "", command name or "", the command's own arguments)."""
    python = ""
    rest = list(arguments)
    if rest and rest[0].startswith("--python"):
        flag, equals, value = rest.pop(0).partition("=")
        python = value if equals else (rest.pop(0) if rest else "")
        if flag != "--python" or not python:
            return "", "", []
    return python, (rest[0] if rest else ""), rest[1:]


def commands() -> list:
    """Names that can be asked for: sjasim's modules with a command line, and ``test``."""
    modules = sorted((ROOT / "sjasim").glob("*.py"))
    return [path.stem for path in modules if "__main__" in path.read_text(encoding="utf-8")] + ["test"]


def command_line(name: str, rest: list) -> list:
    """Words of the command inside .venv.

    Raises:
        ProblemError: there is no such command.
    """
    if name not in commands():
        raise ProblemError(f"no command named {name!r}: known are {', '.join(commands())}")
    if name == "test":
        return [str(PYTHON), "-m", "pytest", *(rest or ["-n", "2", "-m", "not slow"])]
    return [str(PYTHON), "-m", f"sjasim.{name}", *rest]


def install(python: str) -> None:
    """Make .venv and fill it, unless it holds this very project state already.

    The stamp is written last, so that an interrupted installation is done again.
    """
    stamp = {"project": fingerprint(), "python": base_python(python) if python else ""}
    known = read_stamp()
    if PYTHON.exists() and known.get("project") == stamp["project"] and python_matches(known, python):
        return
    chosen = python or sys.executable
    check_python(chosen)
    say("sjasim: first use here, or the project's dependencies changed.")
    say(f"sjasim: installing into {VENV} (about 1.7 GB; a minute or two, less with uv). Nothing outside is touched.")
    uv = shutil.which("uv")
    if not usable(uv) or not python_matches(known, python):
        make_venv(chosen, uv)
    STAMP.unlink() if STAMP.exists() else None
    installer = [uv, "pip", "install", "--python", str(PYTHON)] if uv else [str(PYTHON), "-m", "pip", "install"]
    # No byte-compiling of 1.7 GB beforehand: Python compiles what is used when it is used.
    quiet = ["--quiet"] if uv else ["--quiet", "--no-compile", "--disable-pip-version-check"]
    target = ["-e", f"{ROOT}[test,dev,plots,video,train]", "-c", str(ROOT / "constraints.txt")]
    call([*installer, *quiet, *target], "the installation failed (see above); the same command tries again")
    stamp["python"] = base_python(chosen)
    STAMP.write_text(json.dumps(stamp), encoding="utf-8")
    say("sjasim: installed.")


def fingerprint() -> str:
    """Hash of what an installation depends on: the project's two files and where it lies."""
    digest = hashlib.sha256(str(ROOT).encode())
    for name in ("pyproject.toml", "constraints.txt"):
        digest.update((ROOT / name).read_bytes())
    return digest.hexdigest()


def read_stamp() -> dict:
    """What the last whole installation left; empty when there was none."""
    try:
        stamp = json.loads(STAMP.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return stamp if isinstance(stamp, dict) else {}


def python_matches(known: dict, python: str) -> bool:
    """Whether .venv was made with the Python asked for; true when none was asked for."""
    return not python or known.get("python") == base_python(python)


def base_python(python: str) -> str:
    """Full path of an interpreter, so that two names of one Python compare equal."""
    found = shutil.which(python)
    if found is None:
        raise ProblemError(f"--python {python}: no such program")
    return os.path.realpath(found)


def check_python(python: str) -> None:
    """Refuse an interpreter that sjasim cannot run on.

    Raises:
        ProblemError: it does not start, is older than 3.11 or has 32 bits.
    """
    try:
        answer = subprocess.run([python, "-c", PROBE], stdout=subprocess.PIPE, check=True).stdout
        version, bits = json.loads(answer.decode())
    except (OSError, ValueError, subprocess.CalledProcessError):
        raise ProblemError(f"{python} is not a working Python; name another with --python") from None
    needed = "sjasim needs 64-bit Python {}.{} or newer".format(*OLDEST)
    if tuple(version) < OLDEST:
        raise ProblemError(f"{python} is Python {version[0]}.{version[1]}; {needed}{other_pythons()}")
    if bits != 64:
        raise ProblemError(f"{python} is a {bits}-bit Python; {needed}")


def other_pythons() -> str:
    """A hint at newer interpreters on the path, or at where to say one."""
    found = [name for name in (f"python3.{minor}" for minor in range(14, 10, -1)) if shutil.which(name)]
    return f": try --python {found[0]}" if found else "; name one with --python"


def usable(uv: object) -> bool:
    """Whether .venv can be installed into: its Python starts, and has pip where uv is missing."""
    probe = "import sys" if uv else "import pip"
    return PYTHON.exists() and subprocess.call([str(PYTHON), "-c", probe], stderr=subprocess.DEVNULL) == 0


def make_venv(python: str, uv: object) -> None:
    """Make .venv anew with uv or the standard library.

    Raises:
        ProblemError: the Python lacks venv or ensurepip, or the folder cannot be written.
    """
    if VENV.exists():
        shutil.rmtree(str(VENV), ignore_errors=True)
    if uv:
        call([uv, "venv", "--quiet", "--seed", "--python", python, str(VENV)], "uv could not make .venv (see above)")
        return
    if subprocess.call([python, "-c", "import venv, ensurepip"], stderr=subprocess.DEVNULL) != 0:
        raise ProblemError(f"{python} lacks venv or ensurepip: on Debian or Ubuntu, apt-get install python3-venv")
    call([python, "-m", "venv", str(VENV)], f"{VENV} could not be made (see above)")


def call(command: list, complaint: str) -> None:
    """Run a step of the installation, its chatter on stderr so that stdout stays the command's own.

    A step that takes long says so from time to time.
    """
    waited_s = 0
    with subprocess.Popen(command, stdout=2) as process:
        while True:
            try:
                code = process.wait(timeout=SIGN_OF_LIFE_S)
                break
            except subprocess.TimeoutExpired:
                waited_s += SIGN_OF_LIFE_S
                say(f"sjasim: still at it after {waited_s} s")
    if code != 0:
        raise ProblemError(complaint)


def run(command: list, folder: Path) -> int:
    """Run the command, wait for it, and return its exit code; a Ctrl-C reaches it too and gives 130."""
    process = subprocess.Popen(command, cwd=str(folder))
    while True:
        try:
            code = process.wait()
        except KeyboardInterrupt:
            continue
        return 128 - code if code < 0 else code


def say(text: str) -> None:
    """One line for people."""
    sys.stderr.write(text + "\n")
    sys.stderr.flush()


if __name__ == "__main__":
    try:
        sys.exit(main(sys.argv[1:]))
    except KeyboardInterrupt:
        sys.exit(130)
