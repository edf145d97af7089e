"""A policy that was trained in the Gymnasium environment, as a method: two matrix products and a maximum."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..core import Array, Event, Kind, Move
from ..core.errors import ConfigError
from ..core.method_io import MethodAction, MethodContext, ScheduleCommand, SetTimer
from ..core.registry import register
from .observation import MOVES, EventFeatures, iteration_at

_MOVE = {
    Kind.START_FORWARD: Move.FORWARD,
    Kind.STOP_FORWARD: Move.STOP,
    Kind.START_BACKWARD: Move.BACKWARD,
    Kind.STOP_BACKWARD: Move.STOP,
    Kind.CLAP: Move.TURN,
    Kind.TURN: Move.TURN,
}


@dataclass(frozen=True, slots=True)
class LearnedConfig:
    """Options of a learned method.

    Attributes:
        policy: npz file that ``scripts/train_policy.py`` wrote.
    """

    policy: str = ""

    def __post_init__(self) -> None:
        if not self.policy:
            raise ConfigError("learned.policy", self.policy, "the npz file of a trained policy")


@dataclass(frozen=True, slots=True)
class PolicyNetwork:
    """A fully connected network with tanh between its layers.

    Attributes:
        mean: (N,) of the features in training.
        std: (N,) their standard deviations.
        clip: bound of the normalised features.
        layers: weights (out, in) and biases (out,), first to last.
        step_hz: decisions per second in training.
    """

    mean: Array
    std: Array
    clip: float
    layers: tuple[tuple[Array, Array], ...]
    step_hz: int

    @classmethod
    def read(cls, path: str | Path) -> PolicyNetwork:
        """Read an npz file with ``mean``, ``std``, ``clip``, ``step_hz`` and ``w0``, ``b0``, ``w1``, ...

        Raises:
            ConfigError: the file cannot be read, or its arrays do not fit together.
        """
        try:
            with np.load(path, allow_pickle=False) as stored:
                arrays = {name: np.asarray(stored[name], dtype=np.float64) for name in stored.files}
            count = sum(name.startswith("w") for name in arrays)
            layers = tuple((arrays[f"w{k}"], arrays[f"b{k}"]) for k in range(count))
            network = cls(arrays["mean"], arrays["std"], float(arrays["clip"]), layers, int(arrays["step_hz"].item()))
            scores = network.scores(network.mean)
        except (OSError, KeyError, ValueError) as problem:
            # Of a file of another kind numpy only says that it might be unsafe to load.
            why = "it is none" if "pickle" in str(problem) else problem
            raise ConfigError("learned.policy", str(path), f"the npz file of a trained policy ({why})") from problem
        if scores.shape != (len(MOVES),) or not np.isfinite(scores).all() or not 1 <= network.step_hz <= 120:
            raise ConfigError("learned.policy", str(path), f"a policy with {len(MOVES)} finite scores")
        return network

    def scores(self, features: Array) -> Array:
        """(4,) how much each of `features.MOVES` is wanted."""
        x = np.clip((features - self.mean) / self.std, -self.clip, self.clip)
        for weights, bias in self.layers[:-1]:
            x = np.tanh(weights @ x + bias)
        weights, bias = self.layers[-1]
        return np.asarray(weights @ x + bias)


LEEWAY_BEATS = 3.0
"""So long before a step's beat its move may mean it; people are rarely so early (assumed)."""


class StepSelector:
    """What a wanted move means in the score: the step of that move whose beat is nearest, each sent once and in order.

    The environment lets a policy do anything at any time; this does not. A step may be late, so that a move which has
    begun can always be stopped, but not earlier than `LEEWAY_BEATS`. In the rehearsal it stands still.

    Args:
        context: the dance.
    """

    def __init__(self, context: MethodContext) -> None:
        self._context = context
        self._last = (0, -1)
        self._beats = [
            [(step.beat, step.ordinal) for step in context.steps if _MOVE[step.kind] is move] for move in MOVES
        ]
        self.move = 0
        """The move in force, by its place in `MOVES`."""

    def select(self, t_s: float, wanted: int) -> tuple[int, int] | None:
        """Send the step that a wanted move means: its iteration and ordinal, or None where there is nothing to send.

        Args:
            t_s: session time.
            wanted: a move by its place in `MOVES`; the one in force means none.
        """
        iteration = iteration_at(self._context, t_s)
        if iteration == 0 or wanted == self.move:
            return None
        beat = self._context.beat(iteration, t_s)
        near = [
            (abs(own - beat), ordinal) for own, ordinal in self._beats[wanted]
            if own <= beat + LEEWAY_BEATS and (iteration, ordinal) > self._last
        ]  # fmt: skip
        if not near:
            return None
        self._last = (iteration, min(near)[1])
        self.move = wanted
        return self._last


@register("anticipation", "learned", config=LearnedConfig)
class Learned:
    """Asks a trained policy some times a second which move it wants, and sends the step that this means; see `StepSelector`.

    Args:
        config: its options.

    Raises:
        ConfigError: there is no usable policy in the file.
    """

    def __init__(self, config: LearnedConfig) -> None:
        self._network = PolicyNetwork.read(config.policy)

    def reset(self, context: MethodContext, rng: np.random.Generator) -> None:
        """Begin a dance.

        Raises:
            ConfigError: the policy was trained with other people or another dance.
        """
        self._context = context
        self._features = EventFeatures(context)
        self._steps = StepSelector(context)
        self._sent_s = -math.inf
        self._begun = False
        width = len(self._features.row(0.0, 0, 0.0))
        if width != len(self._network.mean):
            raise ConfigError("learned.policy", len(self._network.mean), f"a policy of {width} features")

    def on_event(self, event: Event) -> Sequence[MethodAction]:
        """Remember."""
        self._features.add(event)
        return ()

    def on_iteration_start(self, iteration: int, t_s: float) -> Sequence[MethodAction]:
        """Begin to ask."""
        if self._begun:
            return ()
        self._begun = True
        return self.on_timer(t_s)

    def on_iteration_end(self, iteration: int, t_s: float) -> Sequence[MethodAction]:
        """Nothing to learn any more."""
        return ()

    def on_timer(self, t_s: float) -> Sequence[MethodAction]:
        """Ask, and ask again after one decision's time."""
        if t_s > self._context.window_end_s[-1]:
            return ()
        again = SetTimer(t_s + 1.0 / self._network.step_hz)
        scores = self._network.scores(self._features.row(t_s, self._steps.move, self._sent_s).astype(np.float64))
        wanted = int(np.argmax(scores))
        key = self._steps.select(t_s, wanted)
        if key is None:
            return (again,)
        self._sent_s = t_s
        return ScheduleCommand(*key, t_s, f"the policy wants {MOVES[wanted].value}"), again
