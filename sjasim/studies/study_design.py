"""Design of a study: which groups dance under which conditions, in which order, and with which random numbers."""

from __future__ import annotations

import hashlib
import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, is_dataclass, replace
from typing import Annotated

from ..commands.flags import INLINE
from ..config import HUMANS_ONLY, SessionConfig
from ..config.checks import one_of, within
from ..config.toml_file import from_plain
from ..core.errors import ConfigError
from ..core.registry import resolve
from .session_order import ORDERS, condition_order

Level = float | int | bool | str | Sequence["Level"] | Mapping[str, "Level"]
"""Level of a factor: any value that a field of a session's configuration can have in a TOML file."""

MISSING_RULES = ("keep", "drop-step", "drop-group")
"""Rules for steps that a robot missed; see `missing_data`."""

ERROR_RULES = ("stop", "continue")
"""What a study does after a session that failed."""

SEED_SETS = ("evaluation", "tuning")
"""Disjoint sets of seeds; the index of a set is the lowest bit of its seeds."""

PEOPLE_FACTORS = ("humans", "dancers")
"""Factors that change who the people are. Each level has groups of its own."""

ROBOT_TABLES = ("robot", "method_options")
"""Tables of the configuration that do not matter to a session without a robot."""

DESIGN_FIELDS = {"method": "methods", "humans": "humans", "seed": "seed", "performance": "performance"}
"""Field of a session's configuration -> field of the design that gives its value."""

SAME_PERFORMANCE = "study"
"""Name of the performance that the sessions of a group share under ``performance = "same"``."""

SEED_BITS = 53
"""Bits of a seed: every integer of so many bits is exact in R, in JSON and in spreadsheets."""


