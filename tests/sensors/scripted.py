"""A scene without physics: rigid figures on scripted paths, and spheres that occlude them."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from sjasim.assets.names import JOINT_INDEX, JOINTS
from sjasim.choreography.layout import Mount, layout
from sjasim.config import DetectorConfig, JointNoiseConfig, SensorConfig, SessionConfig
from sjasim.core import ClientOrder, DeviceEvent, Kind, Solids
from sjasim.core.clock import DeviceClock, stream
from sjasim.sensors.joint_sensing import JointSensing
from sjasim.sensors.raycast.occlusion import bounding_shapes
from sjasim.sensors.raycast.primitives import SPHERE
from sjasim.sensors.sensor_client import SensorClient

ONSET_M_S = 0.10
"""Speed at which a true move starts and stops."""

# Joints on the median plane and those of the left side: forward, left, up [m], for a stature of 1.72 m.
_MIDDLE = {"SpineBase": (0, 0, 0.95), "SpineMid": (0, 0, 1.18), "SpineShoulder": (0, 0, 1.40), "Neck": (0, 0, 1.47),
           "Head": (0.02, 0, 1.62)}  # fmt: skip
_LEFT = {"Shoulder": (0, 0.18, 1.38), "Elbow": (-0.02, 0.24, 1.12), "Wrist": (0.04, 0.26, 0.88),
         "Hand": (0.06, 0.26, 0.80), "HandTip": (0.07, 0.26, 0.73), "Thumb": (0.09, 0.24, 0.80),
         "Hip": (0, 0.09, 0.92), "Knee": (0.02, 0.10, 0.50), "Ankle": (0, 0.10, 0.09),
         "Foot": (0.12, 0.11, 0.04)}  # fmt: skip
_HAND_JOINTS = ("Wrist", "Hand", "HandTip", "Thumb")

CLAP_REACH_S = 0.45
"""Duration from the start of a clap to the meeting of the palms."""


def figure() -> np.ndarray:
    """(25, 3) joints of a standing figure: forward, left, up from the floor below the pelvis [m]."""
    rows = np.zeros((len(JOINTS), 3))
    for name, place in _MIDDLE.items():
        rows[JOINT_INDEX[name]] = place
    for name, (x, y, z) in _LEFT.items():
        rows[JOINT_INDEX[name + "Left"]] = x, y, z
        rows[JOINT_INDEX[name + "Right"]] = x, -y, z
    return rows


def min_jerk(share: float) -> float:
    """Share of the way after a share of the time of a minimum-jerk motion."""
    share = min(max(share, 0.0), 1.0)
    return share**3 * (10.0 + share * (6.0 * share - 15.0))


@dataclass
class Walk:
    """A minimum-jerk walk along the heading, backward if its length is negative.

    Its true events are the times at which the speed crosses `ONSET_M_S`.
    """

    t_s: float
    duration_s: float
    length_m: float

    def kinds(self) -> tuple[Kind, Kind]:
        if self.length_m > 0:
            return Kind.START_FORWARD, Kind.STOP_FORWARD
        return Kind.START_BACKWARD, Kind.STOP_BACKWARD

    def events(self) -> list[tuple[float, Kind]]:
        share = np.linspace(0.0, 0.5, 20001)
        speed = 30.0 * (share * (1.0 - share)) ** 2 * abs(self.length_m) / self.duration_s
        onset_s = float(share[np.argmax(speed > ONSET_M_S)]) * self.duration_s

        start, stop = self.kinds()
        return [(self.t_s + onset_s, start), (self.t_s + self.duration_s - onset_s, stop)]


@dataclass
class Script:
    """What one dancer does.

    Attributes:
        place: position at the start [m].
        heading_rad: heading at the start.
        walks: walks along the heading at the start.
        claps: times at which the palms meet [s].
        turns: start [s], duration [s] and angle [rad] of each turn.
        sway_m: amplitude of a slow sway along the heading.
    """

    place: tuple[float, float] = (0.0, 0.0)
    heading_rad: float = math.pi / 2
    walks: list[Walk] = field(default_factory=list)
    claps: list[float] = field(default_factory=list)
    turns: list[tuple[float, float, float]] = field(default_factory=list)
    sway_m: float = 0.004

    def joints(self, t_s: float, body: np.ndarray) -> tuple[np.ndarray, float]:
        """(25, 3) world joints [m] and the heading [rad]."""
        along_m = 0.0
        up_m = 0.0
        heading = self.heading_rad
        for walk in self.walks:
            share = (t_s - walk.t_s) / walk.duration_s
            if share >= 1.0:
                along_m += walk.length_m
            elif share > 0.0:
                along_m += walk.length_m * min_jerk(share)
                # The pelvis goes up and down and swings with each stride, as detectors see it in real people.
                weight = math.sin(math.pi * share) ** 2
                phase = 2 * math.pi * 0.9 * (t_s - walk.t_s)
                up_m += 0.015 * weight * math.sin(2 * phase)
                heading += 0.05 * weight * math.sin(phase)
        for start_s, duration_s, angle in self.turns:
            heading += angle * min_jerk((t_s - start_s) / duration_s)
        along_m += self.sway_m * math.sin(2 * math.pi * 0.3 * t_s + self.place[0])

        rows = self._with_clap(body, t_s)
        cos = math.cos(heading)
        sin = math.sin(heading)
        world = rows @ np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]])
        x, y = self.place
        world += (x + along_m * math.cos(self.heading_rad), y + along_m * math.sin(self.heading_rad), up_m)
        return world, heading

    def _with_clap(self, body: np.ndarray, t_s: float) -> np.ndarray:
        """The body's joints with its hands where the clap at this time, if any, has them."""
        clap_s = next((clap_s for clap_s in self.claps if abs(t_s - clap_s) < CLAP_REACH_S), None)
        if clap_s is None:
            return body

        rows = body.copy()
        share = min_jerk(1.0 - abs(t_s - clap_s) / CLAP_REACH_S)
        for side, sign in (("Left", 1.0), ("Right", -1.0)):
            index = [JOINT_INDEX[name + side] for name in _HAND_JOINTS]
            rows[index] += share * (np.array([0.35, sign * 0.03, 1.15]) - rows[JOINT_INDEX["Hand" + side]])
        return rows

    def events(self) -> list[tuple[float, Kind]]:
        """True events in the order of their times."""
        moves = [event for walk in self.walks for event in walk.events()]
        return sorted(moves + [(clap_s, Kind.CLAP) for clap_s in self.claps])


