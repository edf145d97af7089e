"""The model's file: small, typed, true to its hash; anything else is refused in one clear line."""

from __future__ import annotations

import dataclasses
import json
from importlib import resources
from pathlib import Path

import numpy as np
import pytest

from sjasim.core.errors import SjasimError
from sjasim.sensors.skeleton.trained_model import SkeletonModel, default_model, load_model


def test_the_packages_model_is_small_and_says_where_it_comes_from():
    model = default_model()
    assert {"version", "seed", "recipe", "sha256"} <= set(model.about)
    assert model.about["sha256"] == model.digest()
    assert Path(str(resources.files("sjasim.assets") / "skeleton.npz")).stat().st_size <= 500_000


def test_a_saved_model_is_the_same(tmp_path: Path):
    default_model().save(tmp_path / "model.npz")
    again = load_model(tmp_path / "model.npz")
    assert again.digest() == default_model().digest()


def test_a_missing_or_broken_file_is_refused(tmp_path: Path):
    with pytest.raises(SjasimError, match="cannot be read"):
        load_model(tmp_path / "none.npz")
    default_model().save(tmp_path / "model.npz")
    whole = (tmp_path / "model.npz").read_bytes()
    for length in (0, 100, len(whole) // 2, len(whole) - 10):
        (tmp_path / "cut.npz").write_bytes(whole[:length])
        with pytest.raises(SjasimError, match="skeleton model"):
            load_model(tmp_path / "cut.npz")


def written(tmp_path: Path, **changes: object) -> Path:
    """The package's model with changed arrays or info, and the old hash."""
    model, path = default_model(), tmp_path / "changed.npz"
    arrays = {field.name: getattr(model, field.name) for field in dataclasses.fields(SkeletonModel)}
    np.savez_compressed(path, **{**arrays, **changes})
    return path


def test_another_version_type_or_content_is_refused(tmp_path: Path):
    older = json.dumps({**default_model().about, "version": 0})
    with pytest.raises(SjasimError, match="version 0"):
        load_model(written(tmp_path, info=np.array(older)))
    with pytest.raises(SjasimError, match="threshold is float64"):
        load_model(written(tmp_path, threshold=default_model().threshold.astype(float)))
    with pytest.raises(SjasimError, match="not for 25 joints"):
        load_model(written(tmp_path, support=np.zeros(21, np.float32)))
    with pytest.raises(SjasimError, match="not those it was written with"):
        load_model(written(tmp_path, support=np.zeros(25, np.float32)))
