"""The MuJoCo model of a whole scene: floor, light, dancers and robot."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco

from ..assets.names import FLOOR_BIT, ROBOT_PREFIX, dancer_prefix
from ..choreography.layout import Layout
from ..config import BodyConfig, RobotConfig
from ..humans.body.anatomy import Anatomy
from ..humans.body.body_model import body_model
from ..robot.mjcf import robot_spec

FLOOR_COLOURS = ((0.74, 0.72, 0.69), (0.66, 0.64, 0.61))
"""Colours of the checkered floor."""

SKY_COLOURS = ((0.80, 0.86, 0.92), (0.97, 0.97, 0.96))
"""Colours of the sky at the zenith and at the horizon."""


def scene_spec(
    anatomies: Sequence[Anatomy], layout: Layout, body: BodyConfig, robot: RobotConfig | None, rate_hz: int
) -> mujoco.MjSpec:
    """Build the model of the whole scene.

    Args:
        anatomies: one for each dancer.
        layout: places of dancers and robot.
        body: body model and balance support of the dancers.
        robot: parameters of the robot, or None for a scene without one.
        rate_hz: physics steps per second.

    Returns:
        a specification that is not compiled yet.
    """
    spec = mujoco.MjSpec()
    spec.option.timestep = 1.0 / rate_hz
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.solver = mujoco.mjtSolver.mjSOL_NEWTON
    spec.option.cone = mujoco.mjtCone.mjCONE_PYRAMIDAL
    _set_visual_options(spec)
    _add_textures(spec)
    spec.worldbody.add_light(
        pos=[3, 1.5, 8],
        dir=[-0.4, -0.2, -1],
        type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL,
        diffuse=[0.5] * 3,
        specular=[0.1] * 3,
    )

    spec.worldbody.add_geom(
        name="floor",
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        size=[0, 0, 0.1],
        material="floor",
        contype=FLOOR_BIT,
        conaffinity=0,
        friction=[1.0, 0.005, 0.0001],
    )

    for index, anatomy in enumerate(anatomies):
        dancer = body_model(body.model).spec(anatomy, index, len(anatomies), body)
        spec.attach(dancer, prefix=dancer_prefix(index), frame=spec.worldbody.add_frame())

    if robot is not None:
        frame = spec.worldbody.add_frame(pos=[*layout.robot, 0.0])
        spec.attach(robot_spec(robot), prefix=ROBOT_PREFIX, frame=frame)
    return spec


def _set_visual_options(spec: mujoco.MjSpec) -> None:
    """Set what only pictures show: image buffers, headlight, shadows and haze."""
    spec.visual.global_.offwidth = 1280
    spec.visual.global_.offheight = 960
    spec.visual.headlight.ambient = [0.45] * 3
    spec.visual.headlight.diffuse = [0.30] * 3
    spec.visual.headlight.specular = [0.0] * 3
    spec.visual.quality.shadowsize = 4096
    spec.visual.rgba.haze = [*SKY_COLOURS[1], 1.0]
    spec.visual.map.haze = 0.5

    # Centre and extent set the area that casts shadows and the distance of the far clipping plane.
    spec.stat.center = [0.0, 0.0, 0.8]
    spec.stat.extent = 6.0


def _add_textures(spec: mujoco.MjSpec) -> None:
    """Add the sky and the material of the floor; the physics and the depth sensors ignore both."""
    spec.add_texture(
        name="sky",
        type=mujoco.mjtTexture.mjTEXTURE_SKYBOX,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_GRADIENT,
        width=128,
        height=768,
        rgb1=SKY_COLOURS[0],
        rgb2=SKY_COLOURS[1],
    )

    spec.add_texture(
        name="floor",
        type=mujoco.mjtTexture.mjTEXTURE_2D,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_CHECKER,
        width=256,
        height=256,
        rgb1=FLOOR_COLOURS[0],
        rgb2=FLOOR_COLOURS[1],
    )
    material = spec.add_material(name="floor", texrepeat=[0.5, 0.5], texuniform=True)
    material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = "floor"
