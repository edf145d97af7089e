"""Runs rerun's viewer as a child process, with or without a window."""

from __future__ import annotations

import contextlib
import os
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import IO

import rerun as rr

from ...core.errors import RecordError
from .entity_stream import TIMELINE

LOCALHOST = "127.0.0.1"

START_TIMEOUT_S = 30.0
"""Longest time until a new viewer answers, or has opened a recording [s]."""

DRAWING_TRIES = 4
"""Times that a viewer is asked for a picture; each time, rerun's client waits 15 s for it."""

END_TIMEOUT_S = 5.0
"""Longest time until a viewer that no longer answers has ended [s]."""


def executable() -> Path:
    """Path of the viewer that rerun's package contains.

    Raises:
        RecordError: the package contains none.
    """
    import rerun_cli

    path = Path(rerun_cli.__file__).with_name("rerun.exe" if sys.platform.startswith("win") else "rerun")
    if not path.exists():
        raise RecordError(f"rerun's viewer is missing ({path}): install rerun-sdk anew")
    return path


def start(
    *files: Path,
    headless: bool = False,
    port: int = 0,
    bind: str = LOCALHOST,
    size: str = "",
    log: IO[bytes] | None = None,
) -> tuple[subprocess.Popen[bytes], str]:
    """Start a viewer.

    Args:
        files: recordings to open.
        headless: run without a window.
        port: port to listen on; 0 for a free one.
        bind: address to listen on.
        size: window size, such as ``1920x1080``; "" for the viewer's default.
        log: file that receives the viewer's output; by default it is discarded.

    Returns:
        The process, and the address to which streams and clients connect.
    """
    port = port or free_port()
    command = [str(executable()), *map(str, files), "--bind", bind, "--port", str(port), "--hide-welcome-screen"]
    if headless:
        command.append("--headless")
    if size:
        command += ["--window-size", size]

    output = log if log is not None else subprocess.DEVNULL
    process = subprocess.Popen(command, stdout=output, stderr=output)
    return process, f"rerun+http://{LOCALHOST}:{port}/proxy"


def screenshot(recording: Path, picture: Path, t_s: float, size: str = "1920x1080", settle_s: float = 3.0) -> list[str]:
    """Save a picture of a recording in the viewer, without a display.

    Args:
        recording: the .rrd file.
        picture: the .png file, which is replaced.
        t_s: session time to show [s].
        size: window size in pixels.
        settle_s: time that the viewer is given to draw [s].

    Returns:
        Errors and warnings that the viewer reports about its views; empty if there are none.

    Raises:
        RecordError: the viewer does not start, or cannot draw.
    """
    with headless_viewer(size) as url:
        client = rr.experimental.ViewerClient.connect(url)
        client.open(str(recording.absolute()))
        deadline = time.monotonic() + START_TIMEOUT_S
        while not client.get_state().recordings and time.monotonic() < deadline:
            time.sleep(0.2)

        # The viewer has no call that tells when it has drawn: wait before and after the jump in time.
        time.sleep(settle_s / 2)
        client.set_time(TIMELINE, duration=t_s, play_state="paused")
        time.sleep(settle_s)

        _save_screenshot(client, picture)
        return [f"{view.name}: {report}" for view in client.get_state().views for report in view.reports]


@contextlib.contextmanager
def headless_viewer(size: str = "1920x1080") -> Iterator[str]:
    """Context manager that runs a viewer without a window and yields its address.

    Args:
        size: window size in pixels.

    Raises:
        RecordError: the viewer does not start, cannot draw, or ends too early.
    """
    with tempfile.TemporaryFile() as output:
        process, url = start(headless=True, size=size, log=output)
        try:
            wait_until_ready(process, url, output)
            yield url
        except ConnectionError as error:
            # The viewer may answer once before it finds that it cannot draw.
            raise RecordError(_lost_connection(process, output, error)) from None
        finally:
            process.terminate()
            try:
                process.wait(10)
            except subprocess.TimeoutExpired:
                process.kill()


def wait_until_ready(process: subprocess.Popen[bytes], url: str, output: IO[bytes] | None = None) -> None:
    """Wait until a viewer answers.

    Args:
        process: the viewer.
        url: its address.
        output: file that receives the viewer's output; it gives the reason if the viewer ends.

    Raises:
        RecordError: the viewer ends, or does not answer within `START_TIMEOUT_S`.
    """
    deadline = time.monotonic() + START_TIMEOUT_S
    while time.monotonic() < deadline:
        if process.poll() is not None:
            raise RecordError("rerun's viewer ended at once" if output is None else _end_reason(output))

        with contextlib.suppress(Exception):
            rr.experimental.ViewerClient.connect(url).get_state()
            return
        time.sleep(0.3)

    raise RecordError(f"rerun's viewer did not answer within {START_TIMEOUT_S:g} s")


def free_port() -> int:
    """A port that no process listens on."""
    with socket.socket() as listener:
        listener.bind((LOCALHOST, 0))
        return int(listener.getsockname()[1])


def check_display(instead: str) -> None:
    """Check that a window can be opened.

    Args:
        instead: what the user can do without a display; ends the error message.

    Raises:
        RecordError: there is no display.
    """
    if sys.platform.startswith("linux") and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        raise RecordError(f"there is no display for rerun's viewer; {instead}")


def _save_screenshot(client: rr.experimental.ViewerClient, picture: Path) -> None:
    """Save what the viewer shows.

    Raises:
        RecordError: the viewer has drawn nothing after `DRAWING_TRIES` tries.
    """
    for _ in range(DRAWING_TRIES):
        # Without a graphics card the processor draws, which takes long while it is busy.
        with contextlib.suppress(TimeoutError):
            client.save_screenshot(str(picture.absolute()))
            return
    raise RecordError("rerun's viewer did not draw in time: is the computer busy? try again")


def _lost_connection(process: subprocess.Popen[bytes], output: IO[bytes], error: ConnectionError) -> str:
    """Error message for a viewer that no longer answers: its last output if it has ended."""
    try:
        process.wait(END_TIMEOUT_S)
    except subprocess.TimeoutExpired:
        return f"rerun's viewer no longer answers: {error}"
    return _end_reason(output)


def _end_reason(output: IO[bytes]) -> str:
    """Error message for a viewer that has ended, from its output."""
    output.seek(0)
    text = output.read().decode(errors="replace")

    if any(word in text for word in ("render context", "adapter", "Vulkan", "wgpu")):
        return (
            "rerun's viewer has nothing to draw with: it needs a Vulkan driver (on Debian and Ubuntu: "
            "apt-get install mesa-vulkan-drivers)"
        )
    last_line = next((line.strip() for line in reversed(text.splitlines()) if line.strip()), "no reason given")
    return f"rerun's viewer ended at once: {last_line}"
