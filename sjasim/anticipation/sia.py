"""Synchronisation index-based anticipation: the robot follows the most synchronous dancer of the last iteration.

Source: iqbal2016, section III-A.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..core import Array, Event, Kind
from ..core.errors import ConfigError
from ..core.method_io import CancelCommand, MethodAction, MethodContext, ScheduleCommand, SetTimer
from ..core.registry import register
from .eca import scheduled
from .event_history import EventHistory
from .scheduled_method import LEAD_S, ScheduledMethod
from .synchrony import most_synchronous
from .timing_appropriateness import EPSILON_S

STARTS = (Kind.START_FORWARD, Kind.START_BACKWARD)
FIRST = (Kind.START_FORWARD, Kind.CLAP)
"""Steps with which something new begins; every other one goes on from the one before it."""

HOLD_S = 0.15
"""Shortest pause between two moves that the robot makes without anybody to follow [s] (assumed)."""

SHORTEST = 0.5
"""Least share of its length in which the robot dances a phrase that it began too late (assumed)."""


@dataclass(frozen=True, slots=True)
class SiaConfig:
    """Options of SIA. How many early frames make an early event is the detector's option, not the method's.

    Attributes:
        window_s: an event is followed within this distance of the same event one iteration ago; narrower misses
            a group that starts early or late together, wider follows false events (assumed: iqbal2016 says
            "close to"; below 1.5 s many events fall out).
        clap_wait_s: a turn waits so long past its scheduled time for the dancer's clap, which nothing announces
            (assumed: iqbal2016 excludes claps from the early events and does not say what replaces one); as long as
            the window it ends beyond the iteration's own.
        first_followed_iteration: first iteration in which a dancer is followed; before it the schedule is ECA's.
        lead_s: how long before a scheduled time a command is sent; larger makes unfollowed moves earlier.
        epsilon_s: as in ECA.
        edges: the robot's outgoing edges while it follows nobody: ``none`` or ``all`` (`Sia.follows`).
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
    """SIA: chooses the most synchronous dancer when an iteration closes, and follows them through the next one.

    Only the next unresolved step is listened for. An early event of the followed dancer triggers it, else their
    regular event, within the window around the same dancer's time one iteration ago (the schedule's, where they
    lack it); what goes on from a step that was followed needs no window: a dancer who takes the whole phrase three
    seconds early is followed through it. A clap has no early event. If the window closes with neither, the scheduled
    command is used, at once if its time has passed, and the decision says ``fallback``. If meanwhile a regular event
    shows that the dancer is past the step, a stop or turn falls back at once. A move that is over when its stop is seen
    is made at once, as long as the schedule has it, if it will be over before the dancer is expected to do the next
    thing; else it is passed over.

    A move back falls back in time to be over before the dancer is expected to do the next thing. When a start falls
    back, its dancer has left out a whole phrase: the rest of it, to where the robot came from, is scheduled at once,
    not each step at the close of its own window, which would leave no time before the turn; it is made shorter if it
    would otherwise not be over in time. Whoever comes back is waited for again.

    Args:
        config: its options.
    """

    def __init__(self, config: SiaConfig = SiaConfig()) -> None:
        self._config = config

    def reset(self, context: MethodContext, rng: np.random.Generator) -> None:
        """Begin a dance."""
        super().reset(context, rng)
        self._history = EventHistory(context, self._config.epsilon_s)
        self._chosen: dict[int, str] = {}
        self._before: str | None = None
        self._leader = ""
        self._note = ""
        self._start_s = 0.0
        self._next = len(context.steps)
        self._reference: Array = np.zeros(len(context.steps))
        self._close: Array = np.zeros(len(context.steps))
        self._planned: tuple[ScheduleCommand, ...] = ()
        self._fallbacks: tuple[ScheduleCommand, ...] = ()
        self._followed = -2
        self._alone: dict[float, int] = {}
        self._hurried: dict[int, float] = {}

    def follows(self, iteration: int) -> tuple[str, ...] | None:
        """The dancer chosen when the last iteration closed; before `SiaConfig.first_followed_iteration` nobody, or everyone."""
        if iteration >= self._config.first_followed_iteration and iteration - 1 in self._chosen:
            return (self._chosen[iteration - 1],)
        return () if self._config.edges == "none" else None

    def on_event(self, event: Event) -> Sequence[MethodAction]:
        """Remember, and follow if it is the leader's and expected."""
        self._history.add(event)
        if event.person != self._leader or (event.early and event.kind == Kind.CLAP):
            return ()
        self._pass_closed(event.t_arrival_s)
        after = event.t_s - self._start_s
        step = self._next if self._goes_on(event.kind) else self._step_of(event.kind, after)
        if step is None or step < self._next:
            return ()
        if step == self._next:
            return (self._follow(event), *self._wait_again())
        if event.early or after < self._reference[self._next]:
            return ()
        over = self._context.steps[step - 1].kind in STARTS
        skipped = [self._pass_over(event) for _ in range(step - self._next - over)]
        return (*skipped, *(self._make_late(event) if over else (self._follow(event),)))

    def on_iteration_end(self, iteration: int, t_s: float) -> Sequence[MethodAction]:
        """Let go of the dancer that was followed, and prepare the next iteration."""
        self._leader = ""
        return super().on_iteration_end(iteration, t_s)

    def _schedule(self, iteration: int) -> Sequence[MethodAction]:
        self._choose(iteration - 1)
        intentions = scheduled(self._context, self._history, iteration, self._config.lead_s)
        if iteration < self._config.first_followed_iteration:
            return intentions
        self._leader = self._chosen[iteration - 1]
        own = self._history.times(iteration - 1)[self._context.cast.index(self._leader)]
        self._reference = np.where(np.isfinite(own), own, self._history.schedule)
        self._start_s = self._context.iteration_start_s[iteration]
        end = self._context.window_end_s[iteration] - self._start_s
        self._close = np.minimum(self._reference + self._config.window_s, end)
        for plan, then in zip(intentions, (*intentions[1:], None), strict=True):
            step, latest = plan.ordinal, np.inf
            kind = self._context.steps[step].kind
            if kind is Kind.CLAP:
                latest = plan.t_s - self._start_s + self._config.clap_wait_s
            elif kind in STARTS and kind not in FIRST and then is not None:
                latest = max(self._reference[step], self._expected(step + 2) - HOLD_S - (then.t_s - plan.t_s))
            self._close[step] = min(self._close[step], latest)
        self._next, self._followed = 0, -2
        self._planned = intentions
        why = f"fallback: no event within {self._config.window_s:g} s of the time expected of {self._note}"
        fallbacks = tuple(
            replace(plan, t_s=self._start_s + min(max(close, plan.t_s - self._start_s), end), why=why, last_resort=True)
            for plan, close in zip(intentions, self._close.tolist(), strict=True)
        )
        starts = [step.ordinal for step in self._context.steps if step.kind in STARTS]
        self._alone = {fallbacks[ordinal].t_s: ordinal for ordinal in starts}
        self._fallbacks, self._hurried = fallbacks, {}
        return (*fallbacks, *map(SetTimer, self._alone))

    def on_timer(self, t_s: float) -> Sequence[MethodAction]:
        """A start's window has closed: go on alone if nobody was followed, and the start is not made already."""
        begun = self._alone.pop(t_s, None)
        if begun is None or not self._leader or self._hurried.get(begun, np.inf) <= t_s:
            return ()
        self._next = max(self._next, begun + 1)
        return self._rest_of_phrase(begun, t_s)

    def _rest_of_phrase(self, begun: int, t_s: float) -> tuple[ScheduleCommand, ...]:
        """The schedule up to the end of the phrase, moved on as far as a start that fell back needs it.

        Its pauses shrink to `HOLD_S`, and all of it to half at most, if it would not be over when the dancer is
        expected to do the next thing.

        Args:
            begun: ordinal of that start.
            t_s: when its command was sent [s].
        """
        rest: list[int] = []
        times = [t_s]
        for step in self._context.steps[begun + 1 :]:
            if step.kind in FIRST:
                break
            plan, before = self._planned[step.ordinal], self._planned[step.ordinal - 1]
            times.append(max(plan.t_s, times[-1] + (HOLD_S if step.kind in STARTS else plan.t_s - before.t_s)))
            rest.append(step.ordinal)
        left_s = self._start_s + self._expected(begun + len(times)) - HOLD_S - t_s
        share = min(1.0, max(SHORTEST, left_s / (times[-1] - t_s)))
        hurried = [t_s + share * (time - t_s) for time in times[1:]]
        self._hurried.update(zip(rest, hurried, strict=True))
        why = f"fallback: {self._context.steps[begun].kind.value} was made without {self._note}"
        return tuple(
            ScheduleCommand(self._scheduled, ordinal, time, why) for ordinal, time in zip(rest, hurried, strict=True)
        )

    def _expected(self, step: int) -> float:
        """When the dancer is expected to do a step, after beat 0 [s]; after an iteration's last one nothing presses."""
        return float(self._reference[step]) if step < len(self._reference) else np.inf

    def _choose(self, iteration: int) -> None:
        series = self._history.series(iteration)
        choice = most_synchronous(series, self._before, self._context.tau_s)
        self._chosen[iteration] = choice.person
        if any(kinds for _, kinds in series.values()):
            self._before = choice.person
        others = ", ".join(name for name in choice.tied if name != choice.person)
        self._note = f"{choice.person}, most synchronous in iteration {iteration}"
        if others:
            self._note += f" (tie with {others})"

    def _pass_closed(self, now_s: float) -> None:
        while self._next < len(self._close) and now_s >= self._start_s + self._close[self._next]:
            self._next += 1

    def _goes_on(self, kind: Kind) -> bool:
        """Whether it goes on from the step that was followed just before: that needs no window."""
        if self._followed != self._next - 1 or self._next == len(self._context.steps):
            return False
        return kind == self._context.steps[self._next].kind and kind not in FIRST

    def _step_of(self, kind: Kind, after_s: float) -> int | None:
        """The step whose expected time is nearest, if the window holds the event."""
        own = [(abs(self._reference[step.ordinal] - after_s), step.ordinal)
               for step in self._context.steps if step.kind == kind]  # fmt: skip
        distance, ordinal = min(own, default=(np.inf, -1))
        return ordinal if distance <= self._config.window_s else None

    def _wait_again(self) -> tuple[ScheduleCommand, ...]:
        """The own fallbacks again of all steps ahead that were scheduled without a dancer who has just come back."""
        if self._followed != self._next - 1 or self._next not in self._hurried:
            return ()
        ahead = [step for step in self._hurried if step >= self._next]
        for step in ahead:
            del self._hurried[step]
        return tuple(self._fallbacks[step] for step in ahead)

    def _settle(self) -> None:
        """The next step has its answer: nothing is to be done alone."""
        self._alone = {t_s: ordinal for t_s, ordinal in self._alone.items() if ordinal != self._next}
        self._next += 1

    def _follow(self, event: Event) -> ScheduleCommand:
        step = self._context.steps[self._next]
        self._followed = step.ordinal
        self._settle()
        why = f"{'early ' if event.early else ''}{event.kind.value} of {self._note}"
        return ScheduleCommand(self._scheduled, step.ordinal, event.t_arrival_s, why, event.person)

    def _make_late(self, event: Event) -> Sequence[MethodAction]:
        """Answers for a move whose stop was the first that was seen of it."""
        begun = self._next
        start, stop = self._planned[begun : begun + 2]
        ends_s = event.t_arrival_s + stop.t_s - start.t_s
        after = self._reference[begun + 2 : begun + 3]
        if ends_s + HOLD_S > self._start_s + (after[0] if len(after) else self._close[begun + 1]):
            return [self._pass_over(event), self._pass_over(event, whole=True)]
        self._settle()
        self._settle()
        why = f"made late: {event.kind.value} already seen of {self._note}"
        return [
            ScheduleCommand(self._scheduled, begun, event.t_arrival_s, why),
            ScheduleCommand(self._scheduled, begun + 1, ends_s, why),
        ]

    def _pass_over(self, event: Event, *, whole: bool = False) -> MethodAction:
        """Actions for a step that the leader is past; ``whole`` for the stop of a start that was passed over."""
        step = self._context.steps[self._next]
        self._settle()
        if whole or step.kind in STARTS:
            return CancelCommand(
                self._scheduled, step.ordinal, f"passed over: {event.kind.value} already seen of {self._note}"
            )
        why = f"fallback: {event.kind.value} already seen of {self._note}"
        return ScheduleCommand(self._scheduled, step.ordinal, event.t_arrival_s, why)
