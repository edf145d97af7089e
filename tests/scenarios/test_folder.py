"""A danced session's folder says everything: whoever has only its tables finds the figures beside them."""

import json

from sjasim.analysis.session_metrics import measures
from sjasim.record import session_folder

from .conftest import dance

COSTS = ("cpu_s", "wall_s", "sim_s")


def test_every_figure_can_be_recomputed_from_the_tables(tmp_path):
    session = dance(("clock_jump", "north", 10.0, 1.0), method="sia", iterations=2)
    kept = session_folder.write(session.log, tmp_path / "one", session.measures.as_dict(), recording=False)
    told = json.loads((kept / "session.json").read_text())
    again = json.loads(json.dumps(measures(session_folder.read(kept)).as_dict()))
    assert {key: value for key, value in again.items() if key not in COSTS} == {
        key: value for key, value in told.items() if key not in COSTS
    }
    assert told["net_latency_s"]
    assert told["notices"]
