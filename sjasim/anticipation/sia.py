"""Synchronisation index-based anticipation (SIA): the robot follows the most synchronous dancer of the last iteration.

Source: iqbal2016, section III-A. Statements of the paper, and the code that implements them:

- "at the beginning of each iteration we measured the most synchronous person of the group": `Sia._select_leader`, with
  the individual index of eqs. (1) to (6) in `synchrony.most_synchronous`.
- "during the next iteration the server will track all movements of MSP": `Sia.on_event`.
- "close to the timing of events of MSP": `SiaConfig.window_s`, a window around the time of the leader's same event in
  the last iteration.
- "the server received early detected events: [it] sent appropriate commands to the robot": `Sia._follow_event`.
- "excluding the clap event": an early clap triggers no command; a regular clap does.

The paper does not specify what happens when an expected event is missing, when the leader is ahead of the robot, when
indices are tied, or before a leader is selected. The rules for these cases are assumed and documented at `Sia`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..core import Array, Event, Kind
from ..core.errors import ConfigError
from ..core.method_io import CancelCommand, MethodAction, MethodContext, ScheduleCommand, SetTimer
from ..core.registry import register
from .eca import schedule_from_history
from .event_history import EventHistory
from .scheduled_method import LEAD_S, ScheduledMethod
from .synchrony import most_synchronous
from .timing_appropriateness import EPSILON_S

STARTS = (Kind.START_FORWARD, Kind.START_BACKWARD)
"""Events with which a move starts."""

PHRASE_STARTS = (Kind.START_FORWARD, Kind.CLAP)
"""Events with which a phrase starts; every other event belongs to the phrase of the event before it.

A phrase is a move forward and the move back to the slot.
"""

MIN_PAUSE_S = 0.15
"""Shortest pause between two moves that are not triggered by the leader's events [s] (assumed)."""

MIN_PHRASE_SHARE = 0.5
"""Smallest ratio of the shortened to the planned duration of a phrase that started late (assumed)."""

_NO_STEP = -2
"""Value of `Sia._last_followed` before a step has been followed. It is -2 because -1 would precede step 0."""


@dataclass(frozen=True, slots=True)
class SiaConfig:
    """Options of SIA. Detection of early events is configured in `config.DetectorConfig`.

    Attributes:
        window_s: largest time between an event and the leader's same event of the last iteration at which the event is
            followed [s]. A smaller value misses events when the whole group is early or late; a larger value follows
            more false events (assumed: iqbal2016 says "close to"; below 1.5 s many events are missed).
        clap_wait_s: longest time after its scheduled time that a turn waits for the leader's clap [s] (assumed:
            iqbal2016 excludes claps from the early events). If it were as long as ``window_s``, the turn would end
            after the iteration's window.
        first_followed_iteration: first iteration in which a dancer is followed; earlier iterations are scheduled as in
            ECA.
        lead_s: time between the sending of a scheduled command and the time for which it is scheduled [s]. A larger
            value makes moves that do not follow an event earlier.
        epsilon_s: largest gap between neighbouring times of one cluster, as in ECA [s].
        edges: outgoing edges of the robot in the group topology graph while it follows no dancer: ``none`` or ``all``,
            see `Sia.follows`.
    """

    window_s: float = 2.0
    clap_wait_s: float = 1.0
    first_followed_iteration: int = 2
    lead_s: float = LEAD_S
    epsilon_s: float = EPSILON_S
    edges: str = "none"

    def __post_init__(self) -> None:
        for name, value, low in (
            ("window_s", self.window_s, 0.05),
            ("clap_wait_s", self.clap_wait_s, 0.0),
            ("first_followed_iteration", self.first_followed_iteration, 1),
            ("lead_s", self.lead_s, -2.0),
            ("epsilon_s", self.epsilon_s, 0.0),
        ):
            if not low <= value <= 64:
                raise ConfigError(f"sia.{name}", value, f"a number from {low:g} to 64")
        if self.edges not in ("none", "all"):
            raise ConfigError("sia.edges", self.edges, "none or all")