@dataclass(frozen=True)
class StudyDesign:
    """Design of a study: groups of people, each of which dances a session under every condition.

    Each group first dances without the robot, then with every method. Sessions of a group share their seed, and with it
    the persons.

    Attributes:
        groups: number of groups of people, for each combination of the factors that differ between groups.
        methods: anticipation methods to compare: registered names or module:Class.
        order: order of the conditions: ``counterbalanced`` (groups take the orders of a Williams square in turn),
            ``fixed`` (as listed) or ``random`` (drawn for each group).
        humans: human timing models. Several make a factor; each has groups of its own.
        dances: dances. Several make a factor; every group dances them all.
        replications: number of times that the whole study is repeated with other groups.
        humans_only: begin each group with a session without the robot; ``--no-humans-only`` omits it.
        performance: ``fresh`` (a new performance by the same persons in each session) or ``same`` (one performance of a
            group for all its conditions).
        missing: rule of the analysis for steps that a robot missed: ``keep``, ``drop-step`` (leave out a missed step in
            all sessions of its group) or ``drop-group`` (leave out groups of which a session lacks more than half of
            the robot's steps). The tables hold every step.
        on_error: what happens after a session that failed: ``stop`` or ``continue`` (the analysis leaves out its
            group).
        seed: seed of the study, from which the seeds of all groups follow.
        seeds: ``evaluation`` or ``tuning``. The two sets of seeds have no seed in common: tune a method on the one, and
            report its figures on the other.
        events: keep the table of events; ``--no-events`` omits it, and with it the chance levels.
        between: names of further factors whose levels are given to different groups.
        session: what all sessions have in common.
        factors: name of a field of the session's configuration, such as ``dance.bpm`` or
            ``method_options.window_s`` -> its levels.
    """

    groups: int = 9
    methods: tuple[str, ...] = ("eca", "sia")
    order: str = "counterbalanced"
    humans: tuple[str, ...] = ("paper-entrainment",)
    dances: tuple[str, ...] = ("paper",)
    replications: int = 1
    humans_only: bool = True
    performance: str = "fresh"
    missing: str = "keep"
    on_error: str = "stop"
    seed: int = 0
    seeds: str = "evaluation"
    events: bool = True
    between: tuple[str, ...] = ()
    session: Annotated[SessionConfig, INLINE] = field(default_factory=lambda: SessionConfig(fidelity="timing"))
    factors: Mapping[str, Sequence[Level]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        within("groups", self.groups, 2, 10**7)
        within("replications", self.replications, 1, 10**7)
        within("seed", self.seed, 0, 2**63 - 1)
        one_of("order", self.order, ORDERS)
        one_of("performance", self.performance, ("fresh", "same"))
        one_of("missing", self.missing, MISSING_RULES)
        one_of("on_error", self.on_error, ERROR_RULES)
        one_of("seeds", self.seeds, SEED_SETS)

        for name in ("methods", "humans", "dances"):
            values = getattr(self, name)
            if not values or len(set(values)) < len(values):
                raise ConfigError(name, list(values), "one or more different names")
        if HUMANS_ONLY in self.methods:
            raise ConfigError(
                "methods", list(self.methods), "methods with a robot; see humans_only for sessions without"
            )
        self._check_session()

    def _check_session(self) -> None:
        """Refuse a common configuration with a value that the design gives to every session."""
        default = SessionConfig()
        for name, own in DESIGN_FIELDS.items():
            value = getattr(self.session, name)
            if value != getattr(default, name):
                raise ConfigError(f"session.{name}", value, f"here {own} gives the values of all sessions")
        if self.session.dance.name != default.dance.name:
            raise ConfigError("session.dance.name", self.session.dance.name, "here dances names those of all sessions")

    @property
    def all_factors(self) -> dict[str, tuple[Level, ...]]:
        """Name -> levels of all factors: several ``humans`` and ``dances`` are factors too."""
        factors: dict[str, tuple[Level, ...]] = {}
        if len(self.humans) > 1:
            factors["humans"] = self.humans
        if len(self.dances) > 1:
            factors["dance.name"] = self.dances
        return {**factors, **{name: tuple(levels) for name, levels in self.factors.items()}}

    @property
    def between_groups(self) -> tuple[str, ...]:
        """Names of the factors whose levels are given to different groups."""
        return tuple(name for name in self.all_factors if name in PEOPLE_FACTORS or name in self.between)


@dataclass(frozen=True, slots=True)
class Condition:
    """One condition that a group dances.

    Attributes:
        method: anticipation method, or ``none``.
        levels: levels of the factors that differ within a group and that matter to the method.
    """

    method: str
    levels: Mapping[str, Level]


@dataclass(frozen=True, slots=True)
class SessionSpec:
    """One session of a study.

    Attributes:
        session: its number in the study, from 0.
        study: replication, from 0.
        group: group of people within the study, from 1.
        order: position among the sessions of the group, from 1.
        condition: name of the condition: the method, and the levels of the factors.
        levels: level of each factor that matters to the session.
        config: its configuration.
    """

    session: int
    study: int
    group: int
    order: int
    condition: str
    levels: Mapping[str, Level]
    config: SessionConfig


class StudyPlan:
    """All sessions of a design. A session is made when it is asked for, so that a plan of any size needs no memory.

    Args:
        design: the design.

    Raises:
        SjasimError: a method does not exist, or a factor is no field of the configuration.

    Attributes:
        design: as given.
        cells: combinations of the levels of factors that differ between groups.
        conditions: what each group dances with the robot.
        without_robot: what each group dances before, without the robot.
    """

    def __init__(self, design: StudyDesign) -> None:
        self.design = design
        between = design.between_groups
        levels = design.all_factors
        within_groups = [name for name in levels if name not in between]

        self.cells = _combinations({name: levels[name] for name in between})
        options = {method: method_option_names(method) for method in design.methods}
        reached = {
            method: {name: levels[name] for name in within_groups if reaches(name, method, options.get(method, ()))}
            for method in (HUMANS_ONLY, *design.methods)
        }
        self.without_robot = tuple(
            Condition(HUMANS_ONLY, combination)
            for combination in (_combinations(reached[HUMANS_ONLY]) if design.humans_only else ())
        )
        self.conditions = tuple(
            Condition(method, combination)
            for method in design.methods
            for combination in _combinations(reached[method])
        )
        self._options = options
        self._configs: dict[str, SessionConfig] = {}

    @property
    def sessions_per_group(self) -> int:
        """Number of sessions that each group dances."""
        return len(self.without_robot) + len(self.conditions)

    @property
    def groups(self) -> int:
        """Number of groups in one replication of the study."""
        return self.design.groups * len(self.cells)

    def __len__(self) -> int:
        return self.design.replications * self.groups * self.sessions_per_group

    def session(self, number: int) -> SessionSpec:
        """Return the session with a number from 0 to ``len(plan) - 1``.

        Raises:
            IndexError: there is no such session.
        """
        if not 0 <= number < len(self):
            raise IndexError(f"no session {number} in a study of {len(self)}")
        group_number, position = divmod(number, self.sessions_per_group)
        study, group = divmod(group_number, self.groups)
        seed = group_seed(self.design.seed, self.design.seeds, study, group + 1)

        condition = self._condition(position, group % self.design.groups, seed)
        levels = self._levels(self.cells[group // self.design.groups], condition)
        name = condition_name(condition.method, levels)
        config = self._config(condition.method, levels, name)
        return SessionSpec(number, study, group + 1, position + 1, name, levels, replace(config, seed=seed))

    def sessions(self, first: int = 0, last: int | None = None) -> Iterator[SessionSpec]:
        """Yield the sessions from number ``first`` to ``last``, which is not included; all of them by default."""
        for number in range(first, len(self) if last is None else min(last, len(self))):
            yield self.session(number)

    def named_conditions(self) -> dict[str, Condition]:
        """Name of each condition -> its method and the levels of all factors that matter to it."""
        conditions = [
            Condition(condition.method, self._levels(cell, condition))
            for cell in self.cells
            for condition in (*self.without_robot, *self.conditions)
        ]
        return {condition_name(condition.method, condition.levels): condition for condition in conditions}

    def _levels(self, cell: Mapping[str, Level], condition: Condition) -> dict[str, Level]:
        """Levels of the factors that matter to a session, in the order of the design."""
        found = {**cell, **condition.levels}
        return {name: found[name] for name in self.design.all_factors if name in found}

    def _condition(self, position: int, group: int, seed: int) -> Condition:
        """Return what a group dances at a position from 0; ``group`` counts within its cell, from 0."""
        if position < len(self.without_robot):
            return self.without_robot[position]
        order = condition_order(self.design.order, len(self.conditions), group, seed)
        return self.conditions[order[position - len(self.without_robot)]]

    def _config(self, method: str, levels: Mapping[str, Level], condition: str) -> SessionConfig:
        """Return the configuration of a condition, without the seed of a group."""
        if condition not in self._configs:
            self._configs[condition] = self._made_config(method, levels, condition)
        return self._configs[condition]

    def _made_config(self, method: str, levels: Mapping[str, Level], condition: str) -> SessionConfig:
        design = self.design
        common = design.session
        options = self._options.get(method, ())
        given = {name: value for name, value in common.method_options.items() if name in options}
        base = replace(
            common,
            method=method,
            humans=design.humans[0],
            dance=replace(common.dance, name=design.dances[0]),
            method_options=given,
            performance=self._performance(method, condition),
        )
        return with_levels(base, levels)

    def _performance(self, method: str, condition: str) -> str:
        """Name of the performance: "" already gives each method a performance of its own."""
        if self.design.performance == "same":
            return SAME_PERFORMANCE
        return "" if condition == method else condition


def sessions(design: StudyDesign) -> Iterator[SessionSpec]:
    """Yield all sessions of a design, in the order of their numbers, one at a time.

    Raises:
        SjasimError: a method does not exist, or a factor is no field of the configuration.
    """
    return StudyPlan(design).sessions()


def group_seed(seed: int, seeds: str, study: int, group: int) -> int:
    """Return the seed of a group: 53 bits of a hash, of which the lowest tells evaluation from tuning.

    Args:
        seed: seed of the study.
        seeds: one of `SEED_SETS`.
        study: replication, from 0.
        group: group, from 1.
    """
    digest = hashlib.sha256(f"study/{seed}/{study}/{group}".encode()).digest()
    drawn = int.from_bytes(digest[:8], "big") >> (64 - SEED_BITS)
    return drawn & ~1 | SEED_SETS.index(seeds)


def condition_name(method: str, levels: Mapping[str, Level]) -> str:
    """Return the name of a condition, such as ``sia dance.bpm=100``."""
    return " ".join([method, *(f"{name}={level_text(level)}" for name, level in levels.items())])


def level_text(level: Level) -> str:
    """Return a level as it is written in names and tables."""
    if isinstance(level, Mapping):
        return "{" + ", ".join(f"{name}={level_text(item)}" for name, item in level.items()) + "}"
    if isinstance(level, list | tuple):
        return "[" + ", ".join(level_text(item) for item in level) + "]"
    if isinstance(level, bool):
        return str(level).lower()
    return f"{level:g}" if isinstance(level, float) and level == float(f"{level:g}") else str(level)


def method_option_names(method: str) -> tuple[str, ...]:
    """Names of the options of a method; none for one without options.

    Raises:
        UnknownNameError: the method does not exist.
        PluginError: the method's module cannot be imported.
    """
    config = resolve("anticipation", method).config
    return tuple(item.name for item in fields(config)) if config is not None and is_dataclass(config) else ()


def reaches(factor: str, method: str, options: Sequence[str]) -> bool:
    """Whether a factor matters to the sessions of a method.

    Args:
        factor: dotted name of a field of the session's configuration.
        method: the method, or ``none``.
        options: names of the options of the method.
    """
    table, _, name = factor.partition(".")
    if table in ROBOT_TABLES and method == HUMANS_ONLY:
        return False
    return name in options if table == "method_options" else True


def with_levels(config: SessionConfig, levels: Mapping[str, Level]) -> SessionConfig:
    """Return a configuration with the levels of factors.

    Raises:
        ConfigError: a factor is no field of the configuration, or a level is not allowed.
    """
    for factor, level in levels.items():
        table, _, name = factor.partition(".")
        # Options of a method stand in a mapping, which from_plain would replace as a whole.
        if table == "method_options":
            config = replace(config, method_options={**config.method_options, name: level})  # type: ignore[dict-item]
        else:
            config = from_plain(_nested(factor, level), config)
    return config


def _nested(factor: str, level: Level) -> dict[str, object]:
    """The level under its dotted name, as nested tables."""
    data: object = level
    for name in reversed(factor.split(".")):
        data = {name: data}
    assert isinstance(data, dict)
    return data


def _combinations(factors: Mapping[str, Sequence[Level]]) -> tuple[dict[str, Level], ...]:
    """All combinations of the levels of factors; one empty combination without factors."""
    return tuple(dict(zip(factors, levels, strict=True)) for levels in itertools.product(*factors.values()))
