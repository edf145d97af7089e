"""The protocol of body models, and the look-up of a body model by name."""

from __future__ import annotations

from typing import Protocol, cast

import mujoco

from ...config import BodyConfig
from ...core import Array
from ...core.registry import resolve
from .anatomy import Anatomy, Build


class BodyModel(Protocol):
    """A body that can perform motion planned for the 25 hinges of `assets.names.ACTUATED`.

    Attributes:
        hinges: names of the body's H hinges; each has a position servo of the same name.
        leading: (25,) for each planned hinge, the one of ``hinges`` whose servo moves it. The balance controller uses
            the gains of that servo.
    """

    hinges: tuple[str, ...]
    leading: tuple[str, ...]

    def anatomy(self, build: Build) -> Anatomy:
        """The tables with which motion is planned for a build; their ``chains()`` must match what `spec` returns."""
        ...

    def spec(self, anatomy: Anatomy, index: int, group: int, config: BodyConfig) -> mujoco.MjSpec:
        """The MuJoCo model of one dancer; `mjcf.dancer_spec` lists what it must contain.

        Args:
            anatomy: tables of the dancer's build.
            index: index of the dancer, from 0.
            group: number of dancers.
            config: limits of the balance support.
        """
        ...

    def angles(self, planned: Array) -> Array:
        """(D, H) angles of the body's hinges for planned angles (D, 25) [rad]."""
        ...


def body_model(name: str) -> BodyModel:
    """The body model of a registered name or of ``module:Class``.

    Raises:
        UnknownNameError: no body model has the name.
        PluginError: it cannot be imported, for example because an optional dependency is not installed.
    """
    return cast("BodyModel", resolve("body", name).factory())
