"""Make the pictures of the documentation from one session.

    python scripts/make_pictures.py [--out docs] [--seed 0]

writes ``dance.png`` (the scene), ``film.png`` (a frame of a video with its captions) and ``overview.png`` (the
recording in rerun's viewer). Needs libegl1 and mesa-vulkan-drivers, no display. Takes about a minute.
``scripts/make_contact_sheet.py`` makes the pictures of the moves of each dance.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

import sjasim  # noqa: F401 - selects an offscreen OpenGL before MuJoCo is imported

import numpy as np  # isort: skip
from PIL import Image

from sjasim.analysis.delay_breakdown import delay_report
from sjasim.config import SessionConfig
from sjasim.core.session_log import SessionLog
from sjasim.record.rerun.recording import save
from sjasim.record.rerun.viewer import screenshot
from sjasim.session.session import Session, run_session
from sjasim.simulation.rendering import Renderer
from sjasim.simulation.video import add_captions, caption_title, captions

ITERATION = 1
"""Iteration of the pictures of the scene."""

PICTURE_PX = (1280, 720)
"""Width and height of the pictures of the scene."""

MENU_BAR_PX = 37
"""Height of the viewer's menu bar, which is cut off."""

MOVE_SHARE = 0.55
"""Share of the first move after which the pictures of the scene are taken."""

OVERVIEW_STEP = (3, 6)
"""Iteration and ordinal of the step that the overview shows."""

OVERVIEW_DELAY_S = 1.0
"""Time of the overview after the start of that step, when all moves are under way."""


class Photographer:
    """Takes a picture of the scene during the first move forward, with and without captions.

    Args:
        session: the session; its `tick` must be called at each frame.

    Attributes:
        scene: the picture without captions, None before it is taken.
        video_frame: the picture with the captions of a video.
    """

    def __init__(self, session: Session) -> None:
        self.scene: np.ndarray | None = None
        self.video_frame: np.ndarray | None = None
        self._session = session
        self._camera = Renderer(session.world.physics, *PICTURE_PX, session.layout.mounts)

    def tick(self, now_s: float) -> None:
        """Take the pictures if it is time and they are not taken yet."""
        if self.scene is not None or self._session.timetable.iteration_at(now_s) != ITERATION:
            return
        if now_s < self._picture_time_s():
            return
        self.scene = self._camera.render("scene", self._session.server.active)
        self.video_frame = add_captions(self.scene, caption_title(self._session, now_s), captions(self._session, now_s))

    def _picture_time_s(self) -> float:
        """Return the dancers' mean time of the picture; infinite before their cues are known."""
        cues = [cue for cue in self._session.world.cues if (cue.iteration, cue.ordinal) == (ITERATION, 0)]
        return float(np.mean([cue.t_s + MOVE_SHARE * cue.duration_s for cue in cues])) if cues else np.inf

    def close(self) -> None:
        """Release the memory of the graphics card."""
        self._camera.close()


def write_overview(log: SessionLog, path: Path) -> None:
    """Write a picture of the session's recording in rerun's viewer."""
    report = delay_report(log)
    step_s = next(step.t_s for step in report.steps if (step.iteration, step.ordinal) == OVERVIEW_STEP)
    with tempfile.TemporaryDirectory() as folder:
        recording = Path(folder) / "session.rrd"
        save(log, recording, report)
        for line in screenshot(recording, path, step_s + OVERVIEW_DELAY_S):
            sys.stderr.write(f"{line}\n")
    with Image.open(path) as window:
        window.crop((0, MENU_BAR_PX, *window.size)).save(path, optimize=True)


def main() -> int:
    """Run the session and write the pictures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path(__file__).resolve().parents[1] / "docs")
    parser.add_argument("--seed", type=int, default=0, help="seed of the session")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    photographers: list[Photographer] = []

    def prepare(session: Session) -> None:
        photographers.append(Photographer(session))
        session.world.watchers.append(photographers[0].tick)

    log = run_session(SessionConfig(method="sia", seed=options.seed), prepare=prepare)
    photographer = photographers[0]
    assert photographer.scene is not None
    assert photographer.video_frame is not None
    Image.fromarray(photographer.video_frame).save(options.out / "film.png", optimize=True)
    Image.fromarray(photographer.scene).save(options.out / "dance.png", optimize=True)

    # The viewer needs a graphics context as well, so the renderer's is released first.
    photographer.close()
    write_overview(log, options.out / "overview.png")
    return 0


if __name__ == "__main__":
    sys.exit(main())
