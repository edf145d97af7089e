"""The client: rates, latency, stamps, orders, clock exchanges, death."""

from __future__ import annotations

import math

import pytest

from sjasim.choreography.layout import layout
from sjasim.config import JointNoiseConfig, SensorConfig, SessionConfig
from sjasim.core import ClientOrder, ClientStatus, DeviceEvent, SyncReply, SyncRequest
from sjasim.core.clock import DeviceClock

from .scripted import FRAME_HZ, NORTH, PLACES, Script, ScriptedView, Walk, client, dancers

EXACT = JointNoiseConfig(bias_m=0.0, drift_m=0.0)
CLOCK = DeviceClock(offset_s=0.3, drift=40e-6)


def run(watcher: object, view: ScriptedView, from_tick: int, to_tick: int) -> list[tuple[float, object]]:
    """Messages with the session time at which they came out."""
    messages = []
    for tick in range(from_tick, to_tick):
        t_s = tick / FRAME_HZ
        watcher.capture_frame(t_s, view.at(t_s))
        messages += [(t_s, message) for message in watcher.pop_messages(t_s)]
    return messages


def walkers() -> ScriptedView:
    return ScriptedView([Script(place, walks=[Walk(2.0, 1.5, 0.5)]) for place in PLACES])


class Counting(ScriptedView):
    frames = 0

    @property
    def solids(self):
        self.frames += 1
        return super().solids


def test_an_idle_client_takes_few_frames_and_reports_status_only():
    view = Counting(walkers().scripts)
    messages = run(client(), view, 0, 120)
    assert view.frames == 8
    assert {type(message) for _, message in messages} == {ClientStatus}
    assert [round(t * FRAME_HZ) for t, _ in messages] == [2 + 6 * k for k in range(20)]
    assert sum(message.persons is not None for _, message in messages) == 8


def test_a_watching_client_takes_every_frame_and_reports_status_as_often():
    watcher = client()
    watcher.handle_message(0.0, ClientOrder("north", True), 0.0)
    view = Counting(walkers().scripts)
    messages = [message for _, message in run(watcher, view, 0, 150)]
    assert view.frames == 150
    assert sum(isinstance(message, ClientStatus) for message in messages) == 25
    assert sum(isinstance(message, DeviceEvent) for message in messages) == 9


@pytest.mark.parametrize("status_hz", [1, 4, 7, 30])
def test_status_rate_holds_for_any_rate(status_hz: int):
    messages = run(client(sensors=SensorConfig(status_hz=status_hz)), walkers(), 0, 302)
    assert len(messages) == pytest.approx(10 * status_hz, abs=1)


def test_status_places_persons_in_the_world():
    for mount in layout(SessionConfig()).mounts:
        view = ScriptedView([Script(place, 0.4 * index, sway_m=0.0) for index, place in enumerate(PLACES)])
        watcher = client(joint_noise=EXACT, mount=mount)
        _, status = run(watcher, view, 0, 3)[0]
        assert isinstance(status, ClientStatus)
        assert status.sensor == mount.name
        order = dancers(watcher)
        assert sorted(person.person for person in status.persons) == [0, 1, 2]
        for person in status.persons:
            index = order[person.person]
            assert (person.x_m, person.y_m) == pytest.approx(PLACES[index], abs=1e-9)
            assert person.yaw_rad == pytest.approx(0.4 * index, abs=1e-9)
            assert 0.6 < person.tracked <= 1.0  # near feet leave the picture, far arms the range


def test_persons_out_of_range_are_left_out_of_the_status():
    view = ScriptedView([Script(PLACES[0]), Script((0.0, -2.0))])
    watcher = client(group=2)
    _, status = run(watcher, view, 0, 3)[0]
    assert isinstance(status, ClientStatus)
    assert [dancers(watcher)[person.person] for person in status.persons] == [0]


def test_messages_are_stamped_with_the_device_clock_when_ready():
    watcher = client(clock=CLOCK)
    watcher.handle_message(0.0, ClientOrder("north", True), 0.0)
    for t_s, message in run(watcher, walkers(), 0, 150):
        assert message.t_device_s == pytest.approx(CLOCK.reading(t_s), abs=1e-9)


def test_a_late_call_still_stamps_the_moment_of_readiness():
    watcher, view = client(clock=CLOCK), walkers()
    watcher.capture_frame(0.0, view.at(0.0))
    assert watcher.next_output_s == pytest.approx(2 / FRAME_HZ)
    assert watcher.pop_messages(0.05) == []
    (status,) = watcher.pop_messages(1.0)
    assert status.t_device_s == pytest.approx(CLOCK.reading(2 / FRAME_HZ), abs=1e-12)
    assert watcher.next_output_s == math.inf


def test_clock_exchange_carries_device_stamps():
    reply = client(clock=CLOCK).handle_message(5.0, SyncRequest("north", 4.98), 5.0)
    assert reply == SyncReply("north", 4.98, CLOCK.reading(5.0), CLOCK.reading(5.0))


def test_a_clock_that_jumps_changes_stamps_but_no_event():
    def kinds(clock: DeviceClock) -> list[tuple[object, bool]]:
        watcher = client(clock=clock)
        watcher.handle_message(0.0, ClientOrder("north", True), 0.0)
        messages = [message for _, message in run(watcher, walkers(), 0, 150)]
        return [(m.kind, m.early) for m in messages if isinstance(m, DeviceEvent)]

    jumped = kinds(DeviceClock(jump_at_s=2.6, jump_s=-5.0))
    assert len(jumped) == 9
    assert jumped == kinds(DeviceClock())


def test_a_dead_client_is_silent():
    watcher = client(dead_from_s=2.0)
    messages = run(watcher, walkers(), 0, 120)
    assert max(t for t, _ in messages) < 2.0
    assert watcher.handle_message(1.9, SyncRequest("north", 1.88), 1.9) is not None
    assert watcher.handle_message(2.0, SyncRequest("north", 1.98), 2.0) is None


def test_orders_switch_detection_and_repeats_change_nothing():
    watcher, view = client(), walkers()
    run(watcher, view, 0, 30)
    watcher.handle_message(1.0, ClientOrder("north", True), 1.0)
    messages = run(watcher, view, 30, 75)
    watcher.handle_message(2.5, ClientOrder("north", True), 2.5)
    messages += run(watcher, view, 75, 90)
    assert sum(isinstance(message, DeviceEvent) for _, message in messages) == 6
    watcher.handle_message(3.0, ClientOrder("north", False), 3.0)
    assert not watcher.detecting
    assert all(isinstance(message, ClientStatus) for _, message in run(watcher, view, 90, 150))


def test_a_lost_frame_delays_the_status_it_should_have_carried():
    watcher = client(sensors=SensorConfig(frame_loss=0.5))
    watcher.handle_message(0.0, ClientOrder(NORTH.name, True), 0.0)
    messages = run(watcher, walkers(), 0, 300)
    assert sum(isinstance(message, ClientStatus) for _, message in messages) >= 47
