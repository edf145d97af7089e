"""Prices of studies."""

import re
from collections import namedtuple

import pytest

from sjasim.config import SessionConfig
from sjasim.core.errors import RecordError
from sjasim.studies import study_price
from sjasim.studies.study_design import StudyDesign, StudyPlan
from sjasim.studies.study_price import Price, check_room, duration_text, price, size_text

Usage = namedtuple("Usage", "total used free")


def test_the_price_grows_with_the_sessions():
    one = price(StudyPlan(StudyDesign()))
    many = price(StudyPlan(StudyDesign(replications=1000)))
    assert one.sessions == 27
    assert many.cpu_s == pytest.approx(1000 * one.cpu_s)
    assert many.disk_bytes == pytest.approx(1000 * one.disk_bytes)


def test_physics_costs_more_than_timing_and_depth_more_than_joints():
    def cpu_s(**fields):
        return price(StudyPlan(StudyDesign(session=SessionConfig(**fields)))).cpu_s

    assert cpu_s(fidelity="physics", sensing="depth") > 3 * cpu_s(fidelity="physics", sensing="joints")
    assert cpu_s(fidelity="physics", sensing="joints") > 100 * cpu_s(fidelity="timing")


def test_without_events_there_is_less_to_store():
    kept = price(StudyPlan(StudyDesign())).disk_bytes
    assert price(StudyPlan(StudyDesign(events=False))).disk_bytes < 0.5 * kept


def test_a_million_sessions_without_room_are_refused_in_one_line(monkeypatch, tmp_path):
    monkeypatch.setattr(study_price.shutil, "disk_usage", lambda folder: Usage(10**10, 0, 10**9))
    needed = price(StudyPlan(StudyDesign(groups=333_334)))
    with pytest.raises(RecordError, match=r"1,000,002 sessions need \S+ GB on disk, and .* has 1.0 GB") as caught:
        check_room(needed, tmp_path / "not" / "yet" / "there")
    assert "\n" not in str(caught.value)
    check_room(price(StudyPlan(StudyDesign())), tmp_path)


def test_prices_are_said_in_words():
    assert re.fullmatch(
        r"1,000 sessions: about 5 min on 2 processes, 1.5 GB on disk", Price(1000, 600.0, 1.5e9).text(2)
    )
    assert [duration_text(value) for value in (0.1, 90.0, 300.0, 9000.0, 200000.0)] == [
        "1 s", "90 s", "5 min", "2 h", "2 days",
    ]  # fmt: skip
    assert [size_text(value) for value in (10, 4.5e6, 45e6, 3e12)] == ["1 kB", "4.5 MB", "45 MB", "3.0 TB"]
