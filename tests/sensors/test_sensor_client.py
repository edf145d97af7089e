"""The client of a sensor: rates, latency, time stamps, orders, clock exchanges, death."""

from __future__ import annotations

import math

import pytest

from sjasim.choreography.layout import layout
from sjasim.config import JointNoiseConfig, SensorConfig, SessionConfig
from sjasim.core import ClientOrder, ClientStatus, DeviceEvent, SyncReply, SyncRequest
from sjasim.core.clock import DeviceClock

from .scripted import FRAME_HZ, NORTH, PLACES, Script, ScriptedView, Walk, dancer_of_person, make_client, run_client

EXACT = JointNoiseConfig(bias_m=0.0, drift_m=0.0)
CLOCK = DeviceClock(offset_s=0.3, drift=40e-6)


def walkers() -> ScriptedView:
    return ScriptedView([Script(place, walks=[Walk(2.0, 1.5, 0.5)]) for place in PLACES])


class CountingView(ScriptedView):
    """Counts the frames that are taken of it."""

    frames = 0

    @property
    def solids(self):
        self.frames += 1
        return super().solids


def test_a_client_on_standby_captures_few_frames_and_reports_status_only():
    view = CountingView(walkers().scripts)
    messages = run_client(make_client(), view, 0, 120)
    assert view.frames == 8
    assert {type(message) for _, message in messages} == {ClientStatus}
    assert [round(t * FRAME_HZ) for t, _ in messages] == [2 + 6 * k for k in range(20)]
    assert sum(message.persons is not None for _, message in messages) == 8


def test_a_detecting_client_captures_every_frame_and_reports_at_the_status_rate():
    client = make_client()
    client.handle_message(0.0, ClientOrder("north", True), 0.0)
    view = CountingView(walkers().scripts)
    messages = [message for _, message in run_client(client, view, 0, 150)]
    assert view.frames == 150
    assert sum(isinstance(message, ClientStatus) for message in messages) == 25
    assert sum(isinstance(message, DeviceEvent) for message in messages) == 9


@pytest.mark.parametrize("status_hz", [1, 4, 7, 30])
def test_status_rate_holds_for_any_rate(status_hz: int):
    messages = run_client(make_client(sensors=SensorConfig(status_hz=status_hz)), walkers(), 0, 302)
    assert len(messages) == pytest.approx(10 * status_hz, abs=1)


def test_status_gives_world_positions_and_headings():
    for mount in layout(SessionConfig()).mounts:
        view = ScriptedView([Script(place, 0.4 * index, sway_m=0.0) for index, place in enumerate(PLACES)])
        client = make_client(joint_noise=EXACT, mount=mount)
        _, status = run_client(client, view, 0, 3)[0]
        assert isinstance(status, ClientStatus)
        assert status.sensor == mount.name
        order = dancer_of_person(client)
        assert sorted(person.person for person in status.persons) == [0, 1, 2]
        for person in status.persons:
            index = order[person.person]
            assert (person.x_m, person.y_m) == pytest.approx(PLACES[index], abs=1e-9)
            assert person.yaw_rad == pytest.approx(0.4 * index, abs=1e-9)
            assert (
                0.6 < person.tracked <= 1.0
            )  # feet of near persons are out of the picture, arms of far ones out of range


def test_persons_out_of_range_are_left_out_of_the_status():
    view = ScriptedView([Script(PLACES[0]), Script((0.0, -2.0))])
    client = make_client(dancers=2)
    _, status = run_client(client, view, 0, 3)[0]
    assert isinstance(status, ClientStatus)
    assert [dancer_of_person(client)[person.person] for person in status.persons] == [0]


def test_messages_carry_the_device_time_at_which_processing_ended():
    client = make_client(clock=CLOCK)
    client.handle_message(0.0, ClientOrder("north", True), 0.0)
    messages = run_client(client, walkers(), 0, 150)
    assert len(messages) == 25 + 9
    for t_s, message in messages:
        assert message.t_device_s == pytest.approx(CLOCK.reading(t_s), abs=1e-9)


def test_a_late_call_gives_the_time_at_which_processing_ended():
    client = make_client(clock=CLOCK)
    view = walkers()
    client.capture_frame(0.0, view.at(0.0))
    assert client.next_output_s == pytest.approx(2 / FRAME_HZ)
    assert client.pop_messages(0.05) == []
    (status,) = client.pop_messages(1.0)
    assert status.t_device_s == pytest.approx(CLOCK.reading(2 / FRAME_HZ), abs=1e-12)
    assert client.next_output_s == math.inf


def test_a_clock_exchange_is_answered_with_device_times():
    reply = make_client(clock=CLOCK).handle_message(5.0, SyncRequest("north", 4.98), 5.0)
    assert reply == SyncReply("north", 4.98, CLOCK.reading(5.0), CLOCK.reading(5.0))


def test_a_clock_that_jumps_changes_times_but_no_event():
    def kinds(clock: DeviceClock) -> list[tuple[object, bool]]:
        client = make_client(clock=clock)
        client.handle_message(0.0, ClientOrder("north", True), 0.0)
        messages = [message for _, message in run_client(client, walkers(), 0, 150)]
        return [(m.kind, m.early) for m in messages if isinstance(m, DeviceEvent)]

    jumped = kinds(DeviceClock(jump_at_s=2.6, jump_s=-5.0))
    assert len(jumped) == 9
    assert jumped == kinds(DeviceClock())


def test_a_dead_client_sends_and_answers_nothing():
    client = make_client(dead_from_s=2.0)
    messages = run_client(client, walkers(), 0, 120)
    assert max(t for t, _ in messages) < 2.0
    assert client.handle_message(1.9, SyncRequest("north", 1.88), 1.9) is not None
    assert client.handle_message(2.0, SyncRequest("north", 1.98), 2.0) is None


def test_orders_switch_detection_and_repeats_change_nothing():
    client = make_client()
    view = walkers()
    run_client(client, view, 0, 30)
    client.handle_message(1.0, ClientOrder("north", True), 1.0)
    messages = run_client(client, view, 30, 75)
    client.handle_message(2.5, ClientOrder("north", True), 2.5)
    messages += run_client(client, view, 75, 90)
    assert sum(isinstance(message, DeviceEvent) for _, message in messages) == 6
    client.handle_message(3.0, ClientOrder("north", False), 3.0)
    assert not client.detecting
    assert all(isinstance(message, ClientStatus) for _, message in run_client(client, view, 90, 150))


def test_the_status_of_a_lost_frame_goes_out_with_the_next_frame():
    client = make_client(sensors=SensorConfig(frame_loss=0.5))
    client.handle_message(0.0, ClientOrder(NORTH.name, True), 0.0)
    messages = run_client(client, walkers(), 0, 300)
    assert sum(isinstance(message, ClientStatus) for _, message in messages) >= 47
