"""When dancers really move: nominal beats plus the group's common shift plus each dancer's own deviation.

The common shift is an AR(1) process over the iteration's events; own deviations follow linear phase correction in
an ensemble, with timekeeper and motor noise. The robot may be a member of the ensemble, and a badly timed robot may
disturb people where a well-timed one steadies them.

Source: vorberg1996, section 3 (phase correction); wing2014, eq. (1) (the ensemble's form). Shortest moves and holds
are assumed; they keep the order of events.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ...choreography.score import MOVE_EVENTS
from ...choreography.timetable import Timetable
from ...config.session import MAX_DANCERS
from ...core import Array, BoolArray, Cue, Kind, Move, dancer_name
from ...core.errors import ConfigError
from .human_timing import ObservedRobotEvent
from .parameters import TimingParameters

MIN_MOVE_S = 0.8
MIN_HOLD_S = 0.15
PREPARATION_S = 0.5
"""Nobody begins a move sooner after deciding on it: the first step has to be prepared (assumed) [s]."""
DECIDE_S = 1.3
"""How long before its first dancer begins a move is decided; bodies show it 1.2 s before [s]."""
USUAL_APPROPRIATENESS_S = 0.70
"""Mean timing error of the robot at which people are as noisy as their preset says [s]."""
TURN_AFTER_CLAP_S = 0.25
"""A dancer begins to turn so long after the clap [s] (assumed)."""


class EnsembleTiming:
    """The model of this module.

    People whom the robot does not move decide an iteration at once, for nothing that they see meanwhile changes it.
    Where ``robot_coupling`` is above 0 they decide move by move, `DECIDE_S` before the first of them begins, and
    correct towards the robot's events that they have seen by then, each counted once. A start that comes out sooner
    than `PREPARATION_S` after the decision is put off until then.

    Args:
        parameters: of the model.
        timetable: the dance on the session's clock.
        dancers: how many.
        people: random stream of the persons; the same people meet every method.
        performance: random stream of this take.

    Raises:
        ConfigError: a group of none, or of more than 8; a coupling matrix for another group.
    """

    def __init__(
        self,
        parameters: TimingParameters,
        timetable: Timetable,
        dancers: int,
        people: np.random.Generator,
        performance: np.random.Generator,
    ) -> None:
        if isinstance(dancers, bool) or not 1 <= dancers <= MAX_DANCERS:
            raise ConfigError("dancers", dancers, f"1 to {MAX_DANCERS} dancers")
        self._p, self._timetable, self._dancers, self._rng = parameters, timetable, dancers, performance
        self._transition = parameters.transition(dancers)
        self._pull = parameters.each("robot_coupling", dancers, 0.0)
        self._late = parameters.each("late_s", dancers, 0.0)
        self._drift = parameters.each("drift", dancers, 0.0)
        self._scale = _lognormal(parameters.group_spread, people)
        spread = np.array([_lognormal(parameters.dancer_spread, people) for _ in range(dancers)])
        self._own_scale = spread * parameters.each("scale", dancers, 1.0)
        self._steps = timetable.choreography.steps()
        self._moves = timetable.choreography.moves
        self._next = len(self._moves)

    def begin(self, iteration: int, appropriateness_s: float | None, not_before_s: Array) -> None:
        """See `HumanTiming`."""
        p, rng, table = self._p, self._rng, self._timetable
        last = USUAL_APPROPRIATENESS_S if appropriateness_s is None else appropriateness_s
        scale = self._scale * _lognormal(p.iteration_spread, rng)
        own = np.clip(scale * (np.clip(last, 0.05, 3.0) / USUAL_APPROPRIATENESS_S) ** p.entrainment, 0.1, 5.0)
        beats = [step.beat for step in self._steps]
        self._nominal = np.array([table.time_s(iteration, beat) for beat in beats])
        self._slowed = _slowed(self._nominal, np.array(beats), p.anticipation)
        self._common = scale * p.common_s * self._common_shift()
        noise = own * self._own_scale[:, None] * rng.standard_normal((2, self._dancers, len(beats)))
        self._timekeeper, self._motor = p.timekeeper_s * noise[0], p.motor_s * noise[1]
        self._lapses: BoolArray = rng.random((self._dancers, len(beats))) < p.lapse
        self._iteration, self._next = iteration, 0
        self._free_s = np.array(not_before_s, dtype=np.float64)
        self._skipping = np.zeros(self._dancers, dtype=bool)
        self._phase = np.zeros((self._dancers, len(beats)))
        self._times = np.zeros((self._dancers, len(beats)))
        self._answered: set[ObservedRobotEvent] = set()

    @property
    def next_due_s(self) -> float:
        """See `HumanTiming`."""
        if self._next >= len(self._moves):
            return math.inf
        ordinal = self._timetable.choreography.first_ordinal(self._next)
        return float(self._actual(ordinal, self._phase_at(ordinal)).min()) - DECIDE_S

    def decide(self, now_s: float, robot: Sequence[ObservedRobotEvent]) -> tuple[tuple[Cue, ...], ...]:
        """See `HumanTiming`."""
        out: list[list[Cue]] = [[] for _ in range(self._dancers)]
        if self._next >= len(self._moves):
            return tuple(() for _ in out)
        late = bool(self._pull.any())
        pull = self._pull * self._behind(robot) if late else np.zeros(self._dancers)
        self._free_s = np.maximum(self._free_s, now_s + PREPARATION_S)
        while self._next < len(self._moves):
            for dancer, cue in self._move(self._next, pull):
                out[dancer].append(cue)
            pull = np.zeros(self._dancers)
            self._next += 1
            if late and self._next < len(self._moves) and MOVE_EVENTS[self._moves[self._next].move]:
                break
        return tuple(tuple(cues) for cues in out)

    def _move(self, index: int, pull: Array) -> list[tuple[int, Cue]]:
        """Everybody's cue for one move of the score; ``pull`` (D,) is what they give up to the robot [s]."""
        choreography, item = self._timetable.choreography, self._moves[index]
        first, parts = choreography.first_ordinal(index), len(MOVE_EVENTS[item.move])
        for ordinal in range(first, first + parts):
            self._phase[:, ordinal] = self._phase_at(ordinal) - pull
            pull = np.zeros(self._dancers)
            self._happen(ordinal)
        if item.move is Move.FORWARD:
            self._skipping = self._lapses[:, first]
        length = self._timetable.time_s(self._iteration, item.beat + item.beats)
        length -= self._timetable.time_s(self._iteration, item.beat)
        cues = []
        for dancer in range(self._dancers):
            t_s, duration_s = float(self._times[dancer, first]), 0.0
            if parts == 2:
                duration_s = float(self._times[dancer, first + 1]) - t_s
                left_out = self._skipping[dancer]
            else:
                left_out = item.move is not Move.TURN and self._lapses[dancer, first]
            if item.move is Move.TURN:
                t_s, duration_s = t_s + TURN_AFTER_CLAP_S, length
            if not left_out:
                name = dancer_name(dancer)
                cues.append((dancer, Cue(name, item.move, self._iteration, first, item.beat, t_s, duration_s)))
        return cues

    def _phase_at(self, ordinal: int) -> Array:
        """(D,) own deviations at an event, the robot left out [s]."""
        noise = self._timekeeper[:, ordinal]
        if ordinal == 0:
            return np.array(noise)
        passed = float(self._nominal[ordinal] - self._nominal[ordinal - 1])
        drift = self._drift * passed + self._slowed[ordinal]
        return np.asarray(self._transition @ self._phase[:, ordinal - 1] + drift + noise)

    def _actual(self, ordinal: int, phase: Array) -> Array:
        """(D,) session times of an event before the order rule [s]."""
        when = self._nominal[ordinal] + self._common[ordinal] + phase
        return np.asarray(when + self._motor[:, ordinal] + self._late)

    def _happen(self, ordinal: int) -> None:
        """Fix an event's times: no move and no hold is shorter than people can make it."""
        self._times[:, ordinal] = np.maximum(self._actual(ordinal, self._phase[:, ordinal]), self._free_s)
        self._free_s = self._times[:, ordinal] + (MIN_MOVE_S if ordinal % 2 == 0 else MIN_HOLD_S)

    def _behind(self, robot: Sequence[ObservedRobotEvent]) -> Array:
        """(D,) how far each dancer is behind the robot's events that were not answered yet, on average [s]."""
        done = self._timetable.choreography.first_ordinal(self._next)
        phase = self._phase.copy()
        phase[:, done:] = self._phase[:, [max(done - 1, 0)]]
        expected = self._nominal + self._common + phase
        gaps = []
        for seen in robot:
            kind = Kind.CLAP if seen[0] is Kind.TURN else seen[0]
            mine = [step.ordinal for step in self._steps if step.kind is kind]
            if seen in self._answered or not mine:
                continue
            self._answered.add(seen)
            nearest = min(mine, key=lambda ordinal: abs(float(expected[:, ordinal].mean()) - seen[1]))
            gaps.append(expected[:, nearest] - seen[1])
        return np.mean(gaps, axis=0) if gaps else np.zeros(self._dancers)

    def _common_shift(self) -> Array:
        """(E,) common shift in units of its standard deviation."""
        noise = self._rng.standard_normal(len(self._steps))
        rho = self._p.common_correlation
        shift = np.empty(len(noise))
        shift[0] = noise[0]
        for k in range(1, len(noise)):
            shift[k] = rho * shift[k - 1] + np.sqrt(1.0 - rho**2) * noise[k]
        return shift


def _slowed(nominal_s: Array, beats: Array, anticipation: float) -> Array:
    """(E,) how much later than the music each event comes for those who expect the last interval's tempo [s]."""
    interval, beat = np.diff(nominal_s, prepend=nominal_s[0]), np.diff(beats, prepend=beats[0])
    out = np.zeros(len(beats))
    out[2:] = (1.0 - anticipation) * (interval[1:-1] * beat[2:] / beat[1:-1] - interval[2:])
    return out


def _lognormal(spread: float, rng: np.random.Generator) -> float:
    """A factor with mean 1 and the given log standard deviation; one draw is spent whatever the spread."""
    return float(np.exp(spread * rng.standard_normal() - spread**2 / 2))
