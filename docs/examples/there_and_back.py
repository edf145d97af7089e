"""A dance in one file: one phrase forward and backward, a clap and a quarter turn.

python3 scripts/launch.py run --dance.name there_and_back:there_and_back
"""

import math

from sjasim.choreography.score import Choreography, ScoreMove
from sjasim.core import Move


def there_and_back() -> Choreography:
    """The score of one iteration; the session repeats it."""
    moves = (
        # Move, first beat, length in beats.
        ScoreMove(Move.FORWARD, 0.0, 4.0),
        ScoreMove(Move.BACKWARD, 8.0, 4.0),
        ScoreMove(Move.CLAP, 16.0, 0.0),
        ScoreMove(Move.TURN, 17.0, 2.0),
    )
    return Choreography("there_and_back", moves, iteration_beats=24.0, close_beat=20.0, turn_rad=math.pi / 2)
