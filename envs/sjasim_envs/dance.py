"""The Gymnasium environments: sessions whose robot is commanded by an agent. `sjasim.session` simulates them."""

from __future__ import annotations

import dataclasses
import math
import operator
from abc import abstractmethod
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import gymnasium as gym
import numpy as np
from gymnasium import error, spaces
from numpy.typing import NDArray

from sjasim.anticipation.method import build_method
from sjasim.anticipation.observation import MOVES
from sjasim.choreography.layout import layout
from sjasim.choreography.timetable import timetable
from sjasim.config import HUMANS_ONLY, SessionConfig
from sjasim.config.toml_file import from_plain
from sjasim.core import Move
from sjasim.core.errors import SjasimError
from sjasim.humans.body.body_model import body_model
from sjasim.session.dancers import make_human_timing
from sjasim.session.session import Session
from sjasim.simulation.physics_world import physics_of
from sjasim.simulation.rendering import Renderer
from sjasim.simulation.viewer_window import ViewerWindow

from .agent import Agent
from .observation import Observer
from .reward import RewardConfig, Scorer

AGENT = "agent"
"""Name of the method of a session in which the agent alone commands the robot."""

PlainAction = int | tuple[float, float]
"""An action as plain numbers: the index of a move, or speed [m/s] and yaw rate [rad/s]."""

OPTIONS = ("humans", "people", "faults", "method")
"""Options that ``reset(options=...)`` takes."""


