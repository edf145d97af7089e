"""The pictures of the documentation: one session is danced, photographed and looked at in the viewer.

    python scripts/make_pictures.py [--out docs] [--seed 0]

writes ``dance.png`` (the room), ``film.png`` (as a film shows it), ``dancers.png`` (the moves of one iteration) and
``overview.png`` (the recording in rerun's viewer). Needs libegl1 and mesa-vulkan-drivers, no display. Takes about a
minute.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

import sjasim  # noqa: F401 - chooses an offscreen OpenGL before anything loads MuJoCo

import numpy as np  # isort: skip
from PIL import Image, ImageDraw, ImageFont

from sjasim.analysis.insight import insight
from sjasim.config import SessionConfig
from sjasim.film import captioned, lines, title
from sjasim.record.rerun import save
from sjasim.record.viewer import screenshot
from sjasim.render import Renderer
from sjasim.session import Session, run_session
from sjasim.types import Move

STILL = 0.55
"""Share of a move after which it is photographed."""

MOVES = ((Move.FORWARD, "forward"), (Move.BACKWARD, "backward"), (Move.CLAP, "clap"), (Move.TURN, "quarter turn"))
ITERATION = 1
PANEL = (800, 450)
ROOM = (1280, 720)
BAR_PX = 37
"""Height of the bar with which the viewer's window begins; it says how the picture was made, not what it shows."""
LATE_S = 1.0
"""So long after the start of the last move but one the overview is taken: everything is on its way."""


class Photographer:
    """Takes a picture of each move of one iteration, and one of the whole room."""

    def __init__(self, session: Session) -> None:
        self.session = session
        self.stills: dict[Move, np.ndarray] = {}
        self.room: np.ndarray | None = None
        self.film: np.ndarray | None = None
        mounts = session.layout.mounts
        self._near = Renderer(session.world.stage, *PANEL, mounts)
        self._far = Renderer(session.world.stage, *ROOM, mounts)

    def tick(self, now: float) -> None:
        """At every camera frame: whether a move has come to its most telling moment."""
        if self.session.timetable.iteration_at(now) != ITERATION:
            return
        for move, _ in MOVES:
            if move not in self.stills and now >= self._moment(move):
                active = self.session.server.active
                self.stills[move] = self._near.frame("dancers", active)
                if move is Move.FORWARD:
                    self.room = self._far.frame("room", active)
                    self.film = captioned(self.room, title(self.session, now), lines(self.session, now))

    def _moment(self, move: Move) -> float:
        cues = [cue for cue in self.session.world.cues if cue.iteration == ITERATION and cue.move is move]
        first = {cue.dancer: cue for cue in reversed(cues)}
        return float(np.mean([cue.t_s + STILL * cue.duration_s for cue in first.values()]))

    def close(self) -> None:
        """Give the graphics memory back."""
        self._near.close()
        self._far.close()


def contact_sheet(stills: dict[Move, np.ndarray]) -> Image.Image:
    """The moves side by side, each with its name."""
    gap, size = 8, 26
    width, height = PANEL
    sheet = Image.new("RGB", (2 * width + gap, 2 * height + gap), "white")
    draw = ImageDraw.Draw(sheet)
    for place, (move, name) in enumerate(MOVES):
        x, y = (place % 2) * (width + gap), (place // 2) * (height + gap)
        sheet.paste(Image.fromarray(stills[move]), (x, y))
        draw.text((x + 16, y + 12), name, font=ImageFont.load_default(size), fill=(30, 30, 35))
    return sheet


def main() -> int:
    """Dance, take the pictures, write them."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path(__file__).resolve().parents[1] / "docs")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    crew: list[Photographer] = []

    def prepare(session: Session) -> None:
        crew.append(Photographer(session))
        session.world.watchers.append(crew[0].tick)

    log = run_session(SessionConfig(method="sia", seed=options.seed), prepare=prepare)
    assert crew[0].room is not None
    assert crew[0].film is not None
    Image.fromarray(crew[0].film).save(options.out / "film.png", optimize=True)
    Image.fromarray(crew[0].room).save(options.out / "dance.png", optimize=True)
    contact_sheet(crew[0].stills).save(options.out / "dancers.png", optimize=True)
    crew[0].close()
    found = insight(log)
    with tempfile.TemporaryDirectory() as place:
        recording = Path(place) / "session.rrd"
        save(log, recording, found)
        moment = next(step.t_s for step in found.steps if (step.iteration, step.ordinal) == (3, 6)) + LATE_S
        for report in screenshot(recording, options.out / "overview.png", moment):
            sys.stderr.write(f"{report}\n")
    with Image.open(options.out / "overview.png") as window:
        window.crop((0, BAR_PX, *window.size)).save(options.out / "overview.png", optimize=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
