"""Checks of a design before its study starts. Each error is one line that names the field and what is allowed."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..choreography.layout import layout
from ..choreography.timetable import timetable
from ..config import HUMANS_ONLY, SessionConfig
from ..core.errors import ConfigError
from ..core.registry import resolve
from .session_rows import SessionRows
from .study_design import (
    DESIGN_FIELDS,
    Level,
    SessionSpec,
    StudyDesign,
    StudyPlan,
    method_option_names,
    reaches,
    with_levels,
)


def checked_plan(design: StudyDesign) -> StudyPlan:
    """Return the plan of a design, after every check that needs no simulated session.

    Raises:
        SjasimError: a name is unknown, a method or an option is given twice or reaches nothing, a factor has fewer than
            two different levels, or a session cannot be made from its configuration.
    """
    _check_methods(design)
    _check_factors(design)
    _check_options(design)

    plan = StudyPlan(design)
    for spec in one_session_of_each_condition(plan):
        check_config(spec.config)
    _check_effects(design)
    return plan


def one_session_of_each_condition(plan: StudyPlan) -> list[SessionSpec]:
    """The sessions of the first group of each cell: together they have every condition."""
    firsts = range(0, plan.groups, plan.design.groups)
    size = plan.sessions_per_group
    return [spec for group in firsts for spec in plan.sessions(group * size, (group + 1) * size)]


def check_config(config: SessionConfig) -> None:
    """Make what the plug-ins and files of a configuration name, so that a wrong one is found before the study.

    Raises:
        SjasimError: a name is unknown, or a value is not allowed.
    """
    from ..anticipation.method import build_method
    from ..session.dancers import make_human_timing
    from ..session.preparation import check_fault_targets
    from ..session.session import Session

    if config.fidelity == "timing":
        # Such a session is made within milliseconds, and its world refuses what has no effect in it.
        Session(config)
        return

    resolve("world", config.fidelity)
    resolve("sensing", config.sensing)
    if config.method != HUMANS_ONLY:
        build_method(config.method, config.method_options)

    place = layout(config)
    check_fault_targets(config, [mount.name for mount in place.mounts])
    make_human_timing(config, timetable(config))


def _check_methods(design: StudyDesign) -> None:
    """Refuse two names of one method."""
    entries = {name: resolve("anticipation", name) for name in design.methods}
    for one, other in itertools.combinations(design.methods, 2):
        if entries[one].factory is entries[other].factory:
            raise ConfigError("methods", [one, other], "different methods; both names mean the same one")


def _check_factors(design: StudyDesign) -> None:
    """Refuse factors that the design gives otherwise, that are no fields, or whose levels are not different."""
    taken = [name for name in design.factors if name in ("humans", "dance.name") and name in _from_lists(design)]
    if taken:
        raise ConfigError(f"factors.{taken[0]}", list(design.factors[taken[0]]), "given once: as factor or as option")
    unknown = [name for name in design.between if name not in design.all_factors]
    if unknown:
        raise ConfigError("between", list(design.between), f"names of factors; {unknown[0]} is none")

    for name, levels in design.all_factors.items():
        own = DESIGN_FIELDS.get(name)
        if name in design.factors and own is not None and name != "humans":
            raise ConfigError(f"factors.{name}", list(levels), f"no factor; {own} gives the values of all sessions")
        if len(levels) < 2:
            raise ConfigError(f"factors.{name}", list(levels), "two or more levels; one level changes nothing")
        _check_levels(design, name, levels)


def _from_lists(design: StudyDesign) -> Mapping[str, Sequence[Level]]:
    """The factors that several humans or dances make."""
    return replace(design, factors={}, between=()).all_factors


def _check_levels(design: StudyDesign, name: str, levels: Sequence[Level]) -> None:
    """Refuse levels that are equal once they are values of the configuration."""
    table, _, option = name.partition(".")
    if table == "method_options":
        users = [method for method in design.methods if option in method_option_names(method)]
        if not users:
            raise ConfigError(f"factors.{name}", list(levels), _options_text(design))

    # One level of each pair would repeat the sessions of the other under another name.
    configs = [with_levels(design.session, {name: level}) for level in levels]
    for (one, config), (other, same) in itertools.combinations(zip(levels, configs, strict=True), 2):
        if config == same:
            raise ConfigError(f"factors.{name}", list(levels), f"different levels; {one!r} and {other!r} are equal")


def _check_effects(design: StudyDesign) -> None:
    """Refuse a factor whose levels give equal sessions, where sessions are quick enough to try.

    Three sessions of the event-level world are compared under every level.
    """
    for name, levels in design.all_factors.items():
        users = [method for method in design.methods if reaches(name, method, method_option_names(method))]
        base = StudyPlan(replace(design, factors={}, between=(), humans=design.humans[:1], dances=design.dances[:1]))
        specs = [spec for spec in base.sessions(0, 3 * base.sessions_per_group) if spec.config.method == users[0]]
        if any(with_levels(specs[0].config, {name: level}).fidelity != "timing" for level in levels):
            continue
        if all(_are_equal([with_levels(spec.config, {name: level}) for level in levels]) for spec in specs):
            raise ConfigError(f"factors.{name}", list(levels), "a factor with an effect; its sessions are all equal")


def _are_equal(configs: Sequence[SessionConfig]) -> bool:
    """Whether the sessions of some configurations have equal rows in all tables."""
    from .study_parts import simulated

    first, *others = (_values(simulated(config, 0)) for config in configs)
    return all(
        all(np.array_equal(one, two, equal_nan=one.dtype.kind == "f") for one, two in zip(first, other, strict=True))
        for other in others
    )


def _values(rows: SessionRows) -> list[NDArray[np.generic]]:
    """All values of a session's rows."""
    tables = (rows.iterations, rows.steps, rows.events)
    return [np.array(list(rows.session.values())), *(values for table in tables for values in table.values())]


def _check_options(design: StudyDesign) -> None:
    """Refuse an option that no method has."""
    known = {name for method in design.methods for name in method_option_names(method)}
    for name, value in design.session.method_options.items():
        if name not in known:
            raise ConfigError(f"method_options.{name}", value, _options_text(design))


def _options_text(design: StudyDesign) -> str:
    """What the methods of a design have as options, for messages."""
    texts = [f"{method}: {', '.join(method_option_names(method)) or 'none'}" for method in design.methods]
    return f"an option of one of the methods ({'; '.join(texts)})"
