"""The environments: a dance session whose robot does what the agent says. No simulation happens here."""

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

from sjasim.anticipation.method import HUMANS_ONLY, build_method
from sjasim.anticipation.observation import MOVES
from sjasim.choreography.layout import layout
from sjasim.choreography.timetable import timetable
from sjasim.config import SessionConfig
from sjasim.config.toml_file import from_plain
from sjasim.core import Event, Move
from sjasim.core.errors import SjasimError
from sjasim.core.method_io import MethodAction, MethodContext
from sjasim.humans.body.body_model import body_model
from sjasim.session.session import Session
from sjasim.simulation.cast import people
from sjasim.simulation.physics_world import physics_of
from sjasim.simulation.rendering import Renderer
from sjasim.simulation.viewer_window import ViewerWindow

from .observation import Observer
from .reward import RewardConfig, Scorer

AGENT = "agent"
"""The session's method where the agent alone decides."""

OPTIONS = ("humans", "people", "faults", "method")
"""What ``reset(options=...)`` may hold."""


class Agent:
    """The method of a session that is driven from outside: it hears everything and answers nothing."""

    def reset(self, context: MethodContext, rng: np.random.Generator) -> None:
        """Nothing to prepare."""

    def on_event(self, event: Event) -> Sequence[MethodAction]:
        """No answer."""
        return ()

    def on_iteration_start(self, iteration: int, t_s: float) -> Sequence[MethodAction]:
        """No answer."""
        return ()

    def on_iteration_end(self, iteration: int, t_s: float) -> Sequence[MethodAction]:
        """No answer."""
        return ()

    def on_timer(self, t_s: float) -> Sequence[MethodAction]:
        """No answer."""
        return ()


