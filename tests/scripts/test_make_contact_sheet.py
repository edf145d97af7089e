"""The score in the contact sheet: dances that look alike in pictures differ there."""

import importlib.util
from pathlib import Path

import pytest

pytest.importorskip("PIL")

from PIL import Image, ImageDraw

from sjasim.choreography.timetable import timetable
from sjasim.config import DanceConfig, SessionConfig
from sjasim.core import Move

PATH = Path(__file__).resolve().parents[2] / "scripts" / "make_contact_sheet.py"
WIDTH_PX = 2050


@pytest.fixture(scope="module")
def script():
    spec = importlib.util.spec_from_file_location("make_contact_sheet", PATH)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def score(script, name):
    """Colours of a dance's score at a beat."""
    sheet = Image.new("RGB", (WIDTH_PX, script.SCORE_PX), "white")
    choreography = timetable(SessionConfig(dance=DanceConfig(name=name))).choreography
    script.draw_score(ImageDraw.Draw(sheet), choreography, 0, WIDTH_PX)
    return lambda beat: sheet.getpixel((round(beat * WIDTH_PX / script.LONGEST_BEATS), 3))


def test_moves_stand_at_their_beats_and_pauses_between_them(script):
    at = score(script, "paper")
    assert [at(beat) for beat in (2, 10, 18, 26)] == 2 * [script.COLOURS[Move.FORWARD], script.COLOURS[Move.BACKWARD]]
    assert at(6) == at(38) == script.PAPER
    assert (at(32.1), at(34)) == (script.COLOURS[Move.CLAP], script.COLOURS[Move.TURN])
    assert at(40.6) == (255, 255, 255)


def test_march_ends_where_the_paper_s_dance_claps_and_the_waltz_is_faster(script):
    march = score(script, "march")
    assert march(26) == script.COLOURS[Move.BACKWARD]
    assert march(34) == (255, 255, 255)
    waltz = score(script, "waltz")
    assert (waltz(7), waltz(24.1)) == (script.COLOURS[Move.BACKWARD], script.COLOURS[Move.CLAP])
