"""Number of groups that a study needs to find a difference between two methods, by simulation."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ..analysis.comparisons import TEST
from ..analysis.json_data import without_nan
from ..analysis.paired_intervals import mean_interval, standardised_difference
from ..analysis.power_curve import groups_needed, power_curve, smallest_size
from ..analysis.study_tables import StudyTables
from ..analysis.study_values import MEASURES, condition_names, group_values
from ..assets.published_study import GSI, TA_MEAN_S
from ..commands.tables import print_table
from ..config import SessionConfig
from ..config.checks import one_of, within
from ..config.toml_file import read_toml, to_plain
from ..core import Array
from ..core.errors import ConfigError, RecordError
from ..record.atomic_folder import check_file, check_target
from .dataset import read_study
from .study_design import StudyDesign
from .study_execution import run_study
from .study_folder import write_whole

SCHEMA = 1
FILE = "power.json"

PUBLISHED_METHODS = ("eca", "sia")
"""Methods of the published study: the published effect is the second one's value minus the first one's."""

SHOWN = (6, 7, 8, 9, 10, 12, 14, 16, 18, 20, 25, 30, 35, 40, 50, 60, 80, 100)
"""Numbers of groups that the printed table shows, besides the needed and the largest one."""


@dataclass(frozen=True)
class PowerDesign:
    """What is compared, and how well it should be found.

    Attributes:
        methods: the two methods: registered names or module:Class. With --study, names of two of its conditions.
        measure: what is compared: gsi, gsi_full_edges, gsi_humans or ta_mean_s.
        effect: mean difference to find, second method minus first: ``simulated`` (what the simulated people show),
            ``paper`` (what the paper reports for ECA and SIA) or a number. The spread of the groups is always the
            simulated one.
        target: power to reach.
        alpha: level of the test.
        max_groups: largest number of groups to evaluate.
        pool: number of simulated groups from which the studies are drawn; more of them make the intervals narrower.
        humans: human timing model.
        fidelity: timing, or physics, which takes minutes for each group.
        seed: seed of people and of drawn studies.
    """

    methods: tuple[str, str] = PUBLISHED_METHODS
    measure: str = "gsi"
    effect: str = "simulated"
    target: float = 0.8
    alpha: float = 0.05
    max_groups: int = 40
    pool: int = 1000
    humans: str = "paper-entrainment"
    fidelity: str = "timing"
    seed: int = 0

    def __post_init__(self) -> None:
        one_of("measure", self.measure, tuple(MEASURES))
        within("target", self.target, 0.01, 0.999)
        within("alpha", self.alpha, 1e-6, 0.5)
        within("max_groups", self.max_groups, smallest_size(self.alpha), 10_000)
        within("pool", self.pool, self.max_groups, 10_000_000)
        if len(set(self.methods)) != 2:
            raise ConfigError("methods", list(self.methods), "two different methods")
        self.given_effect()

    def given_effect(self) -> float | None:
        """Return the mean difference to find; None for the simulated one.

        Raises:
            ConfigError: the effect is no number and no known word, is 0, or the paper does not report it.
        """
        if self.effect == "simulated":
            return None
        if self.effect == "paper":
            return self._published_effect()
        try:
            number = float(self.effect)
        except ValueError:
            number = float("nan")
        if not np.isfinite(number) or number == 0.0:
            raise ConfigError("effect", self.effect, "simulated, paper, or a number other than 0")
        return number

    def _published_effect(self) -> float:
        # Full edges are not published: the paper gives the index under its own edges.
        published = {
            "gsi": {method: float(np.mean(cells)) for method, cells in GSI.items()},
            "ta_mean_s": dict(TA_MEAN_S),
        }
        if self.measure not in published or set(self.methods) != set(PUBLISHED_METHODS):
            raise ConfigError("effect", self.effect, "for methods eca and sia, and gsi or ta_mean_s; or a number")
        means = published[self.measure]
        return means[self.methods[1]] - means[self.methods[0]]


def simulate_pool(design: PowerDesign, common: SessionConfig, jobs: int = 0) -> StudyTables:
    """Simulate the groups of a pool, each of which dances with both methods in counterbalanced order.

    Args:
        design: methods, people, fidelity and number of groups.
        common: what all sessions have in common besides.
        jobs: number of processes; 0 for one per core.
    """
    # Neither sessions without a robot nor events are needed, and the study is not kept on disk.
    study = StudyDesign(
        groups=design.pool,
        methods=design.methods,
        humans=(design.humans,),
        humans_only=False,
        events=False,
        seed=design.seed,
        session=replace(common, fidelity=design.fidelity),
    )
    return run_study(study, jobs=jobs)


def power(design: PowerDesign, study: Path | None = None, config: Path | None = None, jobs: int = 0) -> dict[str, Any]:
    """Compute the power for every number of groups, and return the content of power.json.

    Args:
        design: what is compared.
        study: folder of a study whose groups are the pool; None to simulate it.
        config: TOML file with the common configuration of the sessions.
        jobs: number of processes; 0 for one per core.

    Raises:
        SjasimError: a value is not allowed, a name is unknown, the folder or file cannot be read, or the pool has fewer
            groups than the largest study.
    """
    from ..session.session import package_versions

    common = SessionConfig() if config is None else read_toml(config)
    tables = simulate_pool(design, common, jobs) if study is None else read_study(study, events=False)
    differences = pool_differences(tables, design)
    rng = np.random.default_rng(design.seed)
    sizes = range(smallest_size(design.alpha), design.max_groups + 1)
    curve = power_curve(differences, sizes, rng, effect=design.given_effect(), alpha=design.alpha)
    needed = groups_needed(curve, design.target)

    content = {
        "schema": SCHEMA,
        "design": without_nan(asdict(design)),
        "study": None if study is None else str(study),
        "test": TEST,
        "effect": _effect(differences, design, rng),
        "pool": len(differences),
        "rows": [
            {"groups": point.groups, "power": point.power, "low": point.low, "high": point.high} for point in curve
        ],
        "groups_needed": needed.value,
        "groups_needed_low": needed.low,
        "groups_needed_high": needed.high,
        "versions": dict(package_versions()),
        "config": to_plain(replace(common, fidelity=design.fidelity)) if study is None else None,
    }
    plain = without_nan(content)
    assert isinstance(plain, dict)
    return plain


def pool_differences(tables: StudyTables, design: PowerDesign) -> Array:
    """Return the (N,) differences of the groups, second method minus first; groups without both are left out.

    Raises:
        ConfigError: the study has no session of a method.
    """
    condition_names(tables, design.methods)
    pairs = group_values(tables, design.measure, design.methods).pairs(*design.methods)
    return np.asarray(pairs[:, 1] - pairs[:, 0])


def print_power(report: Mapping[str, Any]) -> None:
    """Print the power table and the number of groups that are needed."""
    design = report["design"]
    needed = report["groups_needed"]
    first, second = design["methods"]
    effect = report["effect"]
    difference = f"{design['measure']}: {second} minus {first} is {effect['difference']:+.3f} ({effect['source']})"
    print(f"{difference}, with a standard deviation of {effect['sd']:.3f} between groups")

    # The report has every number of groups; a terminal has room for some.
    shown = [row for row in report["rows"] if row["groups"] in (*SHOWN, needed, design["max_groups"])]
    cells = ((f"{row['groups']}", f"{row['power']:.3f}", f"{row['low']:.3f} to {row['high']:.3f}") for row in shown)
    print_table(("groups", "power", "95 % interval"), cells)

    low = report["groups_needed_low"]
    high = report["groups_needed_high"]
    above = f"more than {design['max_groups']}"
    interval = f"{low or above} to {high or above}"
    print(f"groups needed for a power of {design['target']:g}: {needed or above} (95 % interval {interval})")


def as_json(report: Mapping[str, Any]) -> str:
    """The report as JSON text."""
    return json.dumps(report, indent=1, allow_nan=False) + "\n"


def check_folder(folder: Path, overwrite: bool) -> None:
    """Check that power.json can be written to a folder: a new one, or an existing one such as that of a study.

    Raises:
        RecordError: the folder cannot be written, or holds a power.json that may not be replaced.
    """
    if folder.expanduser().is_dir():
        check_file(folder.expanduser() / FILE, overwrite)
    else:
        check_target(folder, overwrite, holds=FILE)


def save_power(report: Mapping[str, Any], folder: Path) -> None:
    """Write power.json to a folder, whole or not at all. Beside a study, the study's report shows it.

    Raises:
        RecordError: the folder cannot be written.
    """
    target = folder.expanduser()
    try:
        target.mkdir(parents=True, exist_ok=True)
        write_whole(target / FILE, as_json(report).encode())
    except OSError as error:
        raise RecordError(f"{target / FILE} cannot be written: {error.strerror or error}") from None


def _effect(differences: Array, design: PowerDesign, rng: np.random.Generator) -> dict[str, object]:
    """Effect to find, spread of the groups, and the simulated effect with its interval."""
    # The spread is always that of the simulated groups, also for an effect that is given.
    given = design.given_effect()
    simulated = mean_interval(differences, rng)
    sd = float(np.std(differences, ddof=1))
    difference = simulated.value if given is None else given
    return {
        "source": design.effect if design.effect in ("simulated", "paper") else "given",
        "difference": difference,
        "sd": sd,
        "d_z": difference / sd,
        "simulated": {"difference": simulated.as_dict(), "d_z": standardised_difference(differences).as_dict()},
    }
