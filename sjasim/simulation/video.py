"""Writes a video of a session, with captions of its events, while the session runs."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..assets.colours import dancer_colour
from ..core import ROBOT
from ..core.errors import RecordError
from .physics_world import physics_of
from .rendering import Picture, Renderer

if TYPE_CHECKING:
    from ..session.session import Session

Colour = tuple[int, int, int]
"""Red, green and blue, 0 to 255."""

SIZE_PX = (960, 540)
"""Width and height of a video."""

FRAME_STRIDE = 2
"""Interval between the filmed frames of the sensors. The video runs in real time."""

CAPTION_S = 2.0
"""Duration of a caption [s]."""

MAX_CAPTIONS = 5
"""Largest number of captions at a time."""

TEXT_COLOUR: Colour = (25, 25, 30)
"""Colour of the title and of the captions of commands."""

ROBOT_COLOUR: Colour = (170, 110, 0)
"""Colour of the captions of robot events."""

VERBS = {
    "start_forward": "goes forward",
    "stop_forward": "stops",
    "start_backward": "goes backward",
    "stop_backward": "stops",
    "clap": "claps",
    "turn": "turns",
}
"""Kind of event -> its caption, after the name of who moved."""


class VideoWriter:
    """Writes a video of a session. Add `tick` to the watchers of its world before the session starts.

    Args:
        session: the session to film.
        path: the .mp4 file, which appears when the writer is closed.
        camera: a name of `rendering.CAMERAS`.

    Raises:
        RenderError: there is no OpenGL.
        RecordError: the package that writes videos is not installed.
    """

    def __init__(self, session: Session, path: Path, camera: str = "scene") -> None:
        check_writer()
        import imageio_ffmpeg

        self._session = session
        self._path = path
        self._camera = camera
        self._partial_path = path.with_name(f".{path.stem}.partial.mp4")
        self._renderer = Renderer(physics_of(session).physics, *SIZE_PX, session.layout.mounts, fine=False)
        self._writer: Generator[None, Any, None] = imageio_ffmpeg.write_frames(
            str(self._partial_path),
            SIZE_PX,
            fps=session.config.sensors.rate_hz / FRAME_STRIDE,
            quality=7,
            macro_block_size=4,
            ffmpeg_log_level="error",
        )
        # The first value starts the generator, which opens the file.
        self._writer.send(None)
        self._frames = 0

    def tick(self, now: float) -> None:
        """Add a picture to the video if one is due.

        Args:
            now: session time of a frame of the sensors [s].
        """
        if self._frames % FRAME_STRIDE == 0:
            picture = self._renderer.render(self._camera, self._session.server.active)
            title = caption_title(self._session, now)
            self._writer.send(np.ascontiguousarray(add_captions(picture, title, captions(self._session, now))))
        self._frames += 1

    def close(self, keep: bool = True) -> None:
        """Finish the video.

        Args:
            keep: whether to keep the file; it is deleted otherwise.
        """
        self._writer.close()
        self._renderer.close()
        if keep:
            self._partial_path.replace(self._path)
        else:
            self._partial_path.unlink(missing_ok=True)


def check_writer() -> None:
    """Check that videos can be written.

    Raises:
        RecordError: the package imageio-ffmpeg is not installed.
    """
    try:
        import imageio_ffmpeg  # noqa: F401
    except ImportError:
        raise RecordError("videos need imageio-ffmpeg: pip install imageio-ffmpeg") from None


def caption_title(session: Session, now: float) -> str:
    """The line above a picture: time, iteration, method and active sensor."""
    iteration = session.timetable.iteration_at(now)
    name = f"iteration {iteration}" if iteration else "rehearsal"
    return f"{now:5.1f} s   {name}   method {session.config.method}   active sensor: {session.server.active}"


def captions(session: Session, now: float) -> list[tuple[str, Colour]]:
    """The lines below a picture: the events and commands of the last `CAPTION_S`, oldest first, with their colours."""
    found: list[tuple[float, str, Colour]] = []

    # Only the ends of the lists can be recent enough, and a session has thousands of events.
    for event in session.events[-40:]:
        if not event.early and now - CAPTION_S <= event.t_arrival_s <= now:
            colour = dancer_colour(int(event.person.rpartition("_")[2]) - 1)
            found.append((event.t_arrival_s, f"{event.person} {VERBS[event.kind.value]}", colour))
    for command in session.commands[-8:]:
        if now - CAPTION_S <= command.t_start_s <= now:
            found.append((command.t_start_s, f"command {command.move.value}: {command.why}", TEXT_COLOUR))
    for action in session.world.robot_events[-8:]:
        if now - CAPTION_S <= action.t_s <= now:
            found.append((action.t_s, f"{ROBOT} {VERBS[action.kind.value]}", ROBOT_COLOUR))

    return [(f"{t_s:6.2f}  {text}", colour) for t_s, text, colour in sorted(found)[-MAX_CAPTIONS:]]


def add_captions(picture: Picture, title: str, lines: Sequence[tuple[str, Colour]]) -> Picture:
    """Draw a title and captions over a picture.

    Args:
        picture: (H, W, 3).
        title: text at the top.
        lines: texts at the bottom, with their colours.

    Returns:
        a new picture of the same size.
    """
    from PIL import Image, ImageDraw, ImageFont

    height_px, width_px = picture.shape[:2]
    image = Image.fromarray(picture)
    draw = ImageDraw.Draw(image, "RGBA")
    size_px = max(12, height_px // 30)
    font = ImageFont.load_default(size_px)
    draw.rectangle((0, 0, width_px, size_px + 14), fill=(250, 250, 250, 200))
    draw.text((12, 5), title, font=font, fill=TEXT_COLOUR)

    line_px = size_px + 5
    top_px = height_px - len(lines) * line_px - 10
    if lines:
        draw.rectangle((0, top_px - 4, width_px, height_px), fill=(250, 250, 250, 180))
    for row, (text, colour) in enumerate(lines):
        # Darker than the dancers' shirts, so that the text can be read on a light ground.
        darker = tuple(int(0.75 * value) for value in colour)
        draw.text((12, top_px + row * line_px), text, font=font, fill=darker)
    return np.asarray(image, dtype=np.uint8)
