"""Which sessions a characterisation simulates."""

import pytest

from sjasim.config import SceneConfig, SessionConfig
from sjasim.core.errors import ConfigError
from sjasim.studies.characterisation import Design


def test_each_seed_is_simulated_with_every_layout_and_sensing():
    configs = Design(sessions=2).configs(SessionConfig(seed=5))
    assert [(one.sensing, one.layout, one.seed) for one in configs] == [
        (sensing, layout, seed) for sensing in ("joints", "depth") for layout in ("square", "rows") for seed in (5, 6)
    ]


def test_only_the_custom_layout_has_own_slots():
    common = SessionConfig(scene=SceneConfig(slots_m=((1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0))))
    configs = Design(sessions=2, layouts=("rows", "custom"), sensings=("joints",)).configs(common)
    assert [(one.layout, one.seed, len(one.scene.slots_m)) for one in configs] == [
        ("rows", 0, 0), ("rows", 1, 0), ("custom", 0, 4), ("custom", 1, 4),
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("design", "field"),
    [
        (Design(sessions=0), "sessions"),
        (Design(layouts=()), "layouts"),
        (Design(sensings=("joints", "joints")), "sensings"),
    ],
)
def test_a_design_without_sessions_is_refused(design, field):
    with pytest.raises(ConfigError) as caught:
        design.configs(SessionConfig())
    assert caught.value.field == field
