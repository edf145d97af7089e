"""Studies and workers that are killed: nothing is lost, nothing is repeated, and the bytes are the same."""

import json
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from sjasim.studies.dataset import read_study

from .small_study import digests

HERE = Path(__file__).parent
ROOT = HERE.parents[1]

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="needs processes that can be forked and killed")


def environment(**more):
    """Environment in which sjasim and the failing methods can be imported."""
    paths = [str(ROOT), str(ROOT / "envs"), str(HERE), os.environ.get("PYTHONPATH", "")]
    return {**os.environ, "PYTHONPATH": os.pathsep.join(paths), **more}


def study(folder, *arguments, **more):
    """Run the command to its end."""
    command = [sys.executable, "-m", "sjasim.study", "--out", str(folder), *arguments]
    return subprocess.run(command, env=environment(**more), capture_output=True, text=True, check=False, timeout=900)


def killed(folder, kills, seed):
    """Kill a study so many times; see `killed_study`."""
    command = [sys.executable, str(HERE / "killed_study.py"), str(folder), str(kills), str(seed)]
    answer = subprocess.run(command, env=environment(), capture_output=True, text=True, check=True, timeout=1800)
    return json.loads(answer.stdout.splitlines()[-1])


@pytest.mark.slow
def test_fifty_kills_lose_nothing_and_repeat_nothing(tmp_path):
    answer = killed(tmp_path / "study", 50, 1)
    assert answer["kills"] == 50
    assert answer["repeated"] == 0
    folders = [path for path in tmp_path.glob("study*") if (path / "study.json").exists()]
    assert folders
    for folder in folders:
        assert digests(folder) == digests(tmp_path / "whole")
        assert not (folder / "parts").exists()
        assert not list(folder.glob("*.draft"))
    assert len(read_study(folders[-1]).sessions["session"]) == 14 * 3


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Folder of the study `DESIGN`, computed in one process."""
    folder = tmp_path_factory.mktemp("whole") / "study"
    answer = study(folder, *DESIGN, "--jobs", "1")
    assert answer.returncode == 0, answer.stderr
    return folder


DESIGN = ("--groups", "700", "--iterations", "1", "--dance.no-rehearsal", "--no-humans-only", "--methods", "eca", "sia")
"""14 chunks, whose computation takes long enough for several processes."""

KILLER = ("--groups", "120", "--iterations", "1", "--dance.no-rehearsal", "--methods", "failing_methods:KillsItsWorker")
"""Sessions of which the very first kills its worker."""


@pytest.mark.slow
def test_a_command_with_processes_is_killed_and_resumed(whole, tmp_path):
    folder = tmp_path / "study"
    command = [sys.executable, "-m", "sjasim.study", "--out", str(folder), *DESIGN, "--jobs", "2", "--resume"]
    rng = random.Random(3)
    for number in range(5):
        process = subprocess.Popen(command, env=environment(), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        wanted = min(2 * number, 10)
        while process.poll() is None and len(list(folder.glob("parts/*.part"))) < wanted:
            time.sleep(0.05)
        time.sleep(rng.uniform(0.0, 1.0))
        process.send_signal(signal.SIGKILL)
        process.wait()
    answer = study(folder, *DESIGN, "--jobs", "2", "--resume")
    assert answer.returncode == 0, answer.stderr
    assert digests(folder) == digests(whole)


@pytest.mark.slow
@pytest.mark.parametrize("backend", ["local", "dask", "ray"])
def test_a_backend_of_two_workers_gives_the_same_bytes(whole, tmp_path, backend):
    _need(backend)
    answer = study(tmp_path / "study", *DESIGN, "--jobs", "2", "--backend", backend)
    assert answer.returncode == 0, answer.stderr
    assert digests(tmp_path / "study") == digests(whole)


@pytest.mark.slow
@pytest.mark.parametrize("backend", ["local", "dask", "ray"])
def test_a_killed_worker_is_replaced_and_its_chunk_computed_again(tmp_path, backend, monkeypatch):
    _need(backend)
    # The mark exists already in the run to compare with, so that no worker is killed.
    (tmp_path / "exists").touch()
    plain = study(tmp_path / "plain", *KILLER, "--jobs", "1", SJASIM_TEST_MARK=str(tmp_path / "exists"))
    assert plain.returncode == 0, plain.stderr

    mark = tmp_path / "mark"
    answer = study(
        tmp_path / "study", *KILLER, "--jobs", "2", "--backend", backend,
        SJASIM_TEST_MARK=str(mark),
    )  # fmt: skip
    assert answer.returncode == 0, answer.stderr
    assert mark.exists()
    assert digests(tmp_path / "study") == digests(tmp_path / "plain")


@pytest.mark.slow
def test_a_study_runs_on_a_dask_cluster_that_runs_already(whole, tmp_path):
    distributed = pytest.importorskip("distributed", reason="dask is not installed")
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        address = cluster.scheduler_address.removeprefix("tcp://")
        answer = study(tmp_path / "study", *DESIGN, "--backend", f"dask://{address}")
    assert answer.returncode == 0, answer.stderr
    assert digests(tmp_path / "study") == digests(whole)


@pytest.mark.parametrize("address", ["127.0.0.1:9"])
def test_a_cluster_that_does_not_answer_is_named(tmp_path, address, monkeypatch):
    pytest.importorskip("distributed", reason="dask is not installed")
    from sjasim.core.errors import SjasimError
    from sjasim.studies.backends import dask_workers

    monkeypatch.setattr(dask_workers, "CONNECT_S", 0.5)
    with pytest.raises(SjasimError, match=f"no dask cluster at dask://{address}"):
        next(dask_workers.results("", [0], 1, address))


def _need(backend):
    package = {"local": "joblib", "dask": "distributed", "ray": "ray"}[backend]
    pytest.importorskip(package, reason=f"{package} is not installed")