@dataclass
class Screen:
    """A sphere that occludes what is behind it between two times; it is a part of the body of dancer ``owner``."""

    centre: tuple[float, float, float]
    radius_m: float
    owner: int = -1
    from_s: float = -math.inf
    until_s: float = math.inf


class ScriptedView:
    """A `SceneView` of scripted dancers."""

    def __init__(self, scripts: list[Script], screens: list[Screen] | None = None) -> None:
        self.scripts = scripts
        self.screens = screens or []
        self._body = figure()
        self.at(0.0)

    def at(self, t_s: float) -> ScriptedView:
        """Set the time and return the view."""
        self.time_s = t_s
        states = [script.joints(t_s, self._body) for script in self.scripts]
        self.joints_m = np.stack([joints for joints, _ in states])
        self.yaw_rad = np.array([heading for _, heading in states])
        return self

    def sensor_joints(self, t_s: float) -> np.ndarray:
        """(P, 25, 3) exact joints at a time in the frame of the north sensor [m]."""
        return (self.at(t_s).joints_m - NORTH.position) @ NORTH.world_from_sensor

    @property
    def solids(self) -> Solids:
        there = [screen for screen in self.screens if screen.from_s <= self.time_s < screen.until_s]
        rows = np.array([(row, screen.owner, SPHERE) for row, screen in enumerate(there)], dtype=np.int64)
        sizes = np.array([(screen.radius_m, 0.0, 0.0) for screen in there]).reshape(-1, 3)
        centres = np.array([screen.centre for screen in there]).reshape(-1, 3)
        shape = bounding_shapes(np.full(len(there), SPHERE), sizes)
        return Solids(rows.reshape(-1, 3), shape, centres, np.tile(np.eye(3).ravel(), (len(there), 1)))


NORTH: Mount = layout(SessionConfig()).mounts[0]
PLACES = ((0.97, 0.23), (-0.23, 0.97), (0.23, -0.97))
FRAME_HZ = 30


def make_client(
    seed: int = 0,
    dancers: int = 3,
    sensors: SensorConfig | None = None,
    joint_noise: JointNoiseConfig | None = None,
    clock: DeviceClock | None = None,
    mount: Mount = NORTH,
    **options: float,
) -> SensorClient:
    """A client whose skeletons come from the true joints."""
    sensors = sensors or SensorConfig()
    config = SessionConfig(
        sensors=sensors, joint_noise=joint_noise or JointNoiseConfig(), dancers=dancers, sensing="joints"
    )
    source = JointSensing(mount, config, stream(seed, "sensors", mount.name))
    return SensorClient(mount, source, DetectorConfig(), sensors, clock or DeviceClock(), **options)


def run_client(client: SensorClient, view: ScriptedView, from_tick: int, to_tick: int) -> list[tuple[float, object]]:
    """Messages of a client with the session times at which it sends them."""
    messages: list[tuple[float, object]] = []
    for tick in range(from_tick, to_tick):
        t_s = tick / FRAME_HZ
        client.capture_frame(t_s, view.at(t_s))
        messages += [(t_s, message) for message in client.pop_messages(t_s)]
    return messages


def detect(
    view: ScriptedView,
    until_s: float,
    client: SensorClient | None = None,
    *,
    from_s: float = 0.0,
    side: bool = False,
) -> list[DeviceEvent]:
    """Events that a client detects; with ``side`` it is ordered to detect claps from the side only."""
    client = client or make_client(dancers=len(view.scripts))
    client.handle_message(from_s, ClientOrder(client.name, not side, assist=side), from_s)
    messages = run_client(client, view, round(from_s * FRAME_HZ), round(until_s * FRAME_HZ))
    return [message for _, message in messages if isinstance(message, DeviceEvent)]


def dancer_of_person(client: SensorClient) -> list[int]:
    """Index of the dancer behind each person of a client, which only tests may know."""
    return client._source.dancers.tolist()  # type: ignore[attr-defined]


class Match(NamedTuple):
    """Result of matching detected to true events one to one: delays [s] by kind, numbers of missed and false events."""

    delays_s: dict[Kind, list[float]]
    missed: int
    false: int


def match_events(
    detected: list[tuple[float, Kind]], true: list[tuple[float, Kind]], before_s: float, after_s: float
) -> Match:
    """Match each true event to the first detected one of its kind from ``before_s`` before to ``after_s`` after it."""
    delays_s: dict[Kind, list[float]] = {}
    left = sorted(detected)
    missed = 0
    for t_s, kind in sorted(true):
        found = next((event for event in left if event[1] is kind and -before_s <= event[0] - t_s <= after_s), None)
        if found is None:
            missed += 1
        else:
            left.remove(found)
            delays_s.setdefault(kind, []).append(found[0] - t_s)
    return Match(delays_s, missed, len(left))
