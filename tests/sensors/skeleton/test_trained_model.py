"""The model's file: small, typed and consistent with its hash; any other file is refused with one clear message."""

from __future__ import annotations

import dataclasses
import json
from importlib import resources
from pathlib import Path

import numpy as np
import pytest

from sjasim.core.errors import SjasimError
from sjasim.sensors.skeleton.trained_model import SkeletonModel, default_model, load_model


def test_the_packages_model_is_small_and_records_its_origin():
    model = default_model()
    assert {"version", "seed", "recipe", "sha256"} <= set(model.about)
    assert model.about["sha256"] == model.digest()
    assert Path(str(resources.files("sjasim.assets") / "skeleton.npz")).stat().st_size <= 500_000


def test_a_saved_model_can_be_loaded_again(tmp_path: Path):
    default_model().save(tmp_path / "model.npz")
    again = load_model(tmp_path / "model.npz")
    assert again.digest() == default_model().digest()


def test_a_missing_or_truncated_file_is_refused(tmp_path: Path):
    with pytest.raises(SjasimError, match="cannot be read"):
        load_model(tmp_path / "none.npz")
    default_model().save(tmp_path / "model.npz")
    whole = (tmp_path / "model.npz").read_bytes()
    for length in (0, 100, len(whole) // 2, len(whole) - 10):
        (tmp_path / "cut.npz").write_bytes(whole[:length])
        with pytest.raises(SjasimError, match="skeleton model"):
            load_model(tmp_path / "cut.npz")


def changed_model(tmp_path: Path, **changes: object) -> Path:
    """Write the package's model with changed arrays or info, and the old hash; return its path."""
    model = default_model()
    path = tmp_path / "changed.npz"
    arrays = {field.name: getattr(model, field.name) for field in dataclasses.fields(SkeletonModel)}
    np.savez_compressed(path, **{**arrays, **changes})
    return path


def test_a_file_of_another_version_type_or_content_is_refused(tmp_path: Path):
    older = json.dumps({**default_model().about, "version": 0})
    with pytest.raises(SjasimError, match="version 0"):
        load_model(changed_model(tmp_path, info=np.array(older)))
    with pytest.raises(SjasimError, match="threshold has type float64"):
        load_model(changed_model(tmp_path, threshold=default_model().threshold.astype(float)))
    with pytest.raises(SjasimError, match="expected arrays for 25 joints"):
        load_model(changed_model(tmp_path, support=np.zeros(21, np.float32)))
    with pytest.raises(SjasimError, match="do not match the hash"):
        load_model(changed_model(tmp_path, support=np.zeros(25, np.float32)))
