#!/usr/bin/env python3
"""Install sjasim into .venv if necessary, then run one of its commands there.

    python3 scripts/launch.py run --method sia      # python -m sjasim.run --method sia
    python3 scripts/launch.py test                  # pytest

The file needs only the standard library. It also avoids syntax newer than Python 3.6, so that an old interpreter can
read it and report what is missing.
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
PROGRESS_S = 20
PROBE = "import json, struct, sys; print(json.dumps([list(sys.version_info[:2]), struct.calcsize('P') * 8]))"

SETS = ("run", "optional", "test")
"""Package sets, smallest first; requirements/NAME.txt lists a set, and each set contains those before it."""

COMPILED_PARTS = ("session", "skeletons")
"""Parts of sjasim.simulation.precompile, each compiled by a process of its own."""

OPTIONAL = ("--plots", "--video", "--mcap")
"""Options of commands that need the packages of the set "optional"."""

USAGE = """usage: launch.py [--python PYTHON] NAME [ARGS ...]

  launch.py NAME ARGS   run python -m sjasim.NAME ARGS inside .venv; make and fill .venv first if necessary
  launch.py test ARGS   run pytest ARGS (without ARGS: -n 2 -m "not slow")
  --python PYTHON       Python interpreter to make .venv with (3.11 or newer, 64 bits)
