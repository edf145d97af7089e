"""Two sessions are compared in one table and on common axes."""

import re

import pytest

from sjasim.analysis.delay_breakdown import delay_report
from sjasim.record.rerun.explanation import DelayReport

pytest.importorskip("rerun")

from sjasim.record.rerun.comparison import comparison_as_markdown
from sjasim.record.rerun.recording import save_all
from sjasim.record.rerun.rrd_reader import read_chunks


@pytest.fixture(scope="module")
def reports(make_session_log):
    sia = make_session_log(method="sia", iterations=2, spread_s=0.0, joints=False)
    eca = make_session_log(method="eca", iterations=2, spread_s=0.0, late_s=(-0.8, 0.0, 0.0), joints=False)
    return {"sia-0": delay_report(sia), "eca-0": delay_report(eca)}


def cells(text, name):
    """Cells of a row of the table, without its name."""
    line = next(line for line in text.splitlines() if line.startswith(f"| {name} "))
    return [cell.strip() for cell in line.strip("|").split("|")][1:]


def test_the_table_has_the_means_of_both_and_the_difference(reports):
    text = comparison_as_markdown(reports)
    assert cells(text, "mean over the session") == ["sia-0", "eca-0", "eca-0 - sia-0"]
    assert cells(text, "GSI, paper's edges")[0] == "0.79"
    # The robot answers the first dancer .3 s after its onset; in the second session that dancer is .53 s ahead.
    behind = [float(cell) for cell in cells(text, "robot behind the dancers, true onsets [s]")]
    assert behind == pytest.approx([0.30, -0.23, -0.53], abs=0.02)
    steps = cells(text, "steps on time / late / early / missed")
    assert steps == ["18 / 0 / 0 / 0", "18 / 0 / 0 / 0", "+0 / +0 / +0 / +0"]
    assert "say nothing about the methods" in text


def test_what_happened_stands_below_the_table_for_each_session(reports):
    text = comparison_as_markdown(reports)
    sia, eca = text.partition("**sia-0**")[2].split("**eca-0**")
    assert re.search(r"\| 1 \| nobody \|.*\n\| 2 \| dancer_1 \|", sia)
    assert re.search(r"\| 1 \| everyone \|.*\n\| 2 \| everyone \|", eca)


def test_a_session_without_a_robot_has_dashes(reports):
    text = comparison_as_markdown({"sia-0": reports["sia-0"], "none-0": DelayReport()})
    assert cells(text, "timing appropriateness [s]") == ["0.18", "-", "-"]


def test_the_recording_has_both_sessions_curves_on_common_axes(reports, make_session_log, tmp_path):
    logs = {label: make_session_log(method=label[:3], iterations=2, joints=False) for label in reports}
    path = tmp_path / "two.rrd"
    save_all({label: (log, reports[label]) for label, log in logs.items()}, path)

    values = {}
    for entity, batch in read_chunks(path):
        if entity.startswith("/comparison/"):
            values.setdefault(entity, []).extend(row[0] for row in batch.column("Scalars:scalars").to_pylist())
    assert set(values) == {f"/comparison/{name}/{label}" for name in ("gsi", "late") for label in reports}
    for label, report in reports.items():
        assert sorted(values[f"/comparison/gsi/{label}"]) == sorted(graph.gsi_full_edges for graph in report.graphs)
        assert len(values[f"/comparison/late/{label}"]) == 18
