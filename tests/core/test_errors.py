"""Errors keep their message when they cross processes, as those of a study's workers do."""

from __future__ import annotations

import pickle

import pytest

from sjasim.commands.options import UsageError
from sjasim.core.errors import ConfigError, HookError, PluginError, RecordError, SjasimError, UnknownNameError

ERRORS = (
    ConfigError("seed", -1, "at least 0"),
    UnknownNameError("method", "siaa", ("eca", "sia")),
    RecordError("disk full"),
    PluginError("lacks decide"),
    HookError("sia.on_event failed"),
    UsageError("--seed needs a value"),
)


@pytest.mark.parametrize("error", ERRORS, ids=lambda error: type(error).__name__)
def test_an_error_is_the_same_after_pickling(error: SjasimError):
    copy = pickle.loads(pickle.dumps(error))
    assert type(copy) is type(error)
    assert str(copy) == str(error)
    assert vars(copy) == vars(error)
