"""Configuration: one frozen dataclass per room, all gathered in `SessionConfig`; to and from plain data and TOML.

Every value is checked when the object is made, so a wrong one stops a session before anything is written.
A default that no source supports says ``assumed``.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from .errors import ConfigError


def _within(name: str, value: float, low: float, high: float) -> None:
    if isinstance(value, bool) or not isinstance(value, int | float) or not low <= value <= high:
        raise ConfigError(name, value, f"a number from {low:g} to {high:g}")


def _one_of(name: str, value: str, allowed: tuple[str, ...]) -> None:
    if value not in allowed:
        raise ConfigError(name, value, f"one of {', '.join(allowed)}")


@dataclass(frozen=True, slots=True)
class RoomConfig:
    """Where people, robot and sensors stand.

    Attributes:
        side_m: side of the square of four slots (layout ``square``) or distance between rows and columns (``rows``).
        turn_rad: how far the square is turned; 31.5 degrees lets every cardinal sensor see all four bodies.
        slots_m: own slots for layout ``custom``: x, y of each dancer, then of the robot.
        sensor_distance_m: from the centre to each cardinal sensor.
        sensor_height_m: optical centre above the floor (iqbal2016: .91 m).
        move_m: nominal length of a forward or backward move.
    """

    side_m: float = 1.40
    turn_rad: float = math.radians(31.5)
    slots_m: tuple[tuple[float, float], ...] = ()
    sensor_distance_m: float = 3.40
    sensor_height_m: float = 0.91
    move_m: float = 0.50

    def __post_init__(self) -> None:
        _within("room.side_m", self.side_m, 0.8, 4.0)
        _within("room.turn_rad", self.turn_rad, -math.pi, math.pi)
        _within("room.sensor_distance_m", self.sensor_distance_m, 1.0, 8.0)
        _within("room.sensor_height_m", self.sensor_height_m, 0.2, 2.5)
        _within("room.move_m", self.move_m, 0.1, 1.0)
        for slot in self.slots_m:
            if len(slot) != 2:
                raise ConfigError("room.slots_m", slot, "pairs of x and y")


@dataclass(frozen=True, slots=True)
class DanceConfig:
    """Which dance, how fast, and what precedes it.

    Attributes:
        name: a registered choreography or module:function.
        bpm: tempo of the music (iqbal2016: 118).
        lead_in_s: silence before the music; clocks synchronise meanwhile.
        tail_s: how long the session goes on after the last beat.
        rehearsal: whether one humans-only iteration precedes the dance, as the methods' history.
    """

    name: str = "paper"
    bpm: float = 118.0
    lead_in_s: float = 4.0
    tail_s: float = 1.0
    rehearsal: bool = True

    def __post_init__(self) -> None:
        _within("dance.bpm", self.bpm, 40.0, 220.0)
        _within("dance.lead_in_s", self.lead_in_s, 1.0, 60.0)
        _within("dance.tail_s", self.tail_s, 0.0, 60.0)


@dataclass(frozen=True, slots=True)
class BodyConfig:
    """The dancers' builds and the tether.

    Attributes:
        stature_m: lowest and highest stature to draw from.
        mass_kg: lowest and highest mass to draw from.
        tether: ``weak`` (saturating) or ``none``.
        tether_force_n: most horizontal force of the tether, each axis.
        tether_torque_nm: most torque of the tether, each axis.
    """

    stature_m: tuple[float, float] = (1.60, 1.85)
    mass_kg: tuple[float, float] = (58.0, 88.0)
    tether: str = "weak"
    tether_force_n: float = 42.0
    tether_torque_nm: float = 30.0

    def __post_init__(self) -> None:
        for name, (low, high), least, most in (
            ("body.stature_m", self.stature_m, 1.50, 1.95),
            ("body.mass_kg", self.mass_kg, 50.0, 100.0),
        ):
            if not least <= low <= high <= most:
                raise ConfigError(name, (low, high), f"two rising numbers from {least:g} to {most:g}")
        _one_of("body.tether", self.tether, ("weak", "none"))
        _within("body.tether_force_n", self.tether_force_n, 0.0, 200.0)
        _within("body.tether_torque_nm", self.tether_torque_nm, 0.0, 200.0)


@dataclass(frozen=True, slots=True)
class StageConfig:
    """Physics.

    Attributes:
        rate_hz: physics steps per second; a multiple of the 30 Hz frame rate.
        balance_hz: rate of the balance controller and the joint targets.
        truth_hz: rate at which the true state is logged.
    """

    rate_hz: int = 240
    balance_hz: int = 60
    truth_hz: int = 60

    def __post_init__(self) -> None:
        _within("stage.rate_hz", self.rate_hz, 120, 2000)
        _within("stage.balance_hz", self.balance_hz, 20, self.rate_hz)
        _within("stage.truth_hz", self.truth_hz, 10, self.rate_hz)


@dataclass(frozen=True, slots=True)
class RobotConfig:
    """A TurtleBot 2 on a Kobuki base.

    Attributes:
        track_m: distance between the wheels (Kobuki: .230 m).
        wheel_radius_m: (Kobuki: .035 m).
        mass_kg: of the whole robot (TurtleBot 2: 6.3 kg).
        max_speed_m_s: (TurtleBot 2: .65 m/s).
        max_yaw_rate_rad_s: (Kobuki: 180 degrees/s).
        ticks_per_rev: encoder ticks per turn of a wheel (Kobuki: 2578.33).
        odometry_hz: rate of encoders, gyro and wheel commands (Kobuki: 50 Hz).
        cruise_m_s: speed of a move unless the server needs another to return to the slot.
        turn_rate_rad_s: largest rate of a commanded turn; the gyro degrades above 110 degrees/s.
        acceleration_m_s2: limit of the velocity smoother.
        yaw_acceleration_rad_s2: the same for turning.
        dead_time_s: between arrival of a command and the first wheel command (real bases: .16-.22 s of lag in all).
        command_timeout_s: the base stops when nothing has been heard for so long.
        wheel_radius_error: relative error of the radius that odometry believes in.
        track_error: relative error of the track that odometry believes in.
        gyro_bias_rad_s: constant error of the gyro.
        gyro_noise_rad_s: standard deviation of one gyro sample.
    """

    track_m: float = 0.230
    wheel_radius_m: float = 0.035
    mass_kg: float = 6.3
    max_speed_m_s: float = 0.65
    max_yaw_rate_rad_s: float = math.pi
    ticks_per_rev: float = 2578.33
    odometry_hz: int = 50
    cruise_m_s: float = 0.25
    turn_rate_rad_s: float = 1.6
    acceleration_m_s2: float = 1.0
    yaw_acceleration_rad_s2: float = 3.5
    dead_time_s: float = 0.15
    command_timeout_s: float = 0.6
    wheel_radius_error: float = 0.0
    track_error: float = 0.0
    gyro_bias_rad_s: float = 0.0
    gyro_noise_rad_s: float = 0.0

    def __post_init__(self) -> None:
        _within("robot.track_m", self.track_m, 0.1, 1.0)
        _within("robot.wheel_radius_m", self.wheel_radius_m, 0.02, 0.2)
        _within("robot.mass_kg", self.mass_kg, 2.0, 60.0)
        _within("robot.max_speed_m_s", self.max_speed_m_s, 0.1, 2.0)
        _within("robot.max_yaw_rate_rad_s", self.max_yaw_rate_rad_s, 0.5, 10.0)
        _within("robot.ticks_per_rev", self.ticks_per_rev, 10.0, 1e6)
        _within("robot.odometry_hz", self.odometry_hz, 10, 200)
        _within("robot.cruise_m_s", self.cruise_m_s, 0.15, self.max_speed_m_s)
        _within("robot.turn_rate_rad_s", self.turn_rate_rad_s, 0.5, self.max_yaw_rate_rad_s)
        _within("robot.acceleration_m_s2", self.acceleration_m_s2, 0.1, 5.0)
        _within("robot.yaw_acceleration_rad_s2", self.yaw_acceleration_rad_s2, 0.5, 20.0)
        _within("robot.dead_time_s", self.dead_time_s, 0.0, 2.0)
        _within("robot.command_timeout_s", self.command_timeout_s, 0.1, 10.0)
        _within("robot.wheel_radius_error", self.wheel_radius_error, -0.1, 0.1)
        _within("robot.track_error", self.track_error, -0.1, 0.1)
        _within("robot.gyro_bias_rad_s", self.gyro_bias_rad_s, -0.1, 0.1)
        _within("robot.gyro_noise_rad_s", self.gyro_noise_rad_s, 0.0, 0.1)


@dataclass(frozen=True, slots=True)
class SensorConfig:
    """Four Kinect v2 sensors; their images under ``depth`` sensing, the error of their skeletons under ``joints``.

    Attributes:
        rate_hz: frame rate.
        status_hz: rate of client status reports; also the frame rate of a client that idles.
        latency_frames: frames between capture and the moment the client has processed it (Kinect v2: about 2).
        horizontal_fov_rad: field of view, 70.6 degrees.
        vertical_fov_rad: 60 degrees.
        min_range_m: nearest tracked person.
        max_range_m: farthest tracked person.
        frame_loss: probability that a frame is never delivered.
        width_px: columns of a depth image: 512 (512 x 424) or 256 (256 x 212).
        bias_m: standard deviation of a joint's constant error, per axis (measured on depth skeletons).
        drift_m: standard deviation of the slowly varying error of a tracked joint, per axis.
        drift_correlation: correlation of that error between frames; with ``drift_m`` gives .14 cm from frame to frame.
        hidden_factor: how much larger both errors are where the joint is inferred (measured: torso 2, hands 8).
        hidden_factor_hand: the same for elbows, wrists and hands.
    """

    rate_hz: int = 30
    status_hz: int = 5
    latency_frames: int = 2
    horizontal_fov_rad: float = math.radians(70.6)
    vertical_fov_rad: float = math.radians(60.0)
    min_range_m: float = 0.5
    max_range_m: float = 4.5
    frame_loss: float = 0.0
    width_px: int = 256
    bias_m: float = 0.008
    drift_m: float = 0.010
    drift_correlation: float = 0.99
    hidden_factor: float = 2.0
    hidden_factor_hand: float = 8.0

    def __post_init__(self) -> None:
        _within("sensors.rate_hz", self.rate_hz, 5, 120)
        _within("sensors.status_hz", self.status_hz, 1, self.rate_hz)
        _within("sensors.latency_frames", self.latency_frames, 0, 30)
        _within("sensors.horizontal_fov_rad", self.horizontal_fov_rad, 0.2, 3.0)
        _within("sensors.vertical_fov_rad", self.vertical_fov_rad, 0.2, 3.0)
        _within("sensors.min_range_m", self.min_range_m, 0.0, 2.0)
        _within("sensors.max_range_m", self.max_range_m, 2.0, 20.0)
        _within("sensors.frame_loss", self.frame_loss, 0.0, 0.9)
        if self.width_px not in (256, 512):
            raise ConfigError("sensors.width_px", self.width_px, "256 or 512")
        _within("sensors.bias_m", self.bias_m, 0.0, 0.2)
        _within("sensors.drift_m", self.drift_m, 0.0, 0.2)
        _within("sensors.drift_correlation", self.drift_correlation, 0.0, 0.9999)
        _within("sensors.hidden_factor", self.hidden_factor, 1.0, 50.0)
        _within("sensors.hidden_factor_hand", self.hidden_factor_hand, 1.0, 50.0)


@dataclass(frozen=True, slots=True)
class DetectorConfig:
    """Thresholds of the clients' event detectors; each says what a larger value does.

    Attributes:
        difference_frames: frames over which SpineBase's velocity is taken; more is smoother and later.
        on_m_s: speed that starts a move; higher starts later and misses slow moves.
        off_m_s: speed below which a move stops; higher stops earlier.
        min_move_s: shortest move; a stop cannot come earlier.
        min_hold_s: shortest hold; a start cannot come earlier after a stop.
        early_step_m: floor of a joint's displacement in one frame; at least 3.5 x the one-frame noise.
        early_joints: how many of SpineMid, both shoulders and Neck must exceed it.
        early_frames: for how many consecutive frames.
        early_rest_s: an early start is armed so long after the regular stop.
        early_move_share: an early stop is armed after this share of the same move's duration in the last iteration
            (assumed: iqbal2016 says only "half of the joint positions changed").
        clap_ratio: hand distance over shoulder distance below which a local minimum is a clap.
        clap_rest_s: shortest time between two claps.
    """

    difference_frames: int = 4
    on_m_s: float = 0.20
    off_m_s: float = 0.10
    min_move_s: float = 0.8
    min_hold_s: float = 0.15
    early_step_m: float = 0.005
    early_joints: int = 2
    early_frames: int = 2
    early_rest_s: float = 0.5
    early_move_share: float = 0.7
    clap_ratio: float = 0.6
    clap_rest_s: float = 1.0

    def __post_init__(self) -> None:
        _within("detectors.difference_frames", self.difference_frames, 1, 30)
        _within("detectors.on_m_s", self.on_m_s, 0.02, 1.0)
        _within("detectors.off_m_s", self.off_m_s, 0.01, self.on_m_s)
        _within("detectors.min_move_s", self.min_move_s, 0.0, 5.0)
        _within("detectors.min_hold_s", self.min_hold_s, 0.0, 5.0)
        _within("detectors.early_step_m", self.early_step_m, 0.0005, 0.1)
        _within("detectors.early_joints", self.early_joints, 1, 4)
        _within("detectors.early_frames", self.early_frames, 1, 30)
        _within("detectors.early_rest_s", self.early_rest_s, 0.0, 5.0)
        _within("detectors.early_move_share", self.early_move_share, 0.0, 1.5)
        _within("detectors.clap_ratio", self.clap_ratio, 0.1, 2.0)
        _within("detectors.clap_rest_s", self.clap_rest_s, 0.1, 10.0)


@dataclass(frozen=True, slots=True)
class NetworkConfig:
    """The local network between clients, server and robot.

    Attributes:
        latency_s: shortest one-way delay.
        jitter_s: mean of the exponential delay on top of it.
        loss: probability that a message never arrives.
        uplink_extra_s: additional delay from client to server only; an asymmetric link biases every clock exchange.
        sync_hz: clock exchanges per second and client.
        heartbeat_hz: how often the server repeats the robot's current command.
    """

    latency_s: float = 0.015
    jitter_s: float = 0.005
    loss: float = 0.001
    uplink_extra_s: float = 0.0
    sync_hz: int = 4
    heartbeat_hz: int = 5

    def __post_init__(self) -> None:
        _within("network.latency_s", self.latency_s, 0.0, 2.0)
        _within("network.jitter_s", self.jitter_s, 0.0, 2.0)
        _within("network.loss", self.loss, 0.0, 0.9)
        _within("network.uplink_extra_s", self.uplink_extra_s, 0.0, 1.0)
        _within("network.sync_hz", self.sync_hz, 1, 50)
        _within("network.heartbeat_hz", self.heartbeat_hz, 2, 50)


@dataclass(frozen=True, slots=True)
class ClockConfig:
    """The clients' clocks.

    Attributes:
        offset_s: largest initial offset against the server, drawn evenly to both sides.
        drift: largest relative rate error, drawn evenly to both sides (a PC's quartz: some 50e-6).
    """

    offset_s: float = 0.5
    drift: float = 50e-6

    def __post_init__(self) -> None:
        _within("clocks.offset_s", self.offset_s, 0.0, 3600.0)
        _within("clocks.drift", self.drift, 0.0, 1e-3)


@dataclass(frozen=True, slots=True)
class SynchronyConfig:
    """The synchrony measures.

    Attributes:
        tau_s: window of an event pair (iqbal2016: .25 s).
        one_to_one: match events one to one, which bounds Q by 1; the paper's own equation does not.
    """

    tau_s: float = 0.25
    one_to_one: bool = False

    def __post_init__(self) -> None:
        _within("synchrony.tau_s", self.tau_s, 0.001, 5.0)


FAULTS = {
    "dead_sensor": "sensor",
    "clock_jump": "sensor",
    "dancer_stops": "dancer",
    "dancer_late": "dancer",
    "robot_blocked": "robot",
    "dead_robot": "robot",
}
"""Kind of fault -> whom it hits."""


@dataclass(frozen=True, slots=True)
class FaultConfig:
    """Something that is made to go wrong.

    Attributes:
        kind: ``dead_sensor``, ``clock_jump``, ``dancer_stops``, ``dancer_late``, ``robot_blocked`` (its wheels do not
            turn) or ``dead_robot`` (it neither hears nor reports nor drives). Lost packets are ``network.loss``.
        target: a sensor (``north``...), a dancer (``dancer_1``...) or ``robot``.
        t_s: session time from which on.
        value: size: seconds of jump or lateness; unused otherwise.
    """

    kind: str
    target: str
    t_s: float = 0.0
    value: float = 0.0

    def __post_init__(self) -> None:
        _one_of("faults.kind", self.kind, tuple(FAULTS))
        _within("faults.t_s", self.t_s, 0.0, 1e5)
        _within("faults.value", self.value, -60.0, 60.0)


@dataclass(frozen=True, slots=True)
class SessionConfig:
    """One dance session, whole.

    Attributes:
        method: anticipation method: a registered name, module:Class, or ``none`` for humans only.
        humans: preset of the human timing model.
        fidelity: ``physics``.
        sensing: where skeletons come from: ``joints`` (the truth with errors) or ``depth`` (depth images).
        iterations: how many iterations are danced after the rehearsal.
        layout: ``square``, ``rows`` or ``custom``.
        seed: of everything random in the session.
        performance: names the take; "" gives every method a fresh performance by the same people.
        group: number of dancers.
        method_options: options of the method, by the names of its config's fields.
        faults: what is made to go wrong.
    """

    method: str = "sia"
    humans: str = "paper-entrainment"
    fidelity: str = "physics"
    sensing: str = "joints"
    iterations: int = 4
    layout: str = "square"
    seed: int = 0
    performance: str = ""
    group: int = 3
    method_options: Mapping[str, float | int | bool | str] = field(default_factory=dict)
    faults: tuple[FaultConfig, ...] = ()
    room: RoomConfig = RoomConfig()
    dance: DanceConfig = DanceConfig()
    body: BodyConfig = BodyConfig()
    stage: StageConfig = StageConfig()
    robot: RobotConfig = RobotConfig()
    sensors: SensorConfig = SensorConfig()
    detectors: DetectorConfig = DetectorConfig()
    network: NetworkConfig = NetworkConfig()
    clocks: ClockConfig = ClockConfig()
    synchrony: SynchronyConfig = SynchronyConfig()

    def __post_init__(self) -> None:
        _one_of("fidelity", self.fidelity, ("physics",))
        _one_of("layout", self.layout, ("square", "rows", "custom"))
        _within("iterations", self.iterations, 1, 64)
        _within("seed", self.seed, 0, 2**63 - 1)
        _within("group", self.group, 1, 8)
        if isinstance(self.seed, float):
            raise ConfigError("seed", self.seed, "a whole number")
