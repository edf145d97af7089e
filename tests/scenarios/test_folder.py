"""The measures of a simulated session follow from the tables of its folder alone."""

import dataclasses
import json

from sjasim.analysis.session_metrics import measures
from sjasim.config import SessionConfig
from sjasim.record import session_folder
from sjasim.session.session import run_session

from .conftest import run_short_session


def test_every_measure_can_be_recomputed_from_the_tables(tmp_path):
    session = run_short_session(("clock_jump", "north", 10.0, 1.0), method="sia", iterations=2)
    folder = session_folder.write(session.log, tmp_path / "one", session.measures.as_dict(), recording=False)

    written = json.loads((folder / "session.json").read_text())
    recomputed = json.loads(json.dumps(measures(session_folder.read(folder)).as_dict()))
    assert without_cost(recomputed) == without_cost(written)
    assert written["net_latency_s"]
    assert written["notices"]


def test_the_same_seed_gives_the_same_session_json_but_for_cost_and_versions():
    config = SessionConfig(method="sia", seed=5, fidelity="timing", iterations=2)
    first, again, other = (
        measures(run_session(one)).as_dict() for one in (config, config, dataclasses.replace(config, seed=6))
    )
    assert first["cost"] != again["cost"]
    texts = [json.dumps(without_cost(one)) for one in (first, again)]
    assert texts[0] == texts[1]
    assert first["gsi"] != other["gsi"]


def without_cost(summary):
    return {key: value for key, value in summary.items() if key != "cost"}
