"""Scores of the sensor clients: frontal views, back views, and the lead that a new active sensor needs."""

import math

import pytest

from sjasim.core import PersonStatus
from sjasim.server.active_sensor import PRIOR, ActiveSensorSelector

NOW_S = 1.0


@pytest.fixture
def selector(world):
    """A selector in the rehearsal, which faces east, with every client alive."""
    selector = ActiveSensorSelector(world.timetable, world.layout, 3)
    assert selector.name == "east"
    assert selector.expected(NOW_S) == {"east"}
    for sensor in selector.sensors:
        selector.mark_alive(NOW_S, sensor)
    return selector


@pytest.fixture
def report(selector):
    """Reports three persons to a client: each tracked to some share, at some angle to the direction of the sensor."""

    def send(sensor, tracked, angle_rad=0.0, t_s=NOW_S):
        yaw_rad = selector._clients[sensor].bearing_rad + angle_rad
        selector.update(t_s, sensor, [PersonStatus(k, 0.0, 0.0, yaw_rad, tracked, 1.0) for k in range(3)])

    return send


@pytest.mark.parametrize(("lead", "selected"), [(0.05, "east"), (0.15, "north")])
def test_another_client_needs_a_lead_to_become_active(selector, report, lead, selected):
    report("east", 0.2)
    report("north", 0.2 + PRIOR + lead)
    selector.select(NOW_S)
    assert selector.name == selected


def test_noise_of_two_equal_views_does_not_switch_the_active_client(selector, report):
    report("east", 0.2)
    report("north", 0.4 + PRIOR)
    selector.select(NOW_S)
    assert selector.name == "north"

    actives = []
    for k in range(10):
        t_s = NOW_S + 0.02 * k
        report("east", 0.35 if k % 2 else 0.45, t_s=t_s)
        selector.select(t_s)
        actives.append(selector.name)
    assert actives == ["north"] * 10


def test_the_back_view_of_all_dancers_is_worth_less_than_a_frontal_one(selector, report):
    """North sees 60 % of everyone's joints from the front; west sees all of them, but from behind."""
    report("east", 0.0)
    report("north", 0.6)
    report("west", 1.0, math.pi)
    selector.select(NOW_S)
    assert selector._clients["west"].view == pytest.approx(0.5)
    assert selector._clients["north"].view == pytest.approx(0.6)
    # East is faced by the iteration and has a bonus of .5, which .6 does not exceed by the hysteresis.
    assert selector.name == "east"

    report("north", 0.65)
    selector.select(NOW_S)
    assert selector.name == "north"