"""


class ProblemError(Exception):
    """A problem that the user can solve; the message says how."""


def main(arguments: list) -> int:
    """Install if necessary, run the command, and return its exit code."""
    python, name, rest = split_arguments(arguments)

    if name in ("", "-h", "--help"):
        stream = sys.stdout if name else sys.stderr
        stream.write(USAGE + "commands: " + ", ".join(commands()) + "\n")
        return 0 if name else 2

    try:
        command = command_line(name, rest)
        install(python, needed_set(name, rest))
    except ProblemError as problem:
        say(f"error: {problem}")
        return 2

    # The tests expect the project's folder; the other commands read and write where the user is.
    return run(command, ROOT if name == "test" else Path.cwd())


def split_arguments(arguments: list) -> tuple:
    """Return the interpreter to use, the command's name and the command's own arguments.

    The interpreter is "" if none was given; the name is "" if it is missing or ``--python`` is malformed.
    """
    python = ""
    rest = list(arguments)

    if rest and rest[0].startswith("--python"):
        flag, equals, value = rest.pop(0).partition("=")
        if not equals:
            value = rest.pop(0) if rest else ""
        if flag != "--python" or not value:
            return "", "", []
        python = value

    return python, (rest[0] if rest else ""), rest[1:]


def commands() -> list:
    """Return the names of all commands: the modules of sjasim that can be run, and ``test``."""
    modules = sorted((ROOT / "sjasim").glob("[!_]*.py"))
    return [path.stem for path in modules if "__main__" in path.read_text(encoding="utf-8")] + ["test"]


def command_line(name: str, rest: list) -> list:
    """Return the command as a list of words that start with the Python of .venv.

    Raises:
        ProblemError: there is no such command.
    """
    if name not in commands():
        raise ProblemError(f"no command named {name!r}: known are {', '.join(commands())}")
    if name == "test":
        return [str(PYTHON), "-m", "pytest", *(rest or ["-n", "2", "-m", "not slow"])]
    return [str(PYTHON), "-m", f"sjasim.{name}", *rest]


def needed_set(name: str, rest: list) -> str:
    """Return the smallest package set that the command needs."""
    if name == "test":
        return "test"
    if any(word.partition("=")[0] in OPTIONAL for word in rest):
        return "optional"
    return "run"


def install(python: str, wanted: str) -> None:
    """Make .venv and install a package set, unless .venv already holds it.

    Args:
        python: the interpreter to make .venv with; "" keeps that of an existing .venv.
        wanted: the name of the set.

    Raises:
        ProblemError: the interpreter cannot be used, or a step of the installation failed.
    """
    known = read_stamp()
    project = fingerprint()
    same_python = python_matches(known, python)
    complete = PYTHON.exists() and known.get("project") == project
    if complete and same_python and larger_set(known, wanted) == known.get("set"):
        return

    chosen = python or sys.executable
    check_python(chosen)
    uv = shutil.which("uv")
    if not usable(uv) or not same_python:
        announce(wanted)
        make_venv(chosen, uv)
        known = {"python": base_python(chosen)}
    else:
        say(f"sjasim: bringing {VENV} up to date.")

    # Without the project's hash the stamp marks an interrupted installation, which the next command continues.
    known.pop("project", None)
    write_stamp(known)

    # The packages of a larger set stay installed, so they must follow the lock files as well.
    complete_set = larger_set(known, wanted)
    *first, last = stages(complete_set)
    for stage in first:
        install_stage(uv, stage)

    # The last stage mostly waits for downloads and the disk, so the processor is free for compiling.
    compilers = [] if known.get("compiled") == project else start_compiling()
    try:
        install_stage(uv, last)
        wait_for(compilers)
    finally:
        for process in compilers:
            process.kill()

    write_stamp({**known, "project": project, "compiled": project, "set": complete_set})
    say("sjasim: installed.")


def install_stage(uv: object, stage: tuple) -> None:
    """Carry out one stage of the installation.

    Raises:
        ProblemError: the installer failed.
    """
    title, arguments = stage
    say(f"sjasim: installing {title}")
    call([*installer(uv), *arguments], "the installation failed (see above); the same command tries again")


def start_compiling() -> list:
    """Start the processes that compile sjasim's functions for this machine, one for each part.

    What they leave out, the first session compiles.
    """
    commands = [[str(PYTHON), "-m", "sjasim.simulation.precompile", part] for part in COMPILED_PARTS]
    return [
        subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, cwd=str(ROOT))
        for command in commands
    ]


def wait_for(processes: list) -> None:
    """Wait until processes have ended, and report from time to time that they still run."""
    if any(process.poll() is None for process in processes):
        say("sjasim: compiling for this machine, the first time only")
    for process in processes:
        while True:
            try:
                process.wait(timeout=PROGRESS_S)
                break
            except subprocess.TimeoutExpired:
                say("sjasim: still compiling")
    if any(process.returncode != 0 for process in processes):
        say("sjasim: not everything could be compiled ahead; the first session compiles the rest")


def stages(wanted: str) -> list:
    """Return the stages of an installation, each a title and the arguments of the installer.

    The first two stages are enough to simulate a session; the third installs the rest of the set.
    """
    # The build tools come with the first stage, so that the package itself fetches nothing.
    package = ["--no-index", "--no-deps", "--no-build-isolation", "-e", str(ROOT)]
    rest = {
        "run": "recording and viewer",
        "optional": "recording, viewer, plots and video",
        "test": "all other packages",
    }
    return [
        ("1 of 3: numerics and physics", locked("simulation")),
        ("2 of 3: sjasim itself", package),
        (f"3 of 3: {rest[wanted]}", locked(wanted)),
    ]


def locked(name: str) -> list:
    """Return the installer's arguments for a lock file; a file with another hash than the locked one is refused."""
    return ["--require-hashes", "-r", str(ROOT / "requirements" / f"{name}.txt")]


def installer(uv: object) -> list:
    """Return the command that installs into .venv: uv if it is on the path, else pip."""
    if uv:
        return [uv, "pip", "install", "--python", str(PYTHON), "--quiet"]
    # Compiling every module of every package takes long, and Python does it on first use anyway.
    quiet = ["--quiet", "--no-compile", "--disable-pip-version-check"]
    return [str(PYTHON), "-m", "pip", "install", *quiet]


def announce(wanted: str) -> None:
    """Say where a new installation goes and what it takes."""
    size, duration = ("2.3 GB", "a minute or two") if wanted == "test" else ("1.3 GB", "about a minute")
    say(f"sjasim: first use here. Installing into {VENV}; nothing else is changed.")
    say(f"sjasim: this needs {size} of disk and {duration}, less with uv.")


def fingerprint() -> str:
    """Return a hash of what an installation depends on: the project's folder, pyproject.toml and the lock files."""
    digest = hashlib.sha256(str(ROOT).encode())
    for path in [ROOT / "pyproject.toml", *sorted((ROOT / "requirements").glob("*.txt"))]:
        digest.update(path.read_bytes())
    return digest.hexdigest()


