"""The event detector on frames without a client: invariances, noise, and durations from the server."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from sjasim.assets.names import JOINT_INDEX
from sjasim.config import DetectorConfig
from sjasim.core import INFERRED, TRACKED, DeviceEvent, Kind, MoveDuration, SkeletonFrame, Skeletons
from sjasim.sensors.events.detectors import EventDetector

from ..scripted import FRAME_HZ, PLACES, Script, ScriptedView, Walk
from .dances import dance

LATENCY_S = 2 / FRAME_HZ


def exact_frames(
    view: ScriptedView, until_s: float, persons: tuple[int, ...], noise_m: float = 0.0
) -> list[SkeletonFrame]:
    """Frames with exact, tracked joints and white noise; ``persons`` names the dancers."""
    rng = np.random.default_rng(0)
    names = np.array(persons)
    frames = []
    for tick in range(round(until_s * FRAME_HZ)):
        t_s = tick / FRAME_HZ
        joints = view.sensor_joints(t_s)
        joints = joints + noise_m * rng.standard_normal(joints.shape)
        skeletons = Skeletons(names, joints, np.full(joints.shape[:2], TRACKED, dtype=np.int8))
        frames.append(SkeletonFrame("north", t_s + LATENCY_S, t_s, t_s, skeletons))
    return frames


def with_skeletons(frames: list[SkeletonFrame], change: Callable[[SkeletonFrame], Skeletons]) -> list[SkeletonFrame]:
    """The same frames with other skeletons."""
    return [frame._replace(skeletons=change(frame)) for frame in frames]


def events(frames: list[SkeletonFrame], *durations: MoveDuration) -> list[DeviceEvent]:
    """Events of these frames; the server has told the durations of some moves."""
    detector = EventDetector(DetectorConfig(), FRAME_HZ)
    detector.set_durations(durations)
    return [event for frame in frames for event in detector.update(frame)]


def test_other_names_of_the_persons_change_only_the_names():
    view = ScriptedView([dance(index, 2, place) for index, place in enumerate(PLACES)])
    plain = events(exact_frames(view, 25.0, (0, 1, 2)))
    renamed = events(exact_frames(view, 25.0, (7, 0, 4)))
    assert plain
    assert [(7, 0, 4)[event.person] for event in plain] == [event.person for event in renamed]
    assert [(e.kind, e.early, e.t_device_s) for e in plain] == [(e.kind, e.early, e.t_device_s) for e in renamed]


def test_the_order_of_the_rows_changes_nothing():
    scripts = [dance(index, 2, place) for index, place in enumerate(PLACES)]
    rotated = ScriptedView([scripts[2], scripts[0], scripts[1]])

    def by_time(found: list[DeviceEvent]) -> list[tuple[float, int, Kind, bool]]:
        return sorted((event.t_device_s, event.person, event.kind, event.early) for event in found)

    expected = by_time(events(exact_frames(ScriptedView(scripts), 25.0, (0, 1, 2))))
    assert expected
    assert by_time(events(exact_frames(rotated, 25.0, (2, 0, 1)))) == expected


def test_white_noise_of_one_centimetre_makes_false_moves():
    """A fact that the noise model has to respect: independent errors from frame to frame look like motion."""
    view = ScriptedView([Script(place) for place in PLACES])
    noisy = [event for event in events(exact_frames(view, 60.0, (0, 1, 2), 0.01)) if not event.early]
    assert len(noisy) > 60
    assert events(exact_frames(view, 60.0, (0, 1, 2), 0.001)) == []


def test_a_duration_from_the_server_arms_the_first_early_stop():
    view = ScriptedView([Script(PLACES[0], walks=[Walk(2.0, 1.8, 0.5)])])
    frames = exact_frames(view, 6.0, (0,))

    def stops(found: list[DeviceEvent]) -> list[bool]:
        return [event.early for event in found if event.kind is Kind.STOP_FORWARD]

    assert stops(events(frames)) == [False]
    assert stops(events(frames, MoveDuration(0, Kind.START_FORWARD, 1.4))) == [True, False]


def test_early_starts_are_disarmed_while_the_hands_are_together():
    """A trunk that nods with the clap would look like an early start."""
    upper = [JOINT_INDEX[name] for name in ("SpineMid", "Neck", "ShoulderLeft", "ShoulderRight", "SpineShoulder")]

    def nod(frame: SkeletonFrame) -> Skeletons:
        joints = frame.skeletons.joints.copy()
        joints[:, upper, 2] -= 0.03 * math.exp(-(((frame.t_sensor_s - 3.15) / 0.08) ** 2))
        return frame.skeletons._replace(joints=joints)

    clapping = exact_frames(ScriptedView([Script(PLACES[0], claps=[3.0])]), 6.0, (0,))
    standing = exact_frames(ScriptedView([Script(PLACES[0])]), 6.0, (0,))
    assert [event.kind for event in events(with_skeletons(clapping, nod))] == [Kind.CLAP]
    assert Kind.START_FORWARD in {event.kind for event in events(with_skeletons(standing, nod)) if event.early}


def test_inferred_joints_give_no_early_events():
    def infer(frame: SkeletonFrame) -> Skeletons:
        return frame.skeletons._replace(state=np.full((1, 25), INFERRED, dtype=np.int8))

    view = ScriptedView([Script(PLACES[0], walks=[Walk(2.0, 1.8, 0.5)])])
    frames = with_skeletons(exact_frames(view, 6.0, (0,)), infer)
    found = events(frames, MoveDuration(0, Kind.START_FORWARD, 1.4))
    assert [(event.kind, event.early) for event in found] == [(Kind.START_FORWARD, False), (Kind.STOP_FORWARD, False)]


@pytest.mark.parametrize("appears_s", [2.5, 3.0])
def test_a_person_who_appears_changes_nothing_for_the_others(appears_s: float):
    """A second person appears while the first one moves; the first one's events remain, and there are no others."""
    view = ScriptedView([Script(PLACES[0], walks=[Walk(2.0, 1.8, 0.5)])])

    def with_second(frame: SkeletonFrame) -> Skeletons:
        count = 1 if frame.t_sensor_s < appears_s else 2
        joints = np.repeat(frame.skeletons.joints, count, axis=0)
        return Skeletons(np.arange(4, 4 + count), joints, np.full((count, 25), TRACKED, dtype=np.int8))

    found = events(with_skeletons(exact_frames(view, 5.0, (4,)), with_second))
    regular = [(event.person, event.kind) for event in found if not event.early]
    assert regular == [(4, Kind.START_FORWARD), (4, Kind.STOP_FORWARD)]
