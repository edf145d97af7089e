"""The TurtleBot 2 as a MuJoCo model: a Kobuki base, three plates on poles, a laptop and a sensor bar.

Sizes are public figures of the Kobuki (diameter 351.5 mm, height 124.8 mm) and the TurtleBot 2 (height 420 mm, 6.3 kg).
How the mass is distributed over the parts is assumed. Wheels are ellipsoids, which touch the floor in one point and
therefore turn without scrubbing; casters are spheres without friction.

The model of a second robot would stand beside this one, as another function that returns what `robot_spec` describes.
"""

from __future__ import annotations

import mujoco

from ..assets.names import FLOOR_BIT, ROBOT_BIT, dancer_bit
from ..config import RobotConfig
from ..config.session import MAX_DANCERS

Colour = tuple[float, float, float, float]
"""Red, green, blue and opacity, 0 to 1."""

_COLLIDES_WITH = FLOOR_BIT | sum(dancer_bit(index) for index in range(MAX_DANCERS))
_BLACK: Colour = (0.13, 0.13, 0.15, 1.0)
_GREY: Colour = (0.32, 0.33, 0.37, 1.0)
_SILVER: Colour = (0.70, 0.71, 0.73, 1.0)
_AMBER: Colour = (0.94, 0.66, 0.05, 1.0)

_HULL_SOLREF = (0.04, 1.0)
"""Soft contact of a bumper and light plates: a leg meets hundreds of newtons, not thousands (assumed)."""

_HULL_FRICTION = (0.5, 0.005, 0.0001)
"""Friction of smooth plastic (assumed)."""

_FLOOR_SOLIMP = (0.99, 0.999, 0.0005, 0.5, 2.0)
"""Hard contact with the floor: a softer wheel sinks in and rolls on a smaller radius."""

_WHEEL_FRICTION = (1.0, 0.005, 0.0001)
"""Friction of rubber (assumed)."""

_WHEEL_HALF_WIDTH_M = 0.0105

_WHEEL_TORQUE_NM = 0.5
"""Torque limit of a wheel, 28 N of thrust with both: the wheels stall against a leg before they slip (assumed)."""

_WHEEL_KV = 0.5
"""Gain of the velocity servo [Nm s/rad]. The wheel responds within 8 ms; with a much higher gain, torque limit and time
step make a limit cycle."""

_ROTOR_INERTIA = 0.002
"""Inertia of a motor behind its gear of 49.6 [kg m^2] (assumed)."""

_CASTER_RADIUS_M = 0.016

_CASTER_GAP_M = 0.0005
"""Height of the casters above the floor. It stands for the springs of the wheels, which carry nearly all weight."""

_CASTERS_X_M = (0.115, -0.135)

_HOUSING_RADIUS_M = 0.17575
_HOUSING_Z_M = (0.015, 0.1248)
"""Bottom and top of the Kobuki's housing."""

_PLATE_RADIUS_M = 0.16
_PLATE_HALF_M = 0.003
_PLATES_Z_M = (0.140, 0.200, 0.417)
_POLES_XY_M = ((0.10, 0.09), (0.10, -0.09), (-0.10, 0.09), (-0.10, -0.09))

_NOMINAL_KG = 6.3
"""Mass of the whole robot with the following masses of its parts."""

_HOUSING_KG = 2.13
"""With wheels and casters the Kobuki has its 2.35 kg."""

_WHEEL_KG = 0.10
_CASTER_KG = 0.01
_PLATE_KG = 0.57
_POLES_KG = (0.02, 0.02, 0.08)
"""Mass of each of the four poles under the first, second and third plate."""

_LAPTOP_KG = 1.51
_BAR_KG = 0.25