def read_stamp() -> dict:
    """Return what the last installation recorded; empty if there was none."""
    try:
        stamp = json.loads(STAMP.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return stamp if isinstance(stamp, dict) else {}


def write_stamp(stamp: dict) -> None:
    """Record the interpreter of .venv, and of a complete installation its set and the project's hash."""
    STAMP.write_text(json.dumps(stamp), encoding="utf-8")


def larger_set(known: dict, wanted: str) -> str:
    """Return the larger of the installed set and the wanted one."""
    installed = known.get("set")
    return max(installed, wanted, key=SETS.index) if installed in SETS else wanted


def python_matches(known: dict, python: str) -> bool:
    """Return whether .venv was made with the interpreter asked for; true if none was asked for."""
    return not python or known.get("python") == base_python(python)


def base_python(python: str) -> str:
    """Return the full path of an interpreter, so that two names of one interpreter compare equal.

    Raises:
        ProblemError: there is no such program.
    """
    found = shutil.which(python)
    if found is None:
        raise ProblemError(f"--python {python}: no such program")
    return os.path.realpath(found)


def check_python(python: str) -> None:
    """Check that sjasim can run on an interpreter.

    Raises:
        ProblemError: it does not start, is older than 3.11, or has 32 bits.
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
    """Return the end of an error message: a newer interpreter on the path, or how to name one."""
    found = [name for name in (f"python3.{minor}" for minor in range(14, 10, -1)) if shutil.which(name)]
    return f": try --python {found[0]}" if found else "; name one with --python"


def usable(uv: object) -> bool:
    """Return whether packages can be installed into .venv: its Python starts, and has pip if there is no uv."""
    probe = "import sys" if uv else "import pip"
    return PYTHON.exists() and subprocess.call([str(PYTHON), "-c", probe], stderr=subprocess.DEVNULL) == 0


def make_venv(python: str, uv: object) -> None:
    """Make .venv with uv or the standard library, in place of one that exists.

    Raises:
        ProblemError: the interpreter lacks venv or ensurepip, or the folder cannot be written.
    """
    if VENV.exists():
        shutil.rmtree(str(VENV), ignore_errors=True)

    if uv:
        # With pip as well, so that users can add packages of their own, and uv may go away again.
        call([uv, "venv", "--quiet", "--seed", "--python", python, str(VENV)], "uv could not make .venv (see above)")
        return

    # Debian and Ubuntu deliver Python without these two.
    if subprocess.call([python, "-c", "import venv, ensurepip"], stderr=subprocess.DEVNULL) != 0:
        raise ProblemError(f"{python} lacks venv or ensurepip: on Debian or Ubuntu, apt-get install python3-venv")
    call([python, "-m", "venv", str(VENV)], f"{VENV} could not be made (see above)")


def call(command: list, complaint: str) -> None:
    """Run one step of the installation and report from time to time that it still runs.

    Its output goes to stderr, because stdout belongs to the command that the user asked for.

    Raises:
        ProblemError: the step failed; the message is the complaint.
    """
    waited_s = 0
    with subprocess.Popen(command, stdout=2) as process:
        while True:
            try:
                code = process.wait(timeout=PROGRESS_S)
                break
            except subprocess.TimeoutExpired:
                waited_s += PROGRESS_S
                say(f"sjasim: this step has taken {waited_s} s so far")

    if code != 0:
        raise ProblemError(complaint)


def run(command: list, folder: Path) -> int:
    """Run the command in a folder and return its exit code; 128 plus the signal's number if a signal ended it."""
    process = subprocess.Popen(command, cwd=str(folder))
    while True:
        try:
            code = process.wait()
        except KeyboardInterrupt:
            # Ctrl-C reaches the command as well, which decides how to end.
            continue
        return 128 - code if code < 0 else code


def say(text: str) -> None:
    """Write one line for the user to stderr."""
    sys.stderr.write(text + "\n")
    sys.stderr.flush()


if __name__ == "__main__":
    try:
        sys.exit(main(sys.argv[1:]))
    except KeyboardInterrupt:
        sys.exit(130)
