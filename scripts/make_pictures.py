"""The pictures of the documentation: one session is danced, photographed and looked at in the viewer.

    python scripts/make_pictures.py [--out docs] [--seed 0]

writes ``dance.png`` (the room), ``film.png`` (as a film shows it) and ``overview.png`` (the recording in rerun's
viewer). Needs libegl1 and mesa-vulkan-drivers, no display. Takes about a minute. The moves of every dance:
``scripts/make_contact_sheet.py``.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

import sjasim  # noqa: F401 - chooses an offscreen OpenGL before anything loads MuJoCo

import numpy as np  # isort: skip
from PIL import Image

from sjasim.analysis.delay_breakdown import delay_report
from sjasim.config import SessionConfig
from sjasim.record.rerun.recording import save
from sjasim.record.rerun.viewer import screenshot
from sjasim.session.session import Session, run_session
from sjasim.simulation.rendering import Renderer
from sjasim.simulation.video import add_captions, caption_title, captions

ITERATION = 1
ROOM = (1280, 720)
BAR_PX = 37
"""Height of the bar with which the viewer's window begins; it says how the picture was made, not what it shows."""
STILL = 0.55
"""Share of a move after which it is photographed."""
LATE_S = 1.0
"""So long after the start of the last move but one the overview is taken: everything is on its way."""


class Photographer:
    """Takes a picture of the room in mid-move, without captions and with them."""

    def __init__(self, session: Session) -> None:
        self.session = session
        self.room: np.ndarray | None = None
        self.film: np.ndarray | None = None
        self._camera = Renderer(session.world.physics, *ROOM, session.layout.mounts)

    def tick(self, now: float) -> None:
        """At every camera frame: whether the moment has come."""
        if self.room is None and self.session.timetable.iteration_at(now) == ITERATION and now >= self._moment():
            self.room = self._camera.render("scene", self.session.server.active)
            self.film = add_captions(self.room, caption_title(self.session, now), captions(self.session, now))

    def _moment(self) -> float:
        """A little after the middle of the first move forward, of the dancers' mean."""
        cues = [cue for cue in self.session.world.cues if (cue.iteration, cue.ordinal) == (ITERATION, 0)]
        return float(np.mean([cue.t_s + STILL * cue.duration_s for cue in cues])) if cues else np.inf

    def close(self) -> None:
        """Give the graphics memory back."""
        self._camera.close()


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
    crew[0].close()
    found = delay_report(log)
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
