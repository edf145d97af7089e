"""The paper's equations: hand-made examples, a second route, and invariances."""

import math

import networkx as nx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from sjasim.anticipation.synchrony import (
    connectivity,
    group_index,
    individual_index,
    most_synchronous,
    pair_index,
    pair_synchrony,
)
from sjasim.core import Kind
from sjasim.core.errors import ConfigError, SjasimError

SF, TF, SB, TB, CLAP, TURN = Kind
FULL = ([0.0, 2.0, 4.0, 6.0, 8.0, 10.0, 12.0, 14.0, 16.0], [SF, TF, SB, TB, SF, TF, SB, TB, CLAP])
TAU_US = 250_000


def shifted(series, by):
    return ([time + by for time in series[0]], list(series[1]))


@pytest.mark.parametrize(
    ("a", "b", "expected"),
    [
        ([1.0], [1.1], 1.0),
        ([1.0], [1.0], 1.0),  # a tie: half in each direction
        ([1.0], [1.25], 0.0),  # the window is open
        ([1.0], [1.249999], 1.0),
        ([0.3], [0.05], 0.0),  # .25 apart although floats say a little less
        ([1.0, 5.0], [1.1], 1 / math.sqrt(2)),
        ([1.0, 5.0], [1.1, 7.0], 0.5),
        ([1.0], [0.9, 1.1], math.sqrt(2)),  # a burst: the printed equation exceeds 1
        ([], [1.0], 0.0),
        ([], [], 0.0),
    ],
)
def test_one_kind_by_hand(a, b, expected):
    assert pair_index(a, [SF] * len(a), b, [SF] * len(b)) == pytest.approx(expected, abs=1e-15)


def test_kinds_are_weighted_by_their_events():
    # forward: Q = 1/sqrt(2), weight 3; clap: Q = 1, weight 2
    found = pair_synchrony(([1.0, 9.0, 16.0], [SF, SF, CLAP]), ([1.1, 16.1], [SF, CLAP]))
    assert found.by_kind == pytest.approx({"start_forward": 1 / math.sqrt(2), "clap": 1.0})
    assert found.index == pytest.approx((3 / math.sqrt(2) + 2) / 5)


def test_a_missing_kind_is_a_failure_that_keeps_its_weight():
    found = pair_synchrony(([1.0, 3.0], [SF, TF]), ([1.0], [SF]))
    assert found.by_kind["stop_forward"] == 0.0
    assert found.index == pytest.approx(2 / 3)
    assert not found.empty


def test_nothing_to_compare_is_flagged():
    assert pair_synchrony(([], []), ([], [])).empty


def test_a_turn_counts_as_a_clap_and_order_of_events_is_free():
    assert pair_index([16.1, 1.0], [TURN, SF], [1.0, 16.0], [SF, CLAP]) == 1.0


def test_different_kinds_never_meet():
    assert pair_index([1.0], [SF], [1.0], [SB]) == 0.0


def test_one_to_one_is_bounded_and_optimal():
    assert pair_index([1.0], [SF], [0.9, 1.1], [SF, SF], one_to_one=True) == pytest.approx(1 / math.sqrt(2))
    # greedy by nearest would take (0.2, 0.21) and leave both others alone
    assert pair_index([0.0, 0.21], [SF, SF], [0.2, 0.44], [SF, SF], one_to_one=True) == 1.0


@pytest.mark.parametrize(
    "call",
    [
        lambda: pair_index([1.0], [SF], [1.0], [SF], tau=0.0),
        lambda: pair_index([math.nan], [SF], [1.0], [SF]),
        lambda: pair_index([1.0, 2.0], [SF], [1.0], [SF]),
        lambda: group_index({"dancer_1": FULL}, "some"),
        lambda: group_index({"dancer_1": FULL, "robot": FULL}, follows=("dancer_9",)),
    ],
)
def test_bad_input_is_named(call):
    with pytest.raises(SjasimError) as error:
        call()
    assert isinstance(error.value, ConfigError)


def test_equals_the_tree_route_on_a_thousand_cases():
    rng = np.random.default_rng(7)
    for _ in range(1000):
        kinds = rng.integers(1, 6)
        span = rng.choice([1.0, 4.0, 20.0])  # 1 s: dense trains
        grid_us = rng.choice([1, 1000, 50_000])  # 50 ms: ties and lags of exactly tau
        (ta, ka), (tb, kb) = (_train(rng, kinds, span, grid_us) for _ in range(2))
        expected = _tree_route(ta, ka, tb, kb)
        names = [str(kind) for kind in Kind]
        found = pair_index(ta / 1e6, [names[k] for k in ka], tb / 1e6, [names[k] for k in kb])
        assert found == pytest.approx(expected, abs=1e-12)


def _train(rng, kinds, span, grid_us):
    size = rng.integers(0, 25)
    times = rng.integers(0, int(span * 1e6 / grid_us) + 1, size) * int(grid_us)
    return times.astype(float), rng.integers(0, kinds, size)


def _tree_route(ta, ka, tb, kb):
    total = weights = 0.0
    for kind in set(ka) | set(kb):
        x, y = ta[ka == kind], tb[kb == kind]
        weights += len(x) + len(y)
        if len(x) and len(y):
            near = cKDTree(x[:, None]).count_neighbors(cKDTree(y[:, None]), np.nextafter(TAU_US, 0))
            total += near / math.sqrt(len(x) * len(y)) * (len(x) + len(y))
    return total / weights if weights else 0.0


