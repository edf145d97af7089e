"""The ensemble timing model: event times of dancers who synchronise with one another by linear phase correction.

An event time is the nominal beat plus a common shift of the group plus the dancer's observed deviation. The common
shift is an AR(1) process over the events of an iteration. The observed deviation A is the timekeeper's plus motor noise
M. Dancers correct what they observe, motor noise included: for a single dancer and the music,
``A[k+1] = (1 - a) A[k] + T[k] + M[k+1] - M[k]`` with timekeeper noise T. The robot may be a member of the ensemble, and
a badly timed robot may make people noisier.

Source: vorberg1996, section 3 (phase correction); wing2014, eq. (1), and jacoby2015, section 2 (ensembles). Assumed:
the shortest moves and holds of `cue_assembly`, which keep the events in order; that dancers correct neither the delays
that these cause nor a partner's constant lateness, which they expect; that a dancer who leaves out a move keeps time
meanwhile.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

from ...choreography.score import MOVE_EVENTS
from ...choreography.timetable import Timetable
from ...config.session import MAX_DANCERS
from ...core import Array, BoolArray, Cue, Kind
from ...core.errors import ConfigError
from .cue_assembly import move_cue, performs, shortest_after_s
from .human_timing import ObservedRobotEvent
from .parameters import TimingParameters

PREPARATION_S = 0.5
"""Least time from the decision for a move to its begin, in which people prepare the first step [s] (assumed)."""

DECISION_LEAD_S = 1.3
"""Time from the decision for a move to the begin of its first dancer [s]; bodies show a move 1.2 s before it."""

REFERENCE_APPROPRIATENESS_S = 0.70
"""Mean timing error of the robot at which people are as noisy as their preset says [s]."""


@dataclass(slots=True)
class _Iteration:
    """Random draws and progress of one iteration; D dancers, E events of the score.

    Attributes:
        index: index of the iteration.
        nominal_s: (E,) nominal event times.
        tempo_error_s: (E,) lateness by which each event follows from a tempo change that was not foreseen.
        common_s: (E,) common shift of the group.
        timekeeper_s: (D, E) timekeeper noise.
        motor_s: (D, E) motor noise.
        lapses: (D, E) draws of lapses.
        free_s: (D,) earliest session time of each dancer's next event.
        deviation_s: (D, E) timekeepers' deviations at the decided events, without motor noise.
        tempo: (D, E) relative slowness that period correction has given each dancer before the decided events.
        times_s: (D, E) decided event times.
        answered: robot events to which the dancers have corrected already.
    """

    index: int
    nominal_s: Array
    tempo_error_s: Array
    common_s: Array
    timekeeper_s: Array
    motor_s: Array
    lapses: BoolArray
    free_s: Array
    deviation_s: Array
    tempo: Array
    times_s: Array
    answered: set[ObservedRobotEvent] = field(default_factory=set)


class EnsembleTiming:
    """Implements `HumanTiming` by linear phase correction in an ensemble.

    Without ``robot_coupling`` an iteration is decided at once, because nothing that happens meanwhile changes it. With
    it, dancers decide move by move, `DECISION_LEAD_S` before the first of them begins, and correct towards the robot's
    events that they have observed by then; each event counts once. A begin that would come sooner than `PREPARATION_S`
    after the decision is delayed until then.

    Args:
        parameters: parameters of the model.
        timetable: the dance in session time.
        dancers: number of dancers.
        people: generator of the persons; the same persons meet every method.
        performance: generator of this performance.

    Raises:
        ConfigError: the number of dancers is not 1 to `MAX_DANCERS`, or the coupling matrix has another size.
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

        self._parameters = parameters
        self._timetable = timetable
        self._dancers = dancers
        self._rng = performance

        self._phase_gains, self._period_gains = _gains(parameters, dancers)
        self._corrects_period = bool(self._period_gains.any())
        self._robot_coupling = parameters.per_dancer("robot_coupling", dancers, 0.0)
        self._late_s = parameters.per_dancer("late_s", dancers, 0.0)
        self._drift = parameters.per_dancer("drift", dancers, 0.0)

        # Drawn from the persons' generator, so that the same people are as noisy under every method.
        self._group_scale = _lognormal(parameters.group_spread, people)
        spread = np.array([_lognormal(parameters.dancer_spread, people) for _ in range(dancers)])
        self._dancer_scale = spread * parameters.per_dancer("scale", dancers, 1.0)

        self._steps = timetable.choreography.steps()
        self._moves = timetable.choreography.moves
        self._next_move = len(self._moves)

    def begin(self, iteration: int, appropriateness_s: float | None, not_before_s: Array) -> None:
        """See `HumanTiming.begin`."""
        rng = self._rng
        parameters = self._parameters
        beats = np.array([step.beat for step in self._steps])
        nominal_s = np.array([self._timetable.time_s(iteration, step.beat) for step in self._steps])
        shape = (self._dancers, len(beats))

        # The order of the draws is part of the model: another order would give other sessions for the same seed.
        scale = self._group_scale * _lognormal(parameters.iteration_spread, rng)
        common_s = scale * parameters.common_s * self._common_shift()
        own_scale = self._entrained(scale, appropriateness_s) * self._dancer_scale[:, None]
        noise = own_scale * parameters.practice_factor(iteration) * rng.standard_normal((2, *shape))
        lapses: BoolArray = rng.random(shape) < parameters.lapse

        self._state = _Iteration(
            index=iteration,
            nominal_s=nominal_s,
            tempo_error_s=_tempo_error(nominal_s, beats, parameters.anticipation),
            common_s=common_s,
            timekeeper_s=parameters.timekeeper_s * noise[0],
            motor_s=parameters.motor_s * noise[1],
            lapses=lapses,
            free_s=np.array(not_before_s, dtype=np.float64),
            deviation_s=np.zeros(shape),
            tempo=np.zeros(shape),
            times_s=np.zeros(shape),
        )
        self._next_move = 0

    @property
    def next_due_s(self) -> float:
        """See `HumanTiming.next_due_s`."""
        if self._next_move >= len(self._moves):
            return math.inf

        ordinal = self._timetable.choreography.first_ordinal(self._next_move)
        return float(self._event_times(ordinal, self._deviation(ordinal)).min()) - DECISION_LEAD_S

    def decide(self, now_s: float, robot: Sequence[ObservedRobotEvent]) -> tuple[tuple[Cue, ...], ...]:
        """See `HumanTiming.decide`."""
        cues: list[list[Cue]] = [[] for _ in range(self._dancers)]
        if self._next_move >= len(self._moves):
            return tuple(() for _ in cues)

        move_by_move = bool(self._robot_coupling.any())
        correction_s = np.zeros(self._dancers)
        if move_by_move:
            correction_s = self._robot_coupling * self._lag_behind_robot(robot)
        self._state.free_s = np.maximum(self._state.free_s, now_s + PREPARATION_S)

        while self._next_move < len(self._moves):
            for dancer, cue in self._decide_move(self._next_move, correction_s):
                cues[dancer].append(cue)
            correction_s = np.zeros(self._dancers)
            self._next_move += 1

            # A turn has no event of its own, so it is decided together with the clap before it.
            if move_by_move and self._next_move < len(self._moves) and MOVE_EVENTS[self._moves[self._next_move].move]:
                break

        return tuple(tuple(own) for own in cues)

    def _entrained(self, scale: float, appropriateness_s: float | None) -> float:
        """The noise scale after an iteration with the robot's given timing error, within bounds (assumed)."""
        error_s = REFERENCE_APPROPRIATENESS_S if appropriateness_s is None else appropriateness_s
        ratio = np.clip(error_s, 0.05, 3.0) / REFERENCE_APPROPRIATENESS_S
        return float(np.clip(scale * ratio**self._parameters.entrainment, 0.1, 5.0))

    def _decide_move(self, index: int, correction_s: Array) -> list[tuple[int, Cue]]:
        """Cues of one move of the score, with the index of their dancer.

        Args:
            index: index of the move.
            correction_s: (D,) correction towards the robot at the move's first event.
        """
        state = self._state
        move = self._moves[index].move
        first = self._timetable.choreography.first_ordinal(index)

        for ordinal in range(first, first + len(MOVE_EVENTS[move])):
            state.deviation_s[:, ordinal] = self._deviation(ordinal) - correction_s
            state.tempo[:, ordinal] = self._tempo(ordinal)
            correction_s = np.zeros(self._dancers)
            self._fix_event(ordinal)

        return [
            (dancer, move_cue(self._timetable, state.index, index, dancer, state.times_s[dancer]))
            for dancer in range(self._dancers)
            if performs(self._timetable, index, state.lapses[dancer])
        ]

    def _deviation(self, ordinal: int) -> Array:
        """(D,) timekeepers' deviations at an event, before any correction towards the robot [s].

        Source: wing2014, eq. (1), in matrix form, with drift, period correction and unforeseen tempo changes added.
        """
        state = self._state
        noise = state.timekeeper_s[:, ordinal]
        if ordinal == 0:
            return np.array(noise)

        interval_s = float(state.nominal_s[ordinal] - state.nominal_s[ordinal - 1])
        drift = (self._drift + self._tempo(ordinal)) * interval_s + state.tempo_error_s[ordinal]
        correction = self._phase_gains @ self._observed(ordinal - 1)
        return np.asarray(state.deviation_s[:, ordinal - 1] - correction + drift + noise)

    def _observed(self, ordinal: int) -> Array:
        """(D,) deviations at a decided event as everybody observes them, motor noise included [s]."""
        return np.asarray(self._state.deviation_s[:, ordinal] + self._state.motor_s[:, ordinal])

    def _tempo(self, ordinal: int) -> Array:
        """(D,) relative slowness before an event, after period correction for the event before it.

        The correction is relative to the interval in which the asynchrony arose, because intervals differ in length.
        Source: vandersteen2013 (period correction).
        """
        state = self._state
        if ordinal == 0 or not self._corrects_period:
            return np.zeros(self._dancers)

        first = max(ordinal - 2, 0)
        interval_s = float(state.nominal_s[first + 1] - state.nominal_s[first])
        change = self._period_gains @ self._observed(ordinal - 1) / interval_s
        return np.asarray(state.tempo[:, ordinal - 1] - change)

    def _event_times(self, ordinal: int, deviation_s: Array) -> Array:
        """(D,) session times of an event for given own deviations, before shortest moves and holds are applied [s]."""
        state = self._state
        common = state.nominal_s[ordinal] + state.common_s[ordinal] + deviation_s
        return np.asarray(common + state.motor_s[:, ordinal] + self._late_s)

    def _fix_event(self, ordinal: int) -> None:
        """Decide the times of an event, so that no move and no hold is shorter than people can make it."""
        state = self._state
        state.times_s[:, ordinal] = np.maximum(self._event_times(ordinal, state.deviation_s[:, ordinal]), state.free_s)

        state.free_s = state.times_s[:, ordinal] + shortest_after_s(ordinal)

    def _lag_behind_robot(self, robot: Sequence[ObservedRobotEvent]) -> Array:
        """(D,) mean lag of each dancer behind the robot's new events; 0 without a new event [s].

        An event of the robot belongs to the nearest event of its kind in the score. What dancers observe of their own
        events includes motor noise; an event that is still to come is expected without it.
        """
        state = self._state
        decided = self._timetable.choreography.first_ordinal(self._next_move)
        deviation = state.deviation_s + state.motor_s
        # Events that are not decided are expected with the deviation of the last one that is.
        deviation[:, decided:] = state.deviation_s[:, [max(decided - 1, 0)]]
        expected = state.nominal_s + state.common_s + deviation

        lags = []
        for observed in robot:
            # The robot turns where the dancers clap.
            kind = Kind.CLAP if observed[0] is Kind.TURN else observed[0]
            ordinals = [step.ordinal for step in self._steps if step.kind is kind]
            if observed in state.answered or not ordinals:
                continue
            state.answered.add(observed)
            gaps = [abs(float(expected[:, ordinal].mean()) - observed[1]) for ordinal in ordinals]
            lags.append(expected[:, ordinals[gaps.index(min(gaps))]] - observed[1])

        return np.mean(lags, axis=0) if lags else np.zeros(self._dancers)

    def _common_shift(self) -> Array:
        """(E,) a draw of the common shift, in units of its standard deviation."""
        noise = self._rng.standard_normal(len(self._steps))
        rho = self._parameters.common_correlation

        # The factor of the noise keeps the standard deviation at 1.
        shift = np.empty(len(noise))
        shift[0] = noise[0]
        for k in range(1, len(noise)):
            shift[k] = rho * shift[k - 1] + np.sqrt(1.0 - rho**2) * noise[k]
        return shift


@lru_cache(maxsize=256)
def _gains(parameters: TimingParameters, dancers: int) -> tuple[Array, Array]:
    """(D, D) gains of phase correction and of period correction, which groups with the same parameters share."""
    phase = np.eye(dancers) - parameters.transition_matrix(dancers)
    period = parameters.period_gains(dancers)
    phase.flags.writeable = False
    period.flags.writeable = False
    return phase, period


def _tempo_error(nominal_s: Array, beats: Array, anticipation: float) -> Array:
    """(E,) lateness that the part of a tempo change that was not foreseen adds at each event [s].

    Dancers predict an interval from the tempo of the last one; the first two events have no prediction.
    """
    interval = np.diff(nominal_s, prepend=nominal_s[0])
    beat = np.diff(beats, prepend=beats[0])

    out = np.zeros(len(beats))
    out[2:] = (1.0 - anticipation) * (interval[1:-1] * beat[2:] / beat[1:-1] - interval[2:])
    return out


def _lognormal(spread: float, rng: np.random.Generator) -> float:
    """A factor with mean 1 and the given log standard deviation; it always uses one draw, also without spread."""
    return float(np.exp(spread * rng.standard_normal() - spread**2 / 2))