@register("anticipation", "sia", config=SiaConfig)
class Sia(ScheduledMethod):
    """Selects the most synchronous dancer (the leader) at the end of an iteration, and follows it in the next one.

    **Following.** The steps of an iteration are resolved in order: each is followed, sent as a fallback, or skipped.
    The next unresolved step is triggered by the leader's early event, or by its regular event if no early event was
    detected. The event must lie in a window around the time of the leader's same event in the last iteration, or around
    the scheduled time if there was none. The window does not apply to a step that continues the phrase of a step that
    was followed, so that a leader who performs a whole phrase three seconds early is followed to its end.

    **Fallback.** If no event arrives within the window, the scheduled command is sent when the window closes, and the
    decision log says ``fallback``. The window of a move back closes early enough for the move to end before the
    leader's next expected step. If the start of a move is sent as a fallback, the leader is assumed to have left out
    the phrase. The rest of the phrase is then scheduled at once, because waiting for the windows of its steps would
    leave no time before the turn. It is shortened if it would end too late. The remaining steps get their original
    fallbacks back if the leader's events are detected again within the phrase.

    **Leader ahead of the robot.** If a regular event shows that the leader is past the next unresolved step, a stop or
    turn is sent at once. If the first detected event of a move is its stop, the move is performed late, provided that
    it ends before the leader's next expected step; otherwise it is skipped.

    Args:
        config: options.
    """

    def __init__(self, config: SiaConfig = SiaConfig()) -> None:
        self._config = config

    def reset(self, context: MethodContext, rng: np.random.Generator) -> None:
        """Prepare for a dance, and discard the state of the last one."""
        super().reset(context, rng)
        count = len(context.steps)
        self._history = EventHistory(context, self._config.epsilon_s)

        self._leaders: dict[int, str] = {}
        """Iteration -> its most synchronous person."""
        self._previous_msp: str | None = None
        """Most synchronous person of the last iteration with events; it decides ties."""
        self._leader = ""
        """Name of the dancer who is followed in the present iteration; "" if none is."""
        self._leader_note = ""
        """Name of the leader and the reason for its selection, for the decision log."""

        self._start_s = 0.0
        """Session time of the iteration's beat 0; the two arrays below are relative to it [s]."""
        self._expected_s: Array = np.zeros(count)
        """(K,) expected time of the leader's event of each step [s]."""
        self._window_end_s: Array = np.zeros(count)
        """(K,) time at which the window of each step closes [s]."""

        self._next_step = count
        """Ordinal of the next unresolved step; all steps before it are resolved."""
        self._last_followed = _NO_STEP
        """Ordinal of the last step that an event of the leader triggered."""

        self._predicted: tuple[ScheduleCommand, ...] = ()
        """Commands at the times that ECA predicts."""
        self._fallbacks: tuple[ScheduleCommand, ...] = ()
        """Commands that are sent if no event of the leader is detected within the window."""
        self._start_timers: dict[float, int] = {}
        """Session time at which the fallback of a start is sent [s] -> its ordinal, for unresolved starts."""
        self._completion_s: dict[int, float] = {}
        """Ordinal -> session time of each step that `_complete_phrase` has scheduled [s]."""

    def follows(self, iteration: int) -> tuple[str, ...] | None:
        """Return the dancer that the robot follows in an iteration: the most synchronous one of the iteration before.

        Returns:
            a tuple with one name. Before `SiaConfig.first_followed_iteration` it is empty, or None (all dancers) with
            ``edges = all``.

        Source: iqbal2016, section VI-A, on the robot's edges.
        """
        if iteration >= self._config.first_followed_iteration and iteration - 1 in self._leaders:
            return (self._leaders[iteration - 1],)
        return () if self._config.edges == "none" else None

    def on_event(self, event: Event) -> Sequence[MethodAction]:
        """Add the event to the history, and send the command of a step if it is an expected event of the leader."""
        self._history.add(event)
        if event.person != self._leader or (event.early and event.kind == Kind.CLAP):
            return ()
        self._skip_closed_steps(event.t_arrival_s)

        # An event that continues a followed phrase belongs to the next step; any other, to the step expected nearest.
        after_s = event.t_s - self._start_s
        step = self._next_step if self._continues_followed_step(event.kind) else self._nearest_step(event.kind, after_s)
        if step is None or step < self._next_step:
            return ()
        if step == self._next_step:
            return (self._follow_event(event), *self._restore_fallbacks())

        # The event belongs to a later step, so the leader may be ahead of the robot. Early events are not reliable
        # enough to conclude this, and neither is an event that precedes the expected time of the next step.
        if event.early or after_s < self._expected_s[self._next_step]:
            return ()
        is_stop_of_missed_move = self._context.steps[step - 1].kind in STARTS
        skipped = [self._skip_step(event) for _ in range(step - self._next_step - is_stop_of_missed_move)]
        if is_stop_of_missed_move:
            return (*skipped, *self._schedule_late_move(event))
        return (*skipped, self._follow_event(event))

    def on_iteration_end(self, iteration: int, t_s: float) -> Sequence[MethodAction]:
        """Stop following the leader, and return the commands of the next iteration."""
        self._leader = ""
        return super().on_iteration_end(iteration, t_s)

    def on_timer(self, t_s: float) -> Sequence[MethodAction]:
        """Schedule the rest of a phrase whose start has just been sent as a fallback.

        Returns no action if the start is resolved already, or if `_complete_phrase` has scheduled it earlier.
        """
        start = self._start_timers.pop(t_s, None)
        if start is None or not self._leader or self._completion_s.get(start, np.inf) <= t_s:
            return ()
        self._next_step = max(self._next_step, start + 1)
        return self._complete_phrase(start, t_s)

    def _schedule_iteration(self, iteration: int) -> Sequence[MethodAction]:
        """Select the leader, and return the fallback of every step and the timers of the starts."""
        self._select_leader(iteration - 1)
        predicted = schedule_from_history(self._context, self._history, iteration, self._config.lead_s)
        if iteration < self._config.first_followed_iteration:
            return predicted

        # Where the leader has no event in the last iteration (omitted or not detected), use the time that ECA predicts.
        self._leader = self._leaders[iteration - 1]
        leader_s = self._history.step_times(iteration - 1)[self._context.cast.index(self._leader)]
        self._expected_s = np.where(np.isfinite(leader_s), leader_s, self._history.schedule)
        self._start_s = self._context.iteration_start_s[iteration]
        self._predicted = predicted
        self._window_end_s = self._window_ends(iteration)
        self._next_step = 0
        self._last_followed = _NO_STEP

        self._fallbacks = self._fallback_commands(iteration)
        starts = [step.ordinal for step in self._context.steps if step.kind in STARTS]
        self._start_timers = {self._fallbacks[ordinal].t_s: ordinal for ordinal in starts}
        self._completion_s = {}
        return (*self._fallbacks, *map(SetTimer, self._start_timers))

    def _select_leader(self, iteration: int) -> None:
        """Store the most synchronous dancer of an iteration that has ended.

        Source: iqbal2016, section III-A.3: "The person with the highest individual synchronization index during an
        iteration is considered the most synchronous person of the group".
        """
        series = self._history.series(iteration)
        # Use the tau of the session's measures, so that they report the same most synchronous person.
        choice = most_synchronous(series, self._previous_msp, self._context.tau_s)
        self._leaders[iteration] = choice.person
        # Without events all dancers are tied at 0; the choice is then arbitrary and must not decide the next tie.
        if any(kinds for _, kinds in series.values()):
            self._previous_msp = choice.person

        others = ", ".join(name for name in choice.tied if name != choice.person)
        self._leader_note = f"{choice.person}, most synchronous in iteration {iteration}"
        if others:
            self._leader_note += f" (tie with {others})"

    def _window_ends(self, iteration: int) -> Array:
        """(K,) time after beat 0 at which the window of each step closes [s]."""
        iteration_end_s = self._context.window_end_s[iteration] - self._start_s
        ends_s = np.minimum(self._expected_s + self._config.window_s, iteration_end_s)

        for command, following in zip(self._predicted, (*self._predicted[1:], None), strict=True):
            step = command.ordinal
            kind = self._context.steps[step].kind
            latest_s = np.inf
            if kind is Kind.CLAP:
                latest_s = command.t_s - self._start_s + self._config.clap_wait_s
            elif kind is Kind.START_BACKWARD and following is not None:
                # The move back must end before the leader starts the next phrase, two steps later.
                duration_s = following.t_s - command.t_s
                latest_s = max(self._expected_s[step], self._expected_time_s(step + 2) - MIN_PAUSE_S - duration_s)
            ends_s[step] = min(ends_s[step], latest_s)
        return ends_s

    def _fallback_commands(self, iteration: int) -> tuple[ScheduleCommand, ...]:
        """One command for each step at the end of its window, or at its predicted time if that is later."""
        iteration_end_s = self._context.window_end_s[iteration] - self._start_s
        return tuple(
            replace(
                command,
                t_s=self._start_s + min(max(end_s, command.t_s - self._start_s), iteration_end_s),
                why=self._fallback_reason(command.ordinal),
                last_resort=True,
            )
            for command, end_s in zip(self._predicted, self._window_end_s.tolist(), strict=True)
        )

    def _fallback_reason(self, step: int) -> str:
        """Reason of the fallback of a step; windows end at different times after the expected event."""
        wait_s = float(self._window_end_s[step] - self._expected_s[step])
        kind = self._context.steps[step].kind.value
        side = "after" if wait_s >= 0 else "before"
        return f"fallback: no {kind} of {self._leader_note} until {abs(wait_s):.1f} s {side} its expected time"

    def _complete_phrase(self, start: int, t_s: float) -> tuple[ScheduleCommand, ...]:
        """Return the commands for the rest of a phrase whose start was sent as a fallback.

        Steps are first delayed as far as the late start requires, with pauses reduced to `MIN_PAUSE_S`. If the phrase
        would then end after the leader's next expected step, its remaining duration is multiplied by a factor of at
        least `MIN_PHRASE_SHARE`.

        Args:
            start: ordinal of the start.
            t_s: session time at which the command of the start was sent [s].
        """
        rest: list[int] = []
        # Delay the predicted steps of the phrase until after the late start; none moves to before its predicted time.
        times_s = [t_s]
        for step in self._context.steps[start + 1 :]:
            if step.kind in PHRASE_STARTS:
                break
            command = self._predicted[step.ordinal]
            before = self._predicted[step.ordinal - 1]
            gap_s = MIN_PAUSE_S if step.kind in STARTS else command.t_s - before.t_s
            times_s.append(max(command.t_s, times_s[-1] + gap_s))
            rest.append(step.ordinal)

        left_s = self._start_s + self._expected_time_s(start + len(times_s)) - MIN_PAUSE_S - t_s
        share = min(1.0, max(MIN_PHRASE_SHARE, left_s / (times_s[-1] - t_s)))
        shortened_s = [t_s + share * (time_s - t_s) for time_s in times_s[1:]]
        self._completion_s.update(zip(rest, shortened_s, strict=True))

        why = f"fallback: {self._context.steps[start].kind.value} was made without {self._leader_note}"
        return tuple(
            ScheduleCommand(self._scheduled_iteration, ordinal, time_s, why)
            for ordinal, time_s in zip(rest, shortened_s, strict=True)
        )

    def _expected_time_s(self, step: int) -> float:
        """Expected time of the leader's event of a step, after beat 0 [s]; infinite beyond the last step."""
        return float(self._expected_s[step]) if step < len(self._expected_s) else np.inf

    def _skip_closed_steps(self, now_s: float) -> None:
        """Mark steps whose window has closed as resolved, since their fallbacks have been sent."""
        count = len(self._window_end_s)
        while self._next_step < count and now_s >= self._start_s + self._window_end_s[self._next_step]:
            self._next_step += 1

    def _continues_followed_step(self, kind: Kind) -> bool:
        """Whether an event of this kind continues the phrase of the step followed last, so that no window applies."""
        if self._last_followed != self._next_step - 1 or self._next_step == len(self._context.steps):
            return False
        return kind == self._context.steps[self._next_step].kind and kind not in PHRASE_STARTS

    def _nearest_step(self, kind: Kind, after_s: float) -> int | None:
        """Ordinal of the step of this kind whose expected time is nearest; None if it is farther than ``window_s``."""
        candidates = [
            (abs(self._expected_s[step.ordinal] - after_s), step.ordinal)
            for step in self._context.steps
            if step.kind == kind
        ]
        distance_s, ordinal = min(candidates, default=(np.inf, -1))
        return ordinal if distance_s <= self._config.window_s else None

    def _restore_fallbacks(self) -> tuple[ScheduleCommand, ...]:
        """Return the original fallbacks of the remaining steps when the leader resumes a phrase under completion."""
        if self._last_followed != self._next_step - 1 or self._next_step not in self._completion_s:
            return ()
        ahead = [step for step in self._completion_s if step >= self._next_step]
        for step in ahead:
            del self._completion_s[step]
        return tuple(self._fallbacks[step] for step in ahead)

    def _resolve_next_step(self) -> None:
        """Mark the next step as resolved, and remove its timer if it has one."""
        self._start_timers = {t_s: ordinal for t_s, ordinal in self._start_timers.items() if ordinal != self._next_step}
        self._next_step += 1

    def _follow_event(self, event: Event) -> ScheduleCommand:
        """Return the command of the next step, to be sent at once.

        Source: iqbal2016, section III-A.3, on the early detected events of the most synchronous person.
        """
        step = self._context.steps[self._next_step]
        self._last_followed = step.ordinal
        self._resolve_next_step()
        why = f"{'early ' if event.early else ''}{event.kind.value} of {self._leader_note}"
        return ScheduleCommand(self._scheduled_iteration, step.ordinal, event.t_arrival_s, why, event.person)

    def _schedule_late_move(self, event: Event) -> Sequence[MethodAction]:
        """Return commands for start and stop of a move whose start was not detected, or skip both if time is short."""
        begun = self._next_step
        start, stop = self._predicted[begun : begun + 2]
        ends_s = event.t_arrival_s + stop.t_s - start.t_s
        following = self._expected_s[begun + 2 : begun + 3]
        limit_s = following[0] if len(following) else self._window_end_s[begun + 1]
        if ends_s + MIN_PAUSE_S > self._start_s + limit_s:
            return [self._skip_step(event), self._skip_step(event, cancel=True)]

        self._resolve_next_step()
        self._resolve_next_step()
        why = f"made late: {event.kind.value} already seen of {self._leader_note}"
        return [
            ScheduleCommand(self._scheduled_iteration, begun, event.t_arrival_s, why),
            ScheduleCommand(self._scheduled_iteration, begun + 1, ends_s, why),
        ]

    def _skip_step(self, event: Event, *, cancel: bool = False) -> MethodAction:
        """Return the action for a step that the leader has passed: cancel the start of a move, send a stop or turn.

        Args:
            event: the event that shows that the leader has passed the step.
            cancel: cancel the step whatever its kind; used for the stop of a start that was cancelled.
        """
        step = self._context.steps[self._next_step]
        self._resolve_next_step()
        if cancel or step.kind in STARTS:
            why = f"passed over: {event.kind.value} already seen of {self._leader_note}"
            return CancelCommand(self._scheduled_iteration, step.ordinal, why)

        why = f"fallback: {event.kind.value} already seen of {self._leader_note}"
        return ScheduleCommand(self._scheduled_iteration, step.ordinal, event.t_arrival_s, why)
