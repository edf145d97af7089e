"""A stage without physics: dancers as stiff figures on scripted paths, spheres to hide them behind."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from sjasim.assets.names import JOINT_INDEX, JOINTS
from sjasim.choreography.layout import Mount, layout
from sjasim.config import DetectorConfig, JointNoiseConfig, SensorConfig, SessionConfig
from sjasim.core import ClientOrder, DeviceEvent, Kind, Solids
from sjasim.core.clock import DeviceClock, stream
from sjasim.sensors.client import SensorClient
from sjasim.sensors.joint_sensing import JointSensing
from sjasim.sensors.raycast.occlusion import bounding_shapes
from sjasim.sensors.raycast.primitives import SPHERE

ONSET_M_S = 0.10

# forward, left, up [m], for a stature of 1.72 m
_MIDDLE = {"SpineBase": (0, 0, 0.95), "SpineMid": (0, 0, 1.18), "SpineShoulder": (0, 0, 1.40), "Neck": (0, 0, 1.47),
           "Head": (0.02, 0, 1.62)}  # fmt: skip
_LEFT = {"Shoulder": (0, 0.18, 1.38), "Elbow": (-0.02, 0.24, 1.12), "Wrist": (0.04, 0.26, 0.88),
         "Hand": (0.06, 0.26, 0.80), "HandTip": (0.07, 0.26, 0.73), "Thumb": (0.09, 0.24, 0.80),
         "Hip": (0, 0.09, 0.92), "Knee": (0.02, 0.10, 0.50), "Ankle": (0, 0.10, 0.09),
         "Foot": (0.12, 0.11, 0.04)}  # fmt: skip
_ARM = ("Wrist", "Hand", "HandTip", "Thumb")


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
    share = min(max(share, 0.0), 1.0)
    return share**3 * (10.0 + share * (6.0 * share - 15.0))


@dataclass
class Walk:
    """A min-jerk walk along the heading; true events where the speed crosses .10 m/s."""

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
        onset = float(share[np.argmax(speed > ONSET_M_S)]) * self.duration_s
        start, stop = self.kinds()
        return [(self.t_s + onset, start), (self.t_s + self.duration_s - onset, stop)]


@dataclass
class Script:
    """What one dancer does: walks, claps (times of the palms' meeting), turns (start, duration, angle)."""

    place: tuple[float, float] = (0.0, 0.0)
    heading_rad: float = math.pi / 2
    walks: list[Walk] = field(default_factory=list)
    claps: list[float] = field(default_factory=list)
    turns: list[tuple[float, float, float]] = field(default_factory=list)
    sway_m: float = 0.004

    def joints(self, t_s: float, body: np.ndarray) -> tuple[np.ndarray, float]:
        """(25, 3) world joints [m] and the heading [rad]."""
        along, heading, bob_m = 0.0, self.heading_rad, 0.0
        for walk in self.walks:  # with a stride's bob and the pelvis' swing
            share = (t_s - walk.t_s) / walk.duration_s
            if share >= 1.0:
                along += walk.length_m
            elif share > 0.0:
                along += walk.length_m * min_jerk(share)
                weight, phase = math.sin(math.pi * share) ** 2, 2 * math.pi * 0.9 * (t_s - walk.t_s)
                bob_m += 0.015 * weight * math.sin(2 * phase)
                heading += 0.05 * weight * math.sin(phase)
        for start_s, duration_s, angle in self.turns:
            heading += angle * min_jerk((t_s - start_s) / duration_s)
        along += self.sway_m * math.sin(2 * math.pi * 0.3 * t_s + self.place[0])
        rows = self._clap(body, t_s)
        cos, sin = math.cos(heading), math.sin(heading)
        world = rows @ np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]])
        x, y = self.place
        world += (x + along * math.cos(self.heading_rad), y + along * math.sin(self.heading_rad), bob_m)
        return world, heading

    def _clap(self, body: np.ndarray, t_s: float) -> np.ndarray:
        clap = next((clap for clap in self.claps if abs(t_s - clap) < 0.45), None)
        if clap is None:
            return body
        rows, near = body.copy(), min_jerk(1.0 - abs(t_s - clap) / 0.45)
        for side, sign in (("Left", 1.0), ("Right", -1.0)):
            index = [JOINT_INDEX[name + side] for name in _ARM]
            rows[index] += near * (np.array([0.35, sign * 0.03, 1.15]) - rows[JOINT_INDEX["Hand" + side]])
        return rows

    def events(self) -> list[tuple[float, Kind]]:
        moves = [event for walk in self.walks for event in walk.events()]
        return sorted(moves + [(clap, Kind.CLAP) for clap in self.claps])


@dataclass
class Screen:
    """A sphere that stops rays between two times; ``owner`` is the dancer whose flesh it is."""

    centre: tuple[float, float, float]
    radius_m: float
    owner: int = -1
    from_s: float = -math.inf
    until_s: float = math.inf


class ScriptedView:
    """A `SceneView` of scripts."""

    def __init__(self, scripts: list[Script], screens: list[Screen] | None = None) -> None:
        self.scripts = scripts
        self.screens = screens or []
        self._body = figure()
        self.at(0.0)

    def at(self, t_s: float) -> ScriptedView:
        self.time_s = t_s
        states = [script.joints(t_s, self._body) for script in self.scripts]
        self.joints_m = np.stack([joints for joints, _ in states])
        self.yaw_rad = np.array([heading for _, heading in states])
        return self

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


def client(
    seed: int = 0,
    group: int = 3,
    sensors: SensorConfig | None = None,
    joint_noise: JointNoiseConfig | None = None,
    clock: DeviceClock | None = None,
    mount: Mount = NORTH,
    **options: float,
) -> SensorClient:
    sensors = sensors or SensorConfig()
    sensing = JointSensing(
        mount,
        SessionConfig(sensors=sensors, joint_noise=joint_noise or JointNoiseConfig(), dancers=group, sensing="joints"),
        stream(seed, "sensors", mount.name),
    )
    return SensorClient(mount, sensing, DetectorConfig(), sensors, clock or DeviceClock(), **options)


def watch(
    view: ScriptedView, until_s: float, watcher: SensorClient | None = None, from_s: float = 0.0
) -> list[DeviceEvent]:
    """Let a client watch a scripted view; its events, persons replaced by the dancers' indices."""
    watcher = watcher or client(group=len(view.scripts))
    watcher.handle_message(from_s, ClientOrder(watcher.name, True), from_s)
    messages: list[object] = []
    for tick in range(round(from_s * FRAME_HZ), round(until_s * FRAME_HZ)):
        watcher.capture_frame(tick / FRAME_HZ, view.at(tick / FRAME_HZ))
        messages += watcher.pop_messages(tick / FRAME_HZ)
    return [message for message in messages if isinstance(message, DeviceEvent)]


def dancers(watcher: SensorClient) -> list[int]:
    """Which dancer is behind each person (for tests only)."""
    return watcher._source.dancers.tolist()  # type: ignore[attr-defined]


def match(
    detected: list[tuple[float, Kind]], true: list[tuple[float, Kind]], before_s: float, after_s: float
) -> tuple[dict[Kind, list[float]], int, int]:
    """Match one to one within (true - before, true + after): delays by kind, missed, false."""
    delays: dict[Kind, list[float]] = {}
    left = sorted(detected)
    missed = 0
    for t_s, kind in sorted(true):
        found = next((d for d in left if d[1] is kind and -before_s <= d[0] - t_s <= after_s), None)
        if found is None:
            missed += 1
        else:
            left.remove(found)
            delays.setdefault(kind, []).append(found[0] - t_s)
    return delays, missed, len(left)
