"""The TurtleBot 2 as a part of the MuJoCo model: a Kobuki base, three plates on poles, laptop and sensor bar.

Sizes are public figures of the Kobuki (diameter 351.5 mm, height 124.8 mm) and the TurtleBot 2 (height 420 mm,
6.3 kg); how the mass is shared between the parts is assumed. Wheels are ellipsoids, which touch the floor in one
point and so turn without scrubbing; casters are spheres without friction.
"""

from __future__ import annotations

import mujoco

from ..assets.names import FLOOR_BIT, ROBOT_BIT, dancer_bit
from ..config import RobotConfig

_MEETS = FLOOR_BIT | sum(dancer_bit(index) for index in range(8))
_BLACK, _GREY, _SILVER = (0.13, 0.13, 0.15, 1.0), (0.32, 0.33, 0.37, 1.0), (0.70, 0.71, 0.73, 1.0)
_AMBER = (0.94, 0.66, 0.05, 1.0)

_SHELL_SOLREF = (0.04, 1.0)  # a bumper and light plates: a leg meets hundreds of newtons, not thousands; assumed
_SHELL_FRICTION = (0.5, 0.005, 0.0001)  # smooth plastic; assumed
_FLOOR_SOLIMP = (0.99, 0.999, 0.0005, 0.5, 2.0)  # hard: a softer wheel sinks in and rolls on a smaller radius
_WHEEL_FRICTION = (1.0, 0.005, 0.0001)  # rubber; assumed
_WHEEL_HALF_WIDTH_M = 0.0105
_WHEEL_TORQUE_NM = 0.5  # 28 N of thrust: the wheels stall against a leg before they slip; assumed
_WHEEL_KV = 0.5  # Nm s/rad: answers in 8 ms; much stiffer, and torque limit and time step make a limit cycle
_ROTOR_INERTIA = 0.002  # kg m^2 behind the gear of 49.6; assumed
_CASTER_RADIUS_M, _CASTER_GAP_M = 0.016, 0.0005  # the gap stands for the wheels' springs: they carry nearly all
_CASTERS_X_M = (0.115, -0.135)

_SHELL_RADIUS_M, _SHELL_Z_M = 0.17575, (0.015, 0.1248)
_PLATE_RADIUS_M, _PLATE_HALF_M, _PLATES_Z_M = 0.16, 0.003, (0.140, 0.200, 0.417)
_POLES_XY_M = ((0.10, 0.09), (0.10, -0.09), (-0.10, 0.09), (-0.10, -0.09))

_NOMINAL_KG = 6.3
_SHELL_KG, _WHEEL_KG, _CASTER_KG = 2.13, 0.10, 0.01  # with the Kobuki's 2.35 kg in all
_PLATE_KG, _POLES_KG, _LAPTOP_KG, _BAR_KG = 0.57, (0.02, 0.02, 0.08), 1.51, 0.25


def robot_spec(config: RobotConfig) -> mujoco.MjSpec:
    """The robot as a spec that a stage attaches at the robot's slot, with a prefix.

    It holds body ``base`` with free joint ``root`` (its origin on the floor between the wheels, x forward), hinges
    ``wheel_l`` and ``wheel_r`` (turning forward is positive), velocity actuators of the same names [rad/s], and
    sensor ``gyro`` on site ``base``. Its geoms meet the floor and the dancers, never one another.

    Args:
        config: track, wheel radius, and the mass that all parts are scaled to.
    """
    spec = mujoco.MjSpec()
    spec.modelname = "turtlebot2"
    scale = config.mass_kg / _NOMINAL_KG
    base = spec.worldbody.add_body(name="base")
    base.add_freejoint(name="root")
    base.add_site(name="base")
    _add_base(base, scale)
    _add_superstructure(base, scale)
    _add_wheel(spec, base, 1.0, config)
    _add_wheel(spec, base, -1.0, config)
    spec.add_sensor(name="gyro", type=mujoco.mjtSensor.mjSENS_GYRO, objtype=mujoco.mjtObj.mjOBJ_SITE, objname="base")
    return spec