class _Dance(gym.Env[Any, Any]):
    """Base class of all environments; see the documentation's page on environments.

    An environment can be copied and pickled at any time. A copy is made from the arguments, the configuration of the
    episode and its actions, by dancing them again: it shares nothing with the original, and equals it.

    Args:
        render_mode: ``rgb_array``, ``human`` or None.
        step_hz: decisions per second.
        skip_rehearsal: whether an episode begins after the rehearsal, in which the robot stands still.
        reward: weights, by the names of `reward.RewardConfig`.
        config: the configuration that ``options`` change; None for the defaults of `SessionConfig` with ``joints``
            sensing.
        width: width of pictures [px].
        height: height of pictures [px].
        options: fields of `SessionConfig`, tables as nested mappings. ``method`` names an anticipation method that
            sends commands beside the agent; ``seed`` is that of the first episode, unless `reset` is given one.

    Raises:
        error.Error: an option does not exist or is not allowed; the message names it.
    """

    metadata: dict[str, Any] = {"render_modes": ["human", "rgb_array"], "render_fps": 30}  # noqa: RUF012

    def __init__(
        self,
        *,
        render_mode: str | None = None,
        step_hz: int = 30,
        skip_rehearsal: bool = False,
        reward: Mapping[str, float] | None = None,
        config: SessionConfig | None = None,
        width: int = 640,
        height: int = 480,
        **options: Any,
    ) -> None:
        self._arguments = {
            "render_mode": render_mode,
            "step_hz": step_hz,
            "skip_rehearsal": skip_rehearsal,
            "reward": reward,
            "config": config,
            "width": width,
            "height": height,
            **options,
        }
        _check_arguments(self.metadata["render_modes"], render_mode, step_hz, skip_rehearsal, config)

        self.config = _configured(config or SessionConfig(method=AGENT, sensing="joints"), options)
        self._first_seed = self.config.seed if "seed" in options or config is not None else None
        self._weights = RewardConfig.from_mapping(reward or {})
        self._skip_rehearsal = skip_rehearsal
        self._step_hz = step_hz
        self.metadata = {**self.metadata, "render_fps": step_hz}
        self.render_mode = render_mode
        self._size = width, height
        self._pictures: Renderer | ViewerWindow | None = None
        self._observer = self._checked_observer()
        self.observation_space = self._observer.space

        self._session: Session | None = None
        self._actions: list[PlainAction] = []
        self._steps = 0
        self._over = False
        self._closed = False

    def _checked_observer(self) -> Observer:
        """Make the observer, and find out now what would fail when an episode begins."""
        config = self.config
        try:
            if self.render_mode == "human":
                ViewerWindow.check_display()
            Renderer.check_size(*self._size)
            if config.method != AGENT:
                build_method(config.method, config.method_options)
            table = timetable(config)
            make_human_timing(config, table)
            body_model(config.body.model)
            mounts = layout(config).mounts
        except SjasimError as problem:
            raise error.Error(str(problem)) from problem
        return Observer(config, len(table.choreography.steps()), tuple(mount.name for mount in mounts))

    @property
    def session(self) -> Session:
        """The session of the present episode, with its log.

        Raises:
            error.ResetNeeded: no episode has begun.
        """
        if self._session is None:
            raise error.ResetNeeded("no dance has begun: call reset() first")
        return self._session

    def __getstate__(self) -> dict[str, Any]:
        """Everything that a copy is made from; see the class."""
        return {
            "arguments": self._arguments,
            "spec": self.spec,
            "np_random": self._np_random,
            "np_random_seed": self._np_random_seed,
            "episode": None if self._session is None or self._closed else self._session.config,
            "actions": list(self._actions),
            "closed": self._closed,
        }

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Make an equal environment by dancing the episode again."""
        self.__init__(**state["arguments"])  # type: ignore[misc]
        self.spec = state["spec"]
        self._np_random = state["np_random"]
        self._np_random_seed = state["np_random_seed"]
        if state["episode"] is not None:
            self._begin(state["episode"])
            for action in state["actions"]:
                self._advance(action)
        if state["closed"]:
            self.close()

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Begin an episode.

        Args:
            seed: the session's seed, as in ``python -m sjasim.run --seed``. Without one it is drawn from ``np_random``,
                so that every episode has other people.
            options: ``humans`` (a preset), ``people`` (seed of the people: the same people in a new performance),
                ``faults`` (a list of tables), ``method``; each for this episode only.

        Returns:
            the first observation, and an info with ``t_s`` and ``seed``.
        """
        if self._closed:
            raise error.ClosedEnvironmentError("reset() of an environment that has been closed")
        if seed is None and self._np_random is None:
            seed = self._first_seed
        super().reset(seed=seed)

        config = self._episode_config(seed, options or {})
        self._drop_pictures()
        now = self._begin(config)
        if self.render_mode == "human":
            self.render()
        return self._observed(now), {"t_s": now, "seed": config.seed}

    def _begin(self, config: SessionConfig) -> float:
        """Begin the episode of a configuration; returns the session time."""
        try:
            session = Session(config, Agent() if config.method == AGENT else None)
        except SjasimError as problem:
            raise error.Error(str(problem)) from problem

        self._session = session
        self._actions = []
        self._steps = 0
        self._over = False
        if self._skip_rehearsal:
            self._steps = math.ceil(session.timetable.close_s(0) * self._step_hz)
            session.advance(self._steps / self._step_hz)
        self._scorer = Scorer(session, physics_of(session).physics, self._weights)
        self._observer.reset(session)
        return session.time_s

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Send the command that an action stands for, and let the session go on until the next decision.

        Raises:
            error.InvalidAction: the action lies outside the action space.
            error.ResetNeeded: before `reset`, or after the dance is over.
            error.ClosedEnvironmentError: after `close`.
        """
        if self._over:
            if self._closed:
                raise error.ClosedEnvironmentError("step() of an environment that has been closed")
            raise error.ResetNeeded("step() after the dance was over: call reset() first")

        now, figures = self._advance(self._plain_action(action))
        if self.render_mode == "human":
            self.render()
        terms = self._scorer.terms
        return self._observed(now), sum(terms.values()), self._over, False, {"t_s": now, **terms, **figures}

    def _advance(self, action: PlainAction) -> tuple[float, dict[str, object]]:
        """Carry out a plain action; returns the session time and the figures of an iteration that is complete."""
        session = self.session
        self._act(session, action)
        self._actions.append(action)
        self._steps += 1
        session.advance(min(self._steps / self._step_hz, session.end_s))
        now = session.time_s
        figures = self._scorer.update(now)
        self._over = now >= session.end_s - 1e-9
        return now, figures

    def render(self) -> NDArray[np.uint8] | None:
        """A picture of the scene (``rgb_array``), or None after the window was updated (``human``)."""
        if self.render_mode is None:
            gym.logger.warn("render() without a render_mode: gymnasium.make(..., render_mode='rgb_array')")
            return None

        physics = physics_of(self.session).physics
        try:
            if self._pictures is None:
                human = self.render_mode == "human"
                self._pictures = ViewerWindow(physics) if human else Renderer(physics, *self._size, fine=False)
        except SjasimError as problem:
            raise error.DependencyNotInstalled(str(problem)) from problem
        return self._pictures.render()

    def close(self) -> None:
        """Release windows and graphics memory; a second call has no effect."""
        self._drop_pictures()
        self._over = True
        self._closed = True

    def _drop_pictures(self) -> None:
        if self._pictures is not None:
            self._pictures.close()
            self._pictures = None

    def _episode_config(self, seed: int | None, options: Mapping[str, Any]) -> SessionConfig:
        if not isinstance(options, Mapping):
            raise error.Error(f"reset(options={options!r}) is not allowed: a mapping of {', '.join(OPTIONS)}")
        unknown = [name for name in options if name not in OPTIONS]
        if unknown:
            raise error.Error(f"reset(options=...): no option {unknown[0]!r}; known are {', '.join(OPTIONS)}")

        # One number is drawn in every episode, so that a given seed does not change the episodes after it.
        drawn = int(self.np_random.integers(2**31))
        changes: dict[str, Any] = {"seed": drawn if seed is None else seed}
        if "people" in options:
            changes = {"seed": options["people"], "performance": f"take {changes['seed']}"}
        changes |= {name: options[name] for name in OPTIONS if name in options and name != "people"}
        return _configured(self.config, changes)

    def _observed(self, now: float) -> Any:
        return self._observer.named_observation(now)

    @abstractmethod
    def _plain_action(self, action: Any) -> PlainAction:
        """Check an action, and convert it to plain numbers; each environment has its own kind."""

    @abstractmethod
    def _act(self, session: Session, action: PlainAction) -> None:
        """Send the command that an action stands for."""


class DanceEnv(_Dance):
    """``sjasim/Dance-v0``: the agent chooses among stop, forward, backward and turn; the observation is a dictionary.

    An action equal to the move that is being carried out changes nothing, so that holding an action lets the robot
    finish it.
    """

    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        self.action_space = spaces.Discrete(len(MOVES))

    def _plain_action(self, action: Any) -> int:
        try:
            index = operator.index(action)
        except TypeError:
            index = -1
        if not 0 <= index < len(MOVES):
            known = ", ".join(f"{index} {move.value}" for index, move in enumerate(MOVES))
            raise error.InvalidAction(f"action = {action!r} is not allowed: one of {known}")
        return index

    def _act(self, session: Session, action: Any) -> None:
        move = MOVES[action]
        current = session.dispatcher.current
        if move is not (Move.STOP if current is None else current.move):
            session.dispatcher.command_move(session.time_s, move)


class DanceFlatEnv(DanceEnv):
    """``sjasim/DanceFlat-v0``: `DanceEnv` with one row as observation, as `FlattenObservation` gives it."""

    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        self.observation_space = self._observer.flat_space

    def _observed(self, now: float) -> Any:
        return self._observer.flat_observation(now)


class DanceContinuousEnv(_Dance):
    """``sjasim/DanceContinuous-v0``: the agent chooses speed and yaw rate within the limits of the base.

    The base ramps towards them after its command latency, as it does under a velocity topic. The observation is that of
    `DanceEnv`.
    """

    names: ClassVar[tuple[str, str]] = ("v", "omega")

    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        robot = self.config.robot
        self._limits = np.array([robot.max_speed_m_s, robot.max_yaw_rate_rad_s], dtype=np.float32)
        self.action_space = spaces.Box(-self._limits, self._limits, dtype=np.float32)

    def _plain_action(self, action: Any) -> tuple[float, float]:
        try:
            values = np.asarray(action, dtype=np.float32)
        except (TypeError, ValueError):
            values = np.zeros(0, dtype=np.float32)
        if values.shape != (2,):
            raise error.InvalidAction(f"action = {action!r} is not allowed: two numbers, v [m/s] and omega [rad/s]")
        for name, value, limit in zip(self.names, values.tolist(), self._limits.tolist(), strict=True):
            if not -limit <= value <= limit:
                raise error.InvalidAction(f"{name} = {value:g} is not allowed: from {-limit:.4g} to {limit:.4g}")
        speed_m_s, yaw_rate_rad_s = values.tolist()
        return speed_m_s, yaw_rate_rad_s

    def _act(self, session: Session, action: Any) -> None:
        current = session.dispatcher.current
        driven = current is not None and current.move is Move.DRIVE
        before = (current.speed_m_s, current.yaw_rate_rad_s) if driven and current is not None else (0.0, 0.0)
        if action != before:
            session.dispatcher.command_move(session.time_s, Move.DRIVE, *action)


def _check_arguments(
    render_modes: Sequence[str], render_mode: object, step_hz: object, skip_rehearsal: object, config: object
) -> None:
    """Check the arguments that are no fields of `SessionConfig`.

    Raises:
        error.Error: one of them is not allowed.
    """
    if render_mode not in (None, *render_modes):
        raise error.UnsupportedMode(f"render_mode = {render_mode!r} is not allowed: human, rgb_array or None")
    if isinstance(step_hz, bool) or not isinstance(step_hz, int) or not 1 <= step_hz <= 120:
        raise error.Error(f"step_hz = {step_hz!r} is not allowed: a whole number from 1 to 120")
    if not isinstance(skip_rehearsal, bool):
        raise error.Error(f"skip_rehearsal = {skip_rehearsal!r} is not allowed: True or False")
    if not isinstance(config, SessionConfig | None):
        raise error.Error(f"config = {config!r} is not allowed: a SessionConfig; plain fields are options themselves")


def _configured(base: SessionConfig, changes: Mapping[str, Any]) -> SessionConfig:
    """The configuration with some fields replaced.

    Raises:
        error.Error: a field that does not exist or is not allowed.
    """
    try:
        config = from_plain({key: _plain(value) for key, value in changes.items()}, base, warn=True)
    except SjasimError as problem:
        raise error.Error(str(problem)) from problem
    if config.method == HUMANS_ONLY:
        raise error.Error("method = 'none' is not allowed: an environment needs a robot")
    return config


def _plain(value: Any) -> Any:
    """A configuration dataclass as a table, a numpy number as a number."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return dataclasses.asdict(value)
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return value.item() if isinstance(value, np.generic) else value
