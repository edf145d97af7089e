"""One iteration of every dance, one row a dance, as pictures close enough to judge the dancers by.

    python scripts/make_contact_sheet.py [--out docs/dances.png] [--seed 9701]

Prints how far standing feet slide and how near the planned clap the hands meet. Needs libegl1, no display.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import sjasim  # noqa: F401 - chooses an offscreen OpenGL before anything loads MuJoCo

import numpy as np  # isort: skip
from PIL import Image, ImageDraw, ImageFont

from sjasim.choreography.layout import layout
from sjasim.config import DanceConfig, SessionConfig
from sjasim.core import Move
from sjasim.simulation.motion_recording import motion_figures
from sjasim.simulation.motion_trials import FULL_RANGE
from sjasim.simulation.open_loop_world import OpenLoopWorld
from sjasim.simulation.rendering import Renderer

DANCES = ("paper", "march", "waltz")
PANEL = (640, 400)
SHARES = {Move.FORWARD: 0.45, Move.BACKWARD: 0.45, Move.CLAP: 0.0, Move.TURN: 0.4}
"""Share of a move after which it is photographed."""
COLUMNS = 4


def row(name: str, seed: int) -> list[tuple[str, np.ndarray]]:
    """(caption, picture) of the moves of one iteration by people who keep time like a metronome."""
    config = SessionConfig(
        seed=seed, iterations=1, method="none", humans="metronomic", body=FULL_RANGE,
        dance=DanceConfig(name=name, rehearsal=False),
    )  # fmt: skip
    trial = OpenLoopWorld(config, robot=True)
    mounts = layout(config).mounts
    camera = Renderer(trial.physics, *PANEL, mounts)
    cues = [cue for cue in trial.cues if cue.dancer == "dancer_1"]
    chosen = [cues[0], cues[1], *cues[-2:]]
    pictures = []
    for cue in chosen:
        trial.run(cue.t_s + SHARES[cue.move] * cue.duration_s)
        pictures.append((f"{name}: {cue.move.value}", camera.render("dancers", "north")))
    camera.close()
    found = motion_figures([trial.run().recording()])
    print(f"{name}: slip median {found['slip_median_mm']:.1f} mm, claps within {found['clap_p95_ms']:.0f} ms (p95)")
    return pictures


def main() -> int:
    """Dance, photograph, write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path(__file__).resolve().parents[1] / "docs" / "dances.png")
    parser.add_argument("--seed", type=int, default=9701)
    options = parser.parse_args()
    gap, (width, height) = 6, PANEL
    sheet = Image.new("RGB", (COLUMNS * (width + gap) - gap, len(DANCES) * (height + gap) - gap), "white")
    draw = ImageDraw.Draw(sheet)
    for line, name in enumerate(DANCES):
        for column, (caption, picture) in enumerate(row(name, options.seed)):
            x, y = column * (width + gap), line * (height + gap)
            sheet.paste(Image.fromarray(picture), (x, y))
            draw.text((x + 14, y + 10), caption, font=ImageFont.load_default(22), fill=(30, 30, 35))
    sheet.quantize(256).save(options.out, optimize=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
