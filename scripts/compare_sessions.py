#!/usr/bin/env python3
"""Compare two versions of the code: dance the same configurations with each, then compare all of their tables.

python scripts/compare_sessions.py dance --python old/.venv/bin/python --out sessions_old
python scripts/compare_sessions.py dance --python new/.venv/bin/python --out sessions_new
python scripts/compare_sessions.py compare sessions_old sessions_new
"""

from __future__ import annotations

import hashlib
import json
import os
import subprocess
import sys
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Mapping
from itertools import count, zip_longest
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import tyro

Table = Mapping[str, list[Any]]
"""Column name -> values."""

SESSIONS = {
    "sia": 'method = "sia"; iterations = 3',
    "eca_tau": 'method = "eca"; iterations = 2; synchrony.tau_s = 0.4',
    "metronome_one_to_one": 'method = "metronome"; iterations = 2; synchrony.one_to_one = true',
    "none": 'method = "none"; iterations = 2; performance = "second"',
    "learned": 'method = "learned"; iterations = 1; method_options.policy = "policy.npz"',
    "depth": 'method = "sia"; iterations = 2; sensing = "depth"',
    "march_of_five": 'method = "sia"; iterations = 2; group = 5; dance.name = "march"',
    "waltz": 'method = "sia"; iterations = 2; dance.name = "waltz"',
    "tempo_and_pauses": 'method = "eca"; iterations = 2; dance.tempo = [[0, 1], [40, 1.1], [100, 0.9]]; '
    "dance.pauses = [[60, 1.5], [92, 0.7]]",
    "faults": 'method = "sia"; iterations = 3; network.loss = 0.03; faults = ['
    '{kind = "dancer_late", target = "dancer_2", t_s = 25, value = 1}, '
    '{kind = "clock_jump", target = "north", t_s = 30, value = 0.3}, '
    '{kind = "dead_sensor", target = "east", t_s = 40}, {kind = "robot_blocked", target = "robot", t_s = 60}]',
    "no_tether": 'method = "eca"; iterations = 1; body.tether = "none"',
    "cmu": 'method = "sia"; iterations = 1; body.model = "cmu"',
    "replay": 'method = "eca"; iterations = 3; humans = "replay:sia"',
    "rows_and_options": 'method = "sia"; iterations = 1; layout = "rows"; method_options.effective_from = 1; '
    "room = {side_m = 1.5, turn_rad = 0.5, sensor_distance_m = 3.5, sensor_height_m = 1, move_m = 0.45}; "
    "stage = {rate_hz = 300, balance_hz = 75, truth_hz = 25}; clocks = {offset_s = 0.3, drift = 3e-5}; "
    "robot = {track_m = 0.24, track_error = 0.01, command_timeout_s = 0.7, dead_time_s = 0.12}; "
    "network = {loss = 0.002, uplink_extra_s = 0.005}; sensors = {idle_hz = 3, bias_m = 0.012, drift_m = 0.004, "
    "drift_correlation = 0.99, limb_drift_m = 0.01, limb_drift_correlation = 0.9, hidden_factor = 2, "
    "hidden_factor_hand = 2.3}; detectors = {on_m_s = 0.22, off_m_s = 0.11, early_step_m = 0.006, "
    "early_rest_s = 0.4, clap_rest_s = 0.9, assist_s = 1.8}",
}
"""Name -> lines of its TOML file. The keys are those of version 0.1, which the next version accepts as well."""

ENVIRONMENTS = ("Dance-v0", "DanceContinuous-v0")
STEPS, HELD_STEPS, SEED = 300, 10, 7
"""Steps of a rollout, steps for which each random action is held, and the seed of people, actions and policy."""

FEATURES, MOVES_BY_BEAT = 72, (0, 1, 0, 2, 0, 1, 0, 2, 0, 3, 0)
"""The learned method's input with three dancers, and the moves its policy wants before beat 0 and from each 4th on."""

NOT_COMPARED = {"config", "versions", "cost", "sim_s", "cpu_s", "wall_s"}
"""Keys of session.json that may differ: renamed options, packages, and the cost of the run in either schema."""

IDENTITY = ("iteration", "agent", "person", "dancer", "ordinal", "early", "kind", "move")
"""Columns that say which event a row is about, those of them that a table has; kinds come last."""


