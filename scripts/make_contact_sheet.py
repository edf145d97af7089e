"""Make a sheet of pictures of the dancers: one row per dance, with the moves of one iteration.

    python scripts/make_contact_sheet.py [--out docs/dances.png] [--seed 9701]

Prints the slip of standing feet and the error of the times of claps. Needs libegl1, no display.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import sjasim  # noqa: F401 - selects an offscreen OpenGL before MuJoCo is imported

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

PANEL_PX = (640, 400)
"""Width and height of a picture."""

GAP_PX = 6
"""Distance between pictures."""

COLUMNS = 4
"""Pictures per dance: the first two moves and the last two."""

SHARES = {Move.FORWARD: 0.45, Move.BACKWARD: 0.45, Move.CLAP: 0.0, Move.TURN: 0.4}
"""Share of a move's duration after which its picture is taken."""


def dance_pictures(name: str, seed: int) -> list[tuple[str, np.ndarray]]:
    """Return captions and pictures of the moves of one iteration, by dancers who move like a metronome."""
    config = SessionConfig(
        seed=seed, iterations=1, method="none", humans="metronomic", body=FULL_RANGE,
        dance=DanceConfig(name=name, rehearsal=False),
    )  # fmt: skip
    world = OpenLoopWorld(config, robot=True)
    camera = Renderer(world.physics, *PANEL_PX, layout(config).mounts)
    cues = [cue for cue in world.cues if cue.dancer == "dancer_1"]
    pictures = []
    for cue in [cues[0], cues[1], *cues[-2:]]:
        world.run(cue.t_s + SHARES[cue.move] * cue.duration_s)
        pictures.append((f"{name}: {cue.move.value}", camera.render("dancers", "north")))
    camera.close()

    found = motion_figures([world.run().recording()])
    print(f"{name}: slip median {found['slip_median_mm']:.1f} mm, claps within {found['clap_p95_ms']:.0f} ms (p95)")
    return pictures


def main() -> int:
    """Make the pictures and write the sheet."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path(__file__).resolve().parents[1] / "docs" / "dances.png")
    parser.add_argument("--seed", type=int, default=9701, help="seed of the dancers")
    options = parser.parse_args()

    width, height = PANEL_PX
    sheet_px = (COLUMNS * (width + GAP_PX) - GAP_PX, len(DANCES) * (height + GAP_PX) - GAP_PX)
    sheet = Image.new("RGB", sheet_px, "white")
    draw = ImageDraw.Draw(sheet)
    for row, name in enumerate(DANCES):
        for column, (caption, picture) in enumerate(dance_pictures(name, options.seed)):
            x = column * (width + GAP_PX)
            y = row * (height + GAP_PX)
            sheet.paste(Image.fromarray(picture), (x, y))
            draw.text((x + 14, y + 10), caption, font=ImageFont.load_default(22), fill=(30, 30, 35))

    # A palette keeps the file in the repository small.
    sheet.quantize(256).save(options.out, optimize=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
