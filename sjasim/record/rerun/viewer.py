"""Rerun's viewer as a process of ours: it listens on this machine only, and ends when we say so."""

from __future__ import annotations

import contextlib
import os
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import IO

import rerun as rr

from ...core.errors import RecordError
from .scene import TIMELINE

HERE = "127.0.0.1"
START_S = 30.0
"""How long the viewer may take to answer."""

END_S = 5.0
"""How long it may take to end once it answers no more."""


def executable() -> Path:
    """The viewer that comes with rerun's package.

    Raises:
        RecordError: the package has none.
    """
    import rerun_cli

    path = Path(rerun_cli.__file__).with_name("rerun.exe" if sys.platform.startswith("win") else "rerun")
    if not path.exists():
        raise RecordError(f"rerun's viewer is missing ({path}): install rerun-sdk anew")
    return path


def start(
    *files: Path, headless: bool = False, port: int = 0, bind: str = HERE, size: str = "", log: IO[bytes] | None = None
) -> tuple[subprocess.Popen[bytes], str]:
    """Start a viewer.

    Args:
        files: recordings to open.
        headless: without a window.
        port: where it listens; 0 for a free one.
        bind: address it listens on.
        size: of a headless viewer, such as ``1920x1080``.
        log: where what it says goes; nowhere by default.

    Returns:
        the process and the address that streams and clients connect to.
    """
    port = port or free_port()
    words = [str(executable()), *map(str, files), "--bind", bind, "--port", str(port), "--hide-welcome-screen"]
    words += (["--headless"] if headless else []) + (["--window-size", size] if size else [])
    sink = log if log is not None else subprocess.DEVNULL
    process = subprocess.Popen(words, stdout=sink, stderr=sink)
    return process, f"rerun+http://{HERE}:{port}/proxy"


def screenshot(recording: Path, picture: Path, t_s: float, size: str = "1920x1080", settle_s: float = 3.0) -> list[str]:
    """A picture of a recording in the viewer, without a display.

    Args:
        recording: the .rrd file.
        picture: the .png file, which is replaced.
        t_s: session time to show.
        size: of the window.
        settle_s: how long the viewer has to draw.

    Returns:
        what the viewer reports about its views; empty if all is well.

    Raises:
        RecordError: the viewer does not start, or has nothing to draw with.
    """
    with running(size) as url:
        client = rr.experimental.ViewerClient.connect(url)
        client.open(str(recording.absolute()))
        deadline = time.monotonic() + START_S
        while not client.get_state().recordings and time.monotonic() < deadline:
            time.sleep(0.2)
        time.sleep(settle_s / 2)
        client.set_time(TIMELINE, duration=t_s, play_state="paused")
        time.sleep(settle_s)
        client.save_screenshot(str(picture.absolute()))
        return [f"{view.name}: {report}" for view in client.get_state().views for report in view.reports]


@contextlib.contextmanager
def running(size: str = "1920x1080") -> Iterator[str]:
    """A viewer without a window, for as long as it is needed; gives its address.

    Raises:
        RecordError: it does not start, has nothing to draw with, or ends while it is needed.
    """
    import tempfile

    with tempfile.TemporaryFile() as said:
        process, url = start(headless=True, size=size, log=said)
        try:
            wait_until_ready(process, url, said)
            yield url
        except ConnectionError as error:  # it may answer once and find only then that it cannot draw
            raise RecordError(_silence(process, said, error)) from None
        finally:
            process.terminate()
            try:
                process.wait(10)
            except subprocess.TimeoutExpired:
                process.kill()


def wait_until_ready(process: subprocess.Popen[bytes], url: str, said: IO[bytes] | None = None) -> None:
    """Wait until a viewer answers.

    Args:
        process: the viewer.
        url: its address.
        said: where its words went.

    Raises:
        RecordError: it ends at once, or stays silent.
    """
    deadline = time.monotonic() + START_S
    while time.monotonic() < deadline:
        if process.poll() is not None:
            raise RecordError("rerun's viewer ended at once" if said is None else _reason(said))
        with contextlib.suppress(Exception):
            rr.experimental.ViewerClient.connect(url).get_state()
            return
        time.sleep(0.3)
    raise RecordError(f"rerun's viewer did not answer within {START_S:g} s")


def _silence(process: subprocess.Popen[bytes], said: IO[bytes], error: ConnectionError) -> str:
    """Why a viewer that has answered does so no more: its own last words if it has ended."""
    try:
        process.wait(END_S)
    except subprocess.TimeoutExpired:
        return f"rerun's viewer answers no more: {error}"
    return _reason(said)


def _reason(said: IO[bytes]) -> str:
    said.seek(0)
    words = said.read().decode(errors="replace")
    drawing = any(word in words for word in ("render context", "adapter", "Vulkan", "wgpu"))
    last = next((line.strip() for line in reversed(words.splitlines()) if line.strip()), "no reason given")
    if drawing:
        return (
            "rerun's viewer has nothing to draw with: on Debian and Ubuntu install mesa-vulkan-drivers "
            "(apt-get install mesa-vulkan-drivers)"
        )
    return f"rerun's viewer ended at once: {last}"


def free_port() -> int:
    """A port that nobody listens on."""
    with socket.socket() as door:
        door.bind((HERE, 0))
        return int(door.getsockname()[1])


def check_display(instead: str) -> None:
    """Make sure that a window can be opened.

    Raises:
        RecordError: there is no display; ``instead`` says what to do.
    """
    if sys.platform.startswith("linux") and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        raise RecordError(f"there is no display for rerun's viewer; {instead}")