SERIES = st.lists(st.tuples(st.integers(0, 4000), st.sampled_from(list(Kind)[:5])), max_size=12)


@settings(max_examples=150)
@given(SERIES, SERIES, st.integers(-100_000, 100_000), st.randoms(use_true_random=False))
def test_order_shift_and_direction_change_nothing(a, b, shift_ms, random):
    def index(x, y, by=0):
        return pair_index([(t + by) / 1e3 for t, _ in x], [k for _, k in x],
                          [(t + by) / 1e3 for t, _ in y], [k for _, k in y])  # fmt: skip

    value = index(a, b)
    assert index(a, b, shift_ms) == pytest.approx(value, abs=1e-12)
    assert index(b, a) == pytest.approx(value, abs=1e-12)
    shuffled = list(a)
    random.shuffle(shuffled)
    assert index(shuffled, b) == pytest.approx(value, abs=1e-12)


@settings(max_examples=60)
@given(st.lists(SERIES, min_size=2, max_size=4), st.randoms(use_true_random=False))
def test_naming_agents_otherwise_changes_nothing(trains, random):
    series = {f"dancer_{i}": ([t / 1e3 for t, _ in x], [k for _, k in x]) for i, x in enumerate(trains)}
    names = list(series)
    random.shuffle(names)
    renamed = group_index({name: series[name] for name in names}, "full")
    group = group_index(series, "full")
    assert renamed.gsi == pytest.approx(group.gsi, abs=1e-12)
    assert all(
        renamed.individual[names.index(name)] == pytest.approx(group.individual[i], abs=1e-12)
        for i, name in enumerate(group.agents)
    )


def team(robot=FULL):
    return {"dancer_1": FULL, "dancer_2": shifted(FULL, 0.1), "dancer_3": shifted(FULL, -0.1), "robot": robot}


@pytest.mark.parametrize(
    ("edges", "follows", "cap"),
    [
        ("paper", ("dancer_2",), 10 / 12),
        ("paper", (), 9 / 12),
        ("paper", None, 1.0),
        ("full", ("dancer_2",), 1.0),
    ],
)
def test_perfect_synchrony_reaches_each_edge_rules_cap(edges, follows, cap):
    assert group_index(team(), edges, follows=follows).gsi == pytest.approx(cap, abs=1e-12)


def test_gsi_is_the_papers_sum_of_pairs():
    team_ = team(shifted(FULL, 0.2))
    q = {(a, b): pair_index(*team_[a], *team_[b]) for a in team_ for b in team_}
    humans = q["dancer_1", "dancer_2"] + q["dancer_1", "dancer_3"] + q["dancer_2", "dancer_3"]
    robot = [q["robot", f"dancer_{i}"] for i in (1, 2, 3)]
    assert group_index(team_, follows=None).gsi == pytest.approx((humans + sum(robot)) / 6)
    assert group_index(team_, follows=("dancer_2",)).gsi == pytest.approx((2 * humans + sum(robot) + robot[1]) / 12)


def test_index_and_connectivity_agree_with_networkx():
    rng = np.random.default_rng(3)
    for _ in range(50):
        size = int(rng.integers(2, 6))
        pairs = rng.random((size, size))
        edges = rng.random((size, size)) < 0.6
        np.fill_diagonal(edges, False)
        graph = nx.DiGraph()
        graph.add_nodes_from(range(size))
        graph.add_weighted_edges_from((i, j, pairs[i, j]) for i, j in zip(*np.nonzero(edges), strict=True))
        out = dict(graph.out_degree())
        weighted = dict(graph.out_degree(weight="weight"))
        mean = [weighted[i] / out[i] if out[i] else 0.0 for i in range(size)]
        assert individual_index(pairs, edges) == pytest.approx(mean)
        assert connectivity(edges) == pytest.approx([out[i] / (size - 1) for i in range(size)])


def test_a_group_of_one_or_an_empty_iteration_scores_zero():
    assert group_index({"dancer_1": FULL}, "full").gsi == 0.0
    empty = group_index({"dancer_1": ([], []), "dancer_2": ([], [])}, "full")
    assert empty.gsi == 0.0
    assert empty.empty_pairs == (("dancer_1", "dancer_2"),)


def test_one_dancer_always_late_is_never_the_most_synchronous():
    rng = np.random.default_rng(0)
    for late in range(3):
        for _ in range(20):
            series = {}
            for i in range(3):
                delay = 0.6 if i == late else 0.0
                series[f"dancer_{i + 1}"] = ([t + delay + rng.normal(0, 0.03) for t in FULL[0]], FULL[1])
            assert most_synchronous(series).person != f"dancer_{late + 1}"


def test_a_tie_keeps_the_one_before_if_tied_else_takes_the_first():
    series = {"dancer_1": FULL, "dancer_2": FULL, "dancer_3": shifted(FULL, 1.0)}
    assert most_synchronous(series).person == "dancer_1"
    assert most_synchronous(series, "dancer_2").person == "dancer_2"
    assert most_synchronous(series, "dancer_3").person == "dancer_1"
    assert most_synchronous(series).tied == ("dancer_1", "dancer_2")