def robot_spec(config: RobotConfig) -> mujoco.MjSpec:
    """The MuJoCo model of the robot, which the scene attaches at the robot's slot under a prefix.

    It has the body ``base`` with the free joint ``root`` (its origin on the floor between the wheels, x forward), the
    hinges ``wheel_l`` and ``wheel_r`` (positive when rolling forward), velocity actuators of the same names [rad/s],
    and the sensor ``gyro`` on the site ``base``. Its geoms collide with the floor and the dancers only.

    Args:
        config: wheel separation, wheel radius, and the mass to which all parts are scaled.
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
    """Add housing, bumper and casters of the Kobuki."""
    low, high = _HOUSING_Z_M
    size = [_HOUSING_RADIUS_M, (high - low) / 2, 0.0]
    place = (0.0, 0.0, (low + high) / 2)
    _add_hull(base, "housing", shape="CYLINDER", size=size, place=place, mass=_HOUSING_KG * scale, rgba=_BLACK)

    # The bumper is visible only; the housing makes its contacts.
    base.add_geom(
        name="bumper",
        type=mujoco.mjtGeom.mjGEOM_CYLINDER,
        size=[_HOUSING_RADIUS_M + 0.001, 0.014, 0.0],
        pos=[0.0, 0.0, 0.058],
        mass=0.0,
        contype=0,
        conaffinity=0,
        rgba=_AMBER,
    )

    for name, x in zip(("caster_f", "caster_b"), _CASTERS_X_M, strict=True):
        base.add_geom(
            name=name,
            type=mujoco.mjtGeom.mjGEOM_SPHERE,
            size=[_CASTER_RADIUS_M, 0.0, 0.0],
            pos=[x, 0.0, _CASTER_RADIUS_M + _CASTER_GAP_M],
            mass=_CASTER_KG * scale,
            condim=1,
            priority=1,
            solimp=_FLOOR_SOLIMP,
            contype=ROBOT_BIT,
            conaffinity=_COLLIDES_WITH,
            rgba=_GREY,
        )


def _add_superstructure(base: mujoco.MjsBody, scale: float) -> None:
    """Add plates, poles, laptop and sensor bar."""
    bottom = _HOUSING_Z_M[1]
    for level, top in enumerate(_PLATES_Z_M):
        size = [_PLATE_RADIUS_M, _PLATE_HALF_M, 0.0]
        mass = _PLATE_KG * scale
        name = f"plate_{level + 1}"
        _add_hull(base, name, shape="CYLINDER", size=size, place=(0.0, 0.0, top), mass=mass, rgba=_BLACK)

        half = (top - _PLATE_HALF_M - bottom) / 2
        for corner, (x, y) in enumerate(_POLES_XY_M):
            name = f"pole_{level + 1}{corner + 1}"
            place = (x, y, bottom + half)
            mass = _POLES_KG[level] * scale
            _add_hull(base, name, shape="CYLINDER", size=[0.006, half, 0.0], place=place, mass=mass, rgba=_SILVER)
        bottom = top + _PLATE_HALF_M

    mass = _LAPTOP_KG * scale
    _add_hull(base, "laptop", shape="BOX", size=[0.12, 0.09, 0.012], place=(-0.01, 0.0, 0.215), mass=mass, rgba=_GREY)

    mass = _BAR_KG * scale
    size = [0.024, 0.09, 0.016]
    _add_hull(base, "sensor_bar", shape="BOX", size=size, place=(-0.087, 0.0, 0.309), mass=mass, rgba=_BLACK)


def _add_hull(
    base: mujoco.MjsBody,
    name: str,
    *,
    shape: str,
    size: list[float],
    place: tuple[float, float, float],
    mass: float,
    rgba: Colour,
) -> None:
    """Add a part that a dancer may walk into; its soft contact has priority over the dancer's."""
    base.add_geom(
        name=name,
        type=getattr(mujoco.mjtGeom, f"mjGEOM_{shape}"),
        size=size,
        pos=place,
        mass=mass,
        rgba=rgba,
        contype=ROBOT_BIT,
        conaffinity=_COLLIDES_WITH,
        condim=3,
        priority=1,
        solref=_HULL_SOLREF,
        friction=_HULL_FRICTION,
    )


def _add_wheel(spec: mujoco.MjSpec, base: mujoco.MjsBody, side: float, config: RobotConfig) -> None:
    """Add a driven wheel and its motor; ``side`` is +1 on the left, -1 on the right."""
    name = "wheel_l" if side > 0 else "wheel_r"
    radius = config.wheel_radius_m

    wheel = base.add_body(name=name, pos=[0.0, side * config.wheel_separation_m / 2, radius])
    wheel.add_joint(
        name=name, type=mujoco.mjtJoint.mjJNT_HINGE, axis=[0.0, 1.0, 0.0], armature=_ROTOR_INERTIA, damping=0.0
    )
    wheel.add_geom(
        name=name,
        type=mujoco.mjtGeom.mjGEOM_ELLIPSOID,
        size=[radius, _WHEEL_HALF_WIDTH_M, radius],
        mass=_WHEEL_KG * config.mass_kg / _NOMINAL_KG,
        contype=ROBOT_BIT,
        conaffinity=_COLLIDES_WITH,
        condim=3,
        priority=1,
        friction=_WHEEL_FRICTION,
        solimp=_FLOOR_SOLIMP,
        rgba=_GREY,
    )

    motor = spec.add_actuator(name=name, target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
    motor.set_to_velocity(kv=_WHEEL_KV)
    motor.forcelimited = True
    motor.forcerange = [-_WHEEL_TORQUE_NM, _WHEEL_TORQUE_NM]