class _Dance(gym.Env[Any, Any]):
    """What all ids share; see docs/environment.md.

    Args:
        render_mode: ``rgb_array``, ``human`` or None.
        step_hz: decisions per second.
        skip_rehearsal: whether an episode begins when the rehearsal's window closes, the robot having stood still.
        reward: weights, by the names of `reward.RewardConfig`.
        config: what further options change; if None the defaults of `SessionConfig`, but with ``joints`` sensing.
        width: of pictures [px].
        height: of pictures [px].
        options: fields of `SessionConfig`, rooms as nested mappings. ``method`` names an anticipation method that
            answers beside the agent; ``seed`` is the first episode's, unless ``reset`` is given one.

    Raises:
        error.Error: an option that does not exist or is not allowed; the message names it.
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
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise error.UnsupportedMode(f"render_mode = {render_mode!r} is not allowed: human, rgb_array or None")
        if isinstance(step_hz, bool) or not isinstance(step_hz, int) or not 1 <= step_hz <= 120:
            raise error.Error(f"step_hz = {step_hz!r} is not allowed: a whole number from 1 to 120")
        if not isinstance(skip_rehearsal, bool):
            raise error.Error(f"skip_rehearsal = {skip_rehearsal!r} is not allowed: True or False")
        if not isinstance(config, SessionConfig | None):
            raise error.Error(
                f"config = {config!r} is not allowed: a SessionConfig; plain fields are options themselves"
            )
        self.config = _configured(config or SessionConfig(method=AGENT, sensing="joints"), options)
        self._first_seed = self.config.seed if "seed" in options or config is not None else None
        self._weights = RewardConfig.of(reward or {})
        self._skip = skip_rehearsal
        self._hz = step_hz
        self.metadata = {**self.metadata, "render_fps": step_hz}
        self.render_mode = render_mode
        self._size = width, height
        self._pictures: Renderer | ViewerWindow | None = None
        try:
            if render_mode == "human":
                ViewerWindow.check()
            Renderer.check(width, height)
            if self.config.method != AGENT:
                build_method(self.config.method, self.config.method_options)
            people(self.config, timetable(self.config))
            body_model(self.config.body.model)
            steps = timetable(self.config).choreography.steps()
            mounts = layout(self.config).mounts
        except SjasimError as problem:
            raise error.Error(str(problem)) from problem
        self._observer = Observer(self.config, len(steps), tuple(mount.name for mount in mounts))
        self._session: Session | None = None
        self._over = False
        self._closed = False
        self.observation_space = self._observer.space

    @property
    def session(self) -> Session:
        """The dance that is going on, with its log.

        Raises:
            error.ResetNeeded: there is none yet.
        """
        if self._session is None:
            raise error.ResetNeeded("no dance has begun: call reset() first")
        return self._session

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Begin a dance.

        Args:
            seed: the session's seed, as in ``python -m sjasim.run --seed``; without one it is drawn from
                ``np_random``, so that every episode has other people.
            options: ``humans`` (preset), ``people`` (seed of the people: the same ones again in a new performance),
                ``faults`` (list of tables), ``method``; each for this episode only.

        Returns:
            the first observation, and an info with ``t_s`` and ``seed``.
        """
        if self._closed:
            raise error.ClosedEnvironmentError("reset() of an environment that has been closed")
        if seed is None and self._np_random is None:
            seed = self._first_seed
        super().reset(seed=seed)
        config = self._episode(seed, options or {})
        self._drop_pictures()
        try:
            self._session = Session(config, Agent() if config.method == AGENT else None)
        except SjasimError as problem:
            raise error.Error(str(problem)) from problem
        self._steps = 0
        if self._skip:
            self._steps = math.ceil(self._session.timetable.close_s(0) * self._hz)
            self._session.advance(self._steps / self._hz)
        self._over = False
        self._scorer = Scorer(self._session, physics_of(self._session).physics, self._weights)
        self._observer.reset(self._session)
        if self.render_mode == "human":
            self.render()
        return self._observed(self._session.time_s), {"t_s": self._session.time_s, "seed": config.seed}

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Order what the action says, and let the dance go on for one decision's time.

        Raises:
            error.InvalidAction: the action lies outside the action space.
            error.ResetNeeded: before `reset`, or after the dance is over.
            error.ClosedEnvironmentError: after `close`.
        """
        session = self.session
        if self._over:
            if self._closed:
                raise error.ClosedEnvironmentError("step() of an environment that has been closed")
            raise error.ResetNeeded("step() after the dance was over: call reset() first")
        self._act(session, action)
        self._steps += 1
        session.advance(min(self._steps / self._hz, session.end_s))
        now = session.time_s
        done, terms = self._scorer.update(now), self._scorer.terms
        self._over = now >= session.end_s - 1e-9
        if self.render_mode == "human":
            self.render()
        return self._observed(now), sum(terms.values()), self._over, False, {"t_s": now, **terms, **done}

    def render(self) -> NDArray[np.uint8] | None:
        """A picture of the stage (``rgb_array``), or the window brought up to date (``human``)."""
        if self.render_mode is None:
            gym.logger.warn("render() without a render_mode: gymnasium.make(..., render_mode='rgb_array')")
            return None
        physics = physics_of(self.session).physics
        try:
            if self._pictures is None:
                self._pictures = (
                    ViewerWindow(physics) if self.render_mode == "human" else Renderer(physics, *self._size, fine=False)
                )
        except SjasimError as problem:
            raise error.DependencyNotInstalled(str(problem)) from problem
        return self._pictures.frame()

    def close(self) -> None:
        """Let go of windows and pictures; twice does no harm."""
        self._drop_pictures()
        self._over = self._closed = True

    def _drop_pictures(self) -> None:
        if self._pictures is not None:
            self._pictures.close()
            self._pictures = None

    def _episode(self, seed: int | None, options: Mapping[str, Any]) -> SessionConfig:
        if not isinstance(options, Mapping):
            raise error.Error(f"reset(options={options!r}) is not allowed: a mapping of {', '.join(OPTIONS)}")
        unknown = [name for name in options if name not in OPTIONS]
        if unknown:
            raise error.Error(f"reset(options=...): no option {unknown[0]!r}; known are {', '.join(OPTIONS)}")
        drawn = int(self.np_random.integers(2**31))
        changes: dict[str, Any] = {"seed": drawn if seed is None else seed}
        if "people" in options:
            changes = {"seed": options["people"], "performance": f"take {changes['seed']}"}
        changes |= {name: options[name] for name in OPTIONS if name in options and name != "people"}
        return _configured(self.config, changes)

    def _observed(self, now: float) -> Any:
        return self._observer.named(now)

    @abstractmethod
    def _act(self, session: Session, action: Any) -> None:
        """Put an action in force; each environment has its own kind."""


class DanceEnv(_Dance):
    """``sjasim/Dance-v0``: stop, forward, backward or turn; a dictionary of what the server knows.

    An action equal to the move in force changes nothing, so that holding an action lets the robot finish it.
    """

    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        self.action_space = spaces.Discrete(len(MOVES))

    def _act(self, session: Session, action: Any) -> None:
        try:
            index = operator.index(action)
        except TypeError:
            index = -1
        if not 0 <= index < len(MOVES):
            known = ", ".join(f"{index} {move.value}" for index, move in enumerate(MOVES))
            raise error.InvalidAction(f"action = {action!r} is not allowed: one of {known}")
        wanted, current = MOVES[index], session.dispatcher.current
        if wanted is not (Move.STOP if current is None else current.move):
            session.dispatcher.command_move(session.time_s, wanted)


class DanceFlatEnv(DanceEnv):
    """``sjasim/DanceFlat-v0``: the same, its observation one row, as `gymnasium.wrappers.FlattenObservation` has it."""

    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        self.observation_space = self._observer.flat_space

    def _observed(self, now: float) -> Any:
        return self._observer.flat(now)


class DanceContinuousEnv(_Dance):
    """``sjasim/DanceContinuous-v0``: speed and yaw rate, within the base's own limits; the same observation.

    The base ramps towards them after its dead time, as under a velocity topic.
    """

    names: ClassVar[tuple[str, str]] = ("v", "omega")

    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        robot = self.config.robot
        self._limits = np.array([robot.max_speed_m_s, robot.max_yaw_rate_rad_s], dtype=np.float32)
        self.action_space = spaces.Box(-self._limits, self._limits, dtype=np.float32)

    def _act(self, session: Session, action: Any) -> None:
        try:
            wanted = np.asarray(action, dtype=np.float32)
        except (TypeError, ValueError):
            wanted = np.zeros(0, dtype=np.float32)
        if wanted.shape != (2,):
            raise error.InvalidAction(f"action = {action!r} is not allowed: two numbers, v [m/s] and omega [rad/s]")
        for name, value, limit in zip(self.names, wanted.tolist(), self._limits.tolist(), strict=True):
            if not -limit <= value <= limit:
                raise error.InvalidAction(f"{name} = {value:g} is not allowed: from {-limit:.4g} to {limit:.4g}")
        speed, yaw = wanted.tolist()
        current = session.dispatcher.current
        driven = current is not None and current.move is Move.DRIVE
        before = (current.speed_m_s, current.yaw_rate_rad_s) if driven and current is not None else (0.0, 0.0)
        if (speed, yaw) != before:
            session.dispatcher.command_move(session.time_s, Move.DRIVE, speed, yaw)


def _configured(base: SessionConfig, changes: Mapping[str, Any]) -> SessionConfig:
    """The configuration with some fields replaced.

    Raises:
        error.Error: a field that does not exist or is not allowed.
    """
    try:
        config = from_plain({key: _plain(value) for key, value in changes.items()}, base)
    except SjasimError as problem:
        raise error.Error(str(problem)) from problem
    if config.method == HUMANS_ONLY:
        raise error.Error("method = 'none' is not allowed: without a robot there is nothing to act with")
    return config


def _plain(value: Any) -> Any:
    """A room's configuration as a table, a numpy number as a number."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return dataclasses.asdict(value)
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return value.item() if isinstance(value, np.generic) else value