def _add_base(base: mujoco.MjsBody, scale: float) -> None:
    low, high = _SHELL_Z_M
    size = [_SHELL_RADIUS_M, (high - low) / 2, 0.0]
    place = (0.0, 0.0, (low + high) / 2)
    _add_hull(base, "shell", shape="CYLINDER", size=size, place=place, mass=_SHELL_KG * scale, rgba=_BLACK)
    base.add_geom(  # the bumper, for the eye only
        name="bumper", type=mujoco.mjtGeom.mjGEOM_CYLINDER, size=[_SHELL_RADIUS_M + 0.001, 0.014, 0.0],
        pos=[0.0, 0.0, 0.058], mass=0.0, contype=0, conaffinity=0, rgba=_AMBER,
    )  # fmt: skip
    for name, x in zip(("caster_f", "caster_b"), _CASTERS_X_M, strict=True):
        base.add_geom(
            name=name, type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[_CASTER_RADIUS_M, 0.0, 0.0],
            pos=[x, 0.0, _CASTER_RADIUS_M + _CASTER_GAP_M], mass=_CASTER_KG * scale, condim=1, priority=1,
            solimp=_FLOOR_SOLIMP, contype=ROBOT_BIT, conaffinity=_MEETS, rgba=_GREY,
        )  # fmt: skip


def _add_superstructure(base: mujoco.MjsBody, scale: float) -> None:
    """Plates, poles, laptop and bar: what stands on the Kobuki."""
    bottom = _SHELL_Z_M[1]
    for level, top in enumerate(_PLATES_Z_M):
        _add_hull(
            base, f"plate_{level + 1}", shape="CYLINDER", size=[_PLATE_RADIUS_M, _PLATE_HALF_M, 0.0],
            place=(0.0, 0.0, top), mass=_PLATE_KG * scale, rgba=_BLACK,
        )  # fmt: skip
        half = (top - _PLATE_HALF_M - bottom) / 2
        for corner, (x, y) in enumerate(_POLES_XY_M):
            _add_hull(
                base, f"pole_{level + 1}{corner + 1}", shape="CYLINDER", size=[0.006, half, 0.0],
                place=(x, y, bottom + half), mass=_POLES_KG[level] * scale, rgba=_SILVER,
            )  # fmt: skip
        bottom = top + _PLATE_HALF_M
    _add_hull(
        base, "laptop", shape="BOX", size=[0.12, 0.09, 0.012], place=(-0.01, 0.0, 0.215),
        mass=_LAPTOP_KG * scale, rgba=_GREY,
    )  # fmt: skip
    _add_hull(
        base, "sensor_bar", shape="BOX", size=[0.024, 0.09, 0.016], place=(-0.087, 0.0, 0.309),
        mass=_BAR_KG * scale, rgba=_BLACK,
    )  # fmt: skip


def _add_hull(
    base: mujoco.MjsBody,
    name: str,
    *,
    shape: str,
    size: list[float],
    place: tuple[float, float, float],
    mass: float,
    rgba: tuple[float, float, float, float],
) -> None:
    """A part that a dancer may walk into; its own soft contact wins over the dancer's (priority)."""
    base.add_geom(
        name=name, type=getattr(mujoco.mjtGeom, f"mjGEOM_{shape}"), size=size, pos=place, mass=mass, rgba=rgba,
        contype=ROBOT_BIT, conaffinity=_MEETS, condim=3, priority=1, solref=_SHELL_SOLREF, friction=_SHELL_FRICTION,
    )  # fmt: skip


def _add_wheel(spec: mujoco.MjSpec, base: mujoco.MjsBody, side: float, config: RobotConfig) -> None:
    """A driven wheel and its motor; side is +1 on the left, -1 on the right."""
    name = "wheel_l" if side > 0 else "wheel_r"
    radius = config.wheel_radius_m
    wheel = base.add_body(name=name, pos=[0.0, side * config.wheel_separation_m / 2, radius])
    wheel.add_joint(
        name=name, type=mujoco.mjtJoint.mjJNT_HINGE, axis=[0.0, 1.0, 0.0], armature=_ROTOR_INERTIA, damping=0.0
    )
    wheel.add_geom(
        name=name, type=mujoco.mjtGeom.mjGEOM_ELLIPSOID, size=[radius, _WHEEL_HALF_WIDTH_M, radius],
        mass=_WHEEL_KG * config.mass_kg / _NOMINAL_KG, contype=ROBOT_BIT, conaffinity=_MEETS, condim=3, priority=1,
        friction=_WHEEL_FRICTION, solimp=_FLOOR_SOLIMP, rgba=_GREY,
    )  # fmt: skip
    motor = spec.add_actuator(name=name, target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
    motor.set_to_velocity(kv=_WHEEL_KV)
    motor.forcelimited = True
    motor.forcerange = [-_WHEEL_TORQUE_NM, _WHEEL_TORQUE_NM]