def dance(out: Path, python: Path = Path(sys.executable), path: str = "", only: tuple[str, ...] = ()) -> int:
    """Dance the configurations, and write a session's folder and a file of digests for each; 1 if any failed.

    Args:
        out: folder for all of them; a session that it holds already is replaced.
        python: interpreter to dance with.
        path: its PYTHONPATH, if the package is not installed there.
        only: names of configurations; all of them if empty.
    """
    out.mkdir(parents=True, exist_ok=True)
    write_policy(out / "policy.npz")
    places = os.pathsep.join(str(Path(place).absolute()) for place in path.split(os.pathsep) if place)
    environment = {**os.environ, "PYTHONPATH": places}
    failed = 0

    for name in only or (*SESSIONS, *ENVIRONMENTS):
        task = [str(Path(__file__).resolve()), "rollout", name]
        if name in SESSIONS:
            toml = ("" if "sensing" in SESSIONS[name] else 'sensing = "joints"; ') + SESSIONS[name]
            (out / f"{name}.toml").write_text("seed = 13001\n" + toml.replace("; ", "\n") + "\n", encoding="utf-8")
            task = ["-m", "sjasim.run", "--config", f"{name}.toml", "--out", name, "--overwrite", "--json"]

        # It runs in the output folder: a package in the current folder would precede the one that is to be tested.
        command = [str(python.absolute()), *task]
        ended = subprocess.run(command, cwd=out, env=environment, capture_output=True, text=True, check=False)
        failed += ended.returncode != 0

        tables = read_tables(out / name) if ended.returncode == 0 else {}
        write_digests(out / f"{name}.json", tables)
        print(f"{name}: {len(tables)} tables" if tables else f"{name}: failed: {ended.stderr[-500:]}", flush=True)
    return int(failed > 0)


def write_policy(path: Path) -> None:
    """Write a policy that dances the score by the beat, moved a little by what it is told of the dancers."""
    wanted = np.eye(4)[list(MOVES_BY_BEAT)]
    weights = np.random.default_rng(SEED).normal(scale=0.1, size=(len(wanted) - 1, FEATURES))
    weights[:, 0] += 400.0  # the first feature is the beat over 40
    layers = {"w0": weights, "b0": -40.0 * np.arange(len(weights)), "w1": np.diff(wanted, axis=0).T / 2}
    layers["b1"] = (wanted[0] + wanted[-1]) / 2
    np.savez(path, mean=np.zeros(FEATURES), std=np.ones(FEATURES), clip=5.0, step_hz=6, **layers)


