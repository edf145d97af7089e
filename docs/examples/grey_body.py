"""A body in one file: the default body without colours, as for pictures in print.

python3 scripts/launch.py run --body.model grey_body:GreyBody
"""

import mujoco

from sjasim.config import BodyConfig
from sjasim.humans.body.anatomy import Anatomy
from sjasim.humans.body.mjcf import SjasimBody

GREY = (0.6, 0.6, 0.6, 1.0)


class GreyBody(SjasimBody):
    """Implements `BodyModel` on top of the default body, whose anatomy and hinges it keeps."""

    def spec(self, anatomy: Anatomy, index: int, group: int, config: BodyConfig) -> mujoco.MjSpec:
        """The MuJoCo model of one dancer, with every geom in grey."""
        spec = super().spec(anatomy, index, group, config)
        for geom in spec.geoms:
            geom.rgba = GREY
        return spec
