"""Make a sheet of pictures of the dances: one row per dance, with a picture of each move and the score of an iteration.

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
from sjasim.choreography.score import Choreography
from sjasim.choreography.timetable import timetable
from sjasim.config import DanceConfig, SessionConfig
from sjasim.core import Cue, Move
from sjasim.simulation.motion_recording import motion_figures
from sjasim.simulation.motion_trials import FULL_RANGE
from sjasim.simulation.open_loop_world import OpenLoopWorld
from sjasim.simulation.rendering import Camera, Renderer

DANCES = ("paper", "march", "waltz")

MOVES = (Move.FORWARD, Move.BACKWARD, Move.CLAP, Move.TURN)
"""Columns of the sheet."""

PANEL_PX = (640, 400)
"""Width and height of a picture."""

SCORE_PX = 64
"""Height of the score below the pictures of a dance."""

GAP_PX = 6
"""Distance between pictures."""

ROW_PX = PANEL_PX[1] + SCORE_PX + 2 * GAP_PX
"""Height of the row of a dance."""

LONGEST_BEATS = 41.0
"""Beats that the width of the score stands for; the same in all rows, so that they can be compared."""

SHARES = {Move.FORWARD: (0.0, 0.95), Move.BACKWARD: (0.0, 0.95), Move.TURN: (0.0, 0.6)}
"""Shares of a move's duration of the two poses that its picture shows; the first one is faint."""

FAINT = 0.35
"""Share of the first pose in a picture of two."""

BEFORE_CLAP_S = 0.16
"""Time before a clap at which its first picture is taken [s]."""

CLAP_DISTANCE_M = 1.85
"""Distance of the camera from the dancer whose clap is shown: from afar, joined hands look like crossed arms [m]."""

COLOURS = {Move.FORWARD: (0, 114, 178), Move.BACKWARD: (213, 94, 0), Move.CLAP: (30, 30, 35), Move.TURN: (0, 158, 115)}
"""Colour of a move in the score."""

INK = (30, 30, 35)
PAPER = (240, 240, 242)


def dance_pictures(name: str, seed: int) -> dict[Move, np.ndarray]:
    """Return a picture of the first move of each sort in one iteration, by dancers who move like a metronome."""
    config = SessionConfig(
        seed=seed, iterations=1, method="none", humans="metronomic", body=FULL_RANGE,
        dance=DanceConfig(name=name, rehearsal=False),
    )  # fmt: skip
    world = OpenLoopWorld(config, robot=True)
    camera = Renderer(world.physics, *PANEL_PX, layout(config).mounts)
    cues = [cue for cue in world.cues if cue.dancer == "dancer_1"]

    first = {move: next((cue for cue in cues if cue.move is move), None) for move in MOVES}
    pictures = {}
    for move, cue in first.items():
        if cue is None:
            continue
        if move is Move.CLAP:
            x_m, y_m = layout(config).dancers[0].tolist()
            pictures[move] = clap_picture(world, camera, cue, (x_m, y_m))
        else:
            pictures[move] = two_poses(world, camera, cue)
    camera.close()

    found = motion_figures([world.run().recording()])
    claps = f", claps within {found['clap_p95_ms']:.0f} ms (p95)" if Move.CLAP in pictures else ""
    print(f"{name}: slip median {found['slip_median_mm']:.1f} mm{claps}")
    return pictures


def two_poses(world: OpenLoopWorld, camera: Renderer, cue: Cue) -> np.ndarray:
    """Return a picture of a move: its end, and its beginning as a faint image, so that the way is seen."""
    poses = []
    for share in SHARES[cue.move]:
        world.run(cue.t_s + share * cue.duration_s)
        poses.append(camera.render("dancers", "north").astype(float))
    return (FAINT * poses[0] + (1.0 - FAINT) * poses[1]).astype(np.uint8)


def clap_picture(world: OpenLoopWorld, camera: Renderer, cue: Cue, slot_m: tuple[float, float]) -> np.ndarray:
    """Return a picture of one dancer from the front, in two halves: the hands apart, and at the clap."""
    halves = []
    middle = PANEL_PX[0] // 2
    for before_s in (BEFORE_CLAP_S, 0.0):
        world.run(cue.t_s - before_s)
        view = Camera((*slot_m, 1.22), CLAP_DISTANCE_M, -np.pi / 2, 0.12)
        halves.append(camera.render(view, "north")[:, middle // 2 : middle // 2 + middle])
    halves[0][:, -3:] = 255
    return np.concatenate(halves, axis=1)


def draw_score(draw: ImageDraw.ImageDraw, choreography: Choreography, top_px: int, width_px: int) -> None:
    """Draw the moves of one iteration on an axis of beats, up to the beginning of the next one."""
    scale = width_px / LONGEST_BEATS
    font = ImageFont.load_default(20)
    bottom_px = top_px + SCORE_PX - 26

    draw.rectangle((0, top_px, choreography.iteration_beats * scale, bottom_px), fill=PAPER)
    for move in choreography.moves:
        left_px = move.beat * scale
        right_px = left_px + max(move.beats, 0.3) * scale
        draw.rectangle((left_px, top_px, right_px, bottom_px), fill=COLOURS[move.move])
        draw.text((left_px, bottom_px + 2), f"{move.beat:g}", font=font, fill=INK)
        # A clap is a moment, whose word stands before it.
        word = move.move.value
        place_px = left_px + 8 if move.beats else left_px - 8 - draw.textlength(word, font)
        draw.text((place_px, top_px + 6), word, font=font, fill="white" if move.beats else INK)

    end_px = choreography.iteration_beats * scale
    draw.line((end_px, top_px, end_px, bottom_px + 22), fill=INK, width=3)
    label = f"beat {choreography.iteration_beats:g}: next iteration"
    draw.text((end_px - 12 - draw.textlength(label, font), bottom_px + 2), label, font=font, fill=INK)


def main() -> int:
    """Make the pictures and write the sheet."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path(__file__).resolve().parents[1] / "docs" / "dances.png")
    parser.add_argument("--seed", type=int, default=9701, help="seed of the dancers")
    options = parser.parse_args()

    width, height = PANEL_PX
    sheet_px = (len(MOVES) * (width + GAP_PX) - GAP_PX, len(DANCES) * ROW_PX)
    sheet = Image.new("RGB", sheet_px, "white")
    draw = ImageDraw.Draw(sheet)
    font = ImageFont.load_default(26)
    for row, name in enumerate(DANCES):
        pictures = dance_pictures(name, options.seed)
        top = row * ROW_PX
        for column, move in enumerate(MOVES):
            left = column * (width + GAP_PX)
            if move in pictures:
                sheet.paste(Image.fromarray(pictures[move]), (left, top))
            else:
                draw.rectangle((left, top, left + width, top + height), fill=PAPER)
            caption = f"{name}: {move.value}" if move in pictures else f"{name} has no {move.value}"
            draw.text((left + 14, top + 10), caption, font=font, fill=INK)
        choreography = timetable(SessionConfig(dance=DanceConfig(name=name))).choreography
        draw_score(draw, choreography, top + height + GAP_PX, sheet_px[0])

    # A palette keeps the file in the repository small.
    sheet.quantize(256).save(options.out, optimize=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
