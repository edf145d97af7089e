"""A session as a film with captions of what happens, drawn in software while the session is danced."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..assets.colours import dancer_colour
from ..core import ROBOT
from ..core.errors import RecordError
from .physics_world import physics_of
from .rendering import Picture, Renderer, RenderError

if TYPE_CHECKING:
    from ..session.session import Session

SIZE = (960, 540)
EVERY = 2
"""Of how many camera frames one is filmed; the film runs at true speed."""

SHOWN_S = 2.0
"""How long a caption stays."""

LINES = 5
INK, AMBER = (25, 25, 30), (170, 110, 0)
SAYS = {
    "start_forward": "goes forward", "stop_forward": "stops", "start_backward": "goes backward",
    "stop_backward": "stops", "clap": "claps", "turn": "turns",
}  # fmt: skip


class VideoWriter:
    """Films a session: add `tick` to its world's watchers before it begins, and `close` it at the end.

    Args:
        session: what to film.
        path: the .mp4 file; it appears when the film is closed.
        camera: see `render.CAMERAS`.

    Raises:
        RenderError: there is nothing to draw with.
        RecordError: the package that writes films is missing.
    """

    def __init__(self, session: Session, path: Path, camera: str = "room") -> None:
        check_writer()
        import imageio_ffmpeg

        self._session, self._path, self._camera = session, path, camera
        self._draft = path.with_name(f".{path.stem}.partial.mp4")
        self._renderer = Renderer(physics_of(session).physics, *SIZE, session.layout.mounts, fine=False)
        rate = session.config.sensors.rate_hz / EVERY
        self._writer: Generator[None, Any, None] = imageio_ffmpeg.write_frames(
            str(self._draft), SIZE, fps=rate, quality=7, macro_block_size=4, ffmpeg_log_level="error"
        )
        self._writer.send(None)
        self._frames = 0

    def tick(self, now: float) -> None:
        """A camera frame of the session."""
        if self._frames % EVERY == 0:
            picture = self._renderer.frame(self._camera, self._session.server.active)
            self._writer.send(
                np.ascontiguousarray(
                    add_captions(picture, caption_title(self._session, now), caption_lines(self._session, now))
                )
            )
        self._frames += 1

    def close(self, keep: bool = True) -> None:
        """End the film; it is thrown away unless it is to be kept."""
        self._writer.close()
        self._renderer.close()
        if keep:
            self._draft.replace(self._path)
        else:
            self._draft.unlink(missing_ok=True)


def check_writer() -> None:
    """Make sure that films can be written.

    Raises:
        RecordError: the package is missing.
    """
    try:
        import imageio_ffmpeg  # noqa: F401
    except ImportError:
        raise RecordError("films need imageio-ffmpeg: pip install imageio-ffmpeg") from None


def caption_title(session: Session, now: float) -> str:
    """Time, iteration, and what the method last said."""
    iteration = session.timetable.iteration_at(now)
    name = f"iteration {iteration}" if iteration else "rehearsal"
    return f"{now:5.1f} s   {name}   method {session.config.method}   active sensor: {session.server.active}"


def caption_lines(session: Session, now: float) -> list[tuple[str, tuple[int, int, int]]]:
    """What was seen and done of late, oldest first, each with its agent's colour."""
    found: list[tuple[float, str, tuple[int, int, int]]] = []
    for event in session.events[-40:]:
        if not event.early and now - SHOWN_S <= event.t_arrival_s <= now:
            colour = dancer_colour(int(event.person.rpartition("_")[2]) - 1)
            found.append((event.t_arrival_s, f"{event.person} {SAYS[event.kind.value]}", colour))
    for command in session.commands[-8:]:
        if now - SHOWN_S <= command.t_start_s <= now:
            found.append((command.t_start_s, f"command {command.move.value}: {command.why}", INK))
    for deed in session.world.robot_events[-8:]:
        if now - SHOWN_S <= deed.t_s <= now:
            found.append((deed.t_s, f"{ROBOT} {SAYS[deed.kind.value]}", AMBER))
    return [(f"{t_s:6.2f}  {text}", colour) for t_s, text, colour in sorted(found)[-LINES:]]


def add_captions(picture: Picture, head: str, below: Sequence[tuple[str, tuple[int, int, int]]]) -> Picture:
    """A picture with a line above and lines below, on a light ground."""
    from PIL import Image, ImageDraw, ImageFont

    image = Image.fromarray(picture)
    draw = ImageDraw.Draw(image, "RGBA")
    size = max(12, picture.shape[0] // 30)
    font = ImageFont.load_default(size)
    draw.rectangle((0, 0, picture.shape[1], size + 14), fill=(250, 250, 250, 200))
    draw.text((12, 5), head, font=font, fill=INK)
    top = picture.shape[0] - len(below) * (size + 5) - 10
    if below:
        draw.rectangle((0, top - 4, picture.shape[1], picture.shape[0]), fill=(250, 250, 250, 180))
    for row, (text, colour) in enumerate(below):
        draw.text((12, top + row * (size + 5)), text, font=font, fill=tuple(int(0.75 * value) for value in colour))
    return np.asarray(image, dtype=np.uint8)


__all__ = ["RenderError", "VideoWriter", "add_captions", "caption_lines", "caption_title", "check_writer"]