def rollout(name: tyro.conf.Positional[str]) -> None:
    """Act at random in an environment, and write its observations and rewards into a folder; `dance` calls this."""
    import gymnasium as gym

    env = gym.make(f"sjasim:sjasim/{name}", iterations=2, skip_rehearsal=True)
    env.action_space.seed(SEED)
    env.reset(seed=SEED)
    rows: list[dict[str, Any]] = []

    for _ in range(STEPS // HELD_STEPS):
        action = env.action_space.sample()
        for _ in range(HELD_STEPS):
            observation, reward, *_ = env.step(action)
            rows.append(dict(flat({"reward": float(reward), "observation": observation})))

    Path(name).mkdir(exist_ok=True)
    pq.write_table(pa.Table.from_pylist(rows), Path(name) / "steps.parquet")


def flat(value: Any, key: str = "") -> Iterator[tuple[str, Any]]:
    """Dotted keys and values of all that nested mappings, lists and arrays hold."""
    value = value.tolist() if isinstance(value, np.ndarray) else value
    if isinstance(value, Mapping | list) and value:
        for name, inner in value.items() if isinstance(value, Mapping) else enumerate(value):
            yield from flat(inner, f"{key}.{name}" if key else str(name))
    else:
        yield key, value


def read_tables(folder: Path) -> dict[str, Table]:
    """The tables of a session's folder, and session.json as a table of one row."""
    tables: dict[str, Table] = {path.stem: pq.read_table(path).to_pydict() for path in sorted(folder.glob("*.parquet"))}
    if (folder / "session.json").exists():
        summary = json.loads((folder / "session.json").read_text(encoding="utf-8"))
        tables["session.json"] = {key: [value] for key, value in flat(summary) if key.split(".")[0] not in NOT_COMPARED}
    return tables


def write_digests(file: Path, tables: Mapping[str, Table]) -> None:
    """Write a hash of every column of every table; it tells 1 from 1.0, and -0.0 from 0.0."""
    digests: dict[str, dict[str, str]] = {table: {} for table in tables}
    for table, columns in tables.items():
        for key, values in columns.items():
            digests[table][key] = hashlib.sha256(repr(values).encode()).hexdigest()[:16]
    file.write_text(json.dumps(digests, indent=1) + "\n", encoding="utf-8")


def compare(first: tyro.conf.Positional[Path], second: tyro.conf.Positional[Path]) -> int:
    """Print for each table of two folders that `dance` wrote whether it is equal, or how it differs; 1 if any does."""
    names = sorted({path.stem for folder in (first, second) for path in folder.glob("*.json")})
    lines = [line for name in names for line in compare_session(first, second, name)]
    different = sum(not equal for _, equal in lines)
    summary = f"{len(names)} configurations, {len(lines)} tables, {different} of them different"
    print(*(line for line, _ in lines), summary, sep="\n")
    return int(different > 0 or not lines)


def compare_session(first: Path, second: Path, name: str) -> Iterator[tuple[str, bool]]:
    """A line for each table of a configuration, and whether the table is equal in both folders."""
    files = [folder / f"{name}.json" for folder in (first, second)]
    old, new = (json.loads(file.read_text(encoding="utf-8")) if file.exists() else {} for file in files)
    if not old and not new:
        yield f"{name}: no tables in either folder", False

    for table in sorted({*old, *new}):
        if table not in old or table not in new:
            yield f"{name}/{table}: only in {first if table in old else second}", False
            continue

        names = match_columns(old[table], new[table])
        alone = sorted({*old[table]} - {*names.values()}) + sorted({*new[table]} - {*names})
        changed = any(new[table][key] != old[table][own] for key, own in names.items())

        words = ["DIFFERENT" if alone or changed else "equal"]
        if changed:
            before, after = (read_tables(folder / name)[table] for folder in (first, second))
            words += describe(before, {own: after[key] for key, own in names.items()})
        words += [f"only in one: {', '.join(alone)}"] if alone else []
        words += [f"renamed: {own} to {key}" for key, own in names.items() if key != own]
        yield f"{name}/{table}: {'; '.join(words)}", not (alone or changed)


def match_columns(old: Mapping[str, str], new: Mapping[str, str]) -> dict[str, str]:
    """New column -> old column: of the same name, else of the same digest, else in order if as many are left."""
    names = {key: key for key in new if key in old}
    for key in [key for key in new if key not in old]:
        equal = [own for own in old if own not in names.values() and old[own] == new[key]]
        names.update((key, own) for own in equal[:1])
    left = [key for key in new if key not in names], [own for own in old if own not in names.values()]
    return names | dict(zip(*left, strict=True)) if len(left[0]) == len(left[1]) else names


def describe(old: Table, new: Table) -> Iterator[str]:
    """The first difference of two tables that differ in columns of the same names, then how far their events agree."""
    shared = [key for key in old if key in new]
    places = []
    for key in shared:
        pairs = enumerate(zip_longest(old[key], new[key], fillvalue="no row"))
        places += [(row, key, pair) for row, pair in pairs if repr(pair[0]) != repr(pair[1])][:1]
    row, first, (one, other) = min(places, key=lambda place: place[0])
    yield f"first at row {row}, column {first}: {one} and {other}"
    yield f"columns {', '.join(key for _, key, _ in places)}"

    times = [key for key in shared if key.startswith(("t_", "duration_s"))]
    identity = [key for key in IDENTITY if key in shared]
    if not times and not identity:
        return
    events = [
        [tuple(table[key][row] for key in identity) for row in range(len(table[shared[0]]))] for table in (old, new)
    ]
    kinds = [{event[-1:] for event in own} for own in events]
    for what, (before, after) in {"kinds": kinds, "order": events, "counts": map(Counter, events)}.items():
        yield f"{what} {'equal' if before == after else 'DIFFERENT'}"

    gaps = [0.0]
    for key in times:
        then, now = (number_times(own, table[key]) for own, table in zip(events, (old, new), strict=True))
        gaps += [abs(then[event] - now[event]) for event in then if event in now and then[event] != now[event]]
    yield f"largest time difference {max(gaps):.6g} s"


def number_times(events: Iterable[Any], times_s: Iterable[float]) -> dict[Any, float]:
    """The time of the n-th event of each identity, so that an event more or less does not shift all others."""
    numbers: defaultdict[Any, Iterator[int]] = defaultdict(count)
    return {(event, next(numbers[event])): t_s for event, t_s in zip(events, times_s, strict=True)}


if __name__ == "__main__":
    sys.exit(tyro.extras.subcommand_cli_from_dict({"dance": dance, "compare": compare, "rollout": rollout}))
