"""Where and what is danced: the floor, the score, the dancers' builds, the physics."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ..core.errors import ConfigError
from .checks import one_of, within


@dataclass(frozen=True, slots=True)
class SceneConfig:
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
        within("room.side_m", self.side_m, 0.8, 4.0)
        within("room.turn_rad", self.turn_rad, -math.pi, math.pi)
        within("room.sensor_distance_m", self.sensor_distance_m, 1.0, 8.0)
        within("room.sensor_height_m", self.sensor_height_m, 0.2, 2.5)
        within("room.move_m", self.move_m, 0.1, 1.0)
        for slot in self.slots_m:
            if len(slot) != 2:
                raise ConfigError("room.slots_m", slot, "pairs of x and y")


@dataclass(frozen=True, slots=True)
class DanceConfig:
    """Which dance, how fast, and what precedes it.

    Attributes:
        name: a registered choreography or module:function.
        bpm: tempo of the music (iqbal2016: 118).
        tempo: how the tempo changes: beat of the song and factor of ``bpm`` from there on, changing evenly from each
            to the next; a factor that rises is an accelerando, one that falls a ritardando. Beat 0 is the song's
            first, the rehearsal's if there is one.
        pauses: beat of the song and seconds of silence before it.
        lead_in_s: silence before the music; clocks synchronise meanwhile.
        tail_s: how long the session goes on after the last beat.
        rehearsal: whether one humans-only iteration precedes the dance, as the methods' history.
    """

    name: str = "paper"
    bpm: float = 118.0
    tempo: tuple[tuple[float, float], ...] = ()
    pauses: tuple[tuple[float, float], ...] = ()
    lead_in_s: float = 4.0
    tail_s: float = 1.0
    rehearsal: bool = True

    def __post_init__(self) -> None:
        within("dance.bpm", self.bpm, 40.0, 220.0)
        for name, points, low, high in (("tempo", self.tempo, 0.5, 2.0), ("pauses", self.pauses, 0.0, 60.0)):
            for beat, value in points:
                within(f"dance.{name}", beat, 0.0, 1e4)
                within(f"dance.{name}", value, low, high)
            beats = [beat for beat, _ in points]
            if sorted(set(beats)) != beats:
                raise ConfigError(f"dance.{name}", points, "pairs whose beats rise")
        within("dance.lead_in_s", self.lead_in_s, 1.0, 60.0)
        within("dance.tail_s", self.tail_s, 0.0, 60.0)


@dataclass(frozen=True, slots=True)
class BodyConfig:
    """The dancers' builds and the tether.

    Attributes:
        model: ``sjasim`` (our own), ``cmu`` (dm_control's CMU humanoid; needs dm-control) or module:Class.
        stature_m: lowest and highest stature to draw from.
        mass_kg: lowest and highest mass to draw from.
        tether: ``weak`` (saturating) or ``none``: balance alone; physics and balance then run at 240 Hz, unless other
            rates are given than the 150 and 50 Hz of a tether, at which nobody stands alone.
        tether_force_n: most horizontal force of the tether, each axis.
        tether_torque_nm: most torque of the tether, each axis.
    """

    model: str = "sjasim"
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
        one_of("body.tether", self.tether, ("weak", "none"))
        within("body.tether_force_n", self.tether_force_n, 0.0, 200.0)
        within("body.tether_torque_nm", self.tether_torque_nm, 0.0, 200.0)


@dataclass(frozen=True, slots=True)
class PhysicsConfig:
    """Physics.

    Attributes:
        rate_hz: physics steps per second; 150 is a multiple of cameras', odometry's and balance's rates.
        balance_hz: rate of the balance controller and the joint targets.
        truth_hz: rate at which the true state is logged, or a little more: a whole number of balance's steps lies
            between two rows (without a tether 50 becomes 60).
    """

    rate_hz: int = 150
    balance_hz: int = 50
    truth_hz: int = 50

    def __post_init__(self) -> None:
        within("stage.rate_hz", self.rate_hz, 120, 2000)
        within("stage.balance_hz", self.balance_hz, 20, self.rate_hz)
        within("stage.truth_hz", self.truth_hz, 10, self.rate_hz)
