"""Plug-ins by name or by module:Class."""

import sys
import types

import pytest

from sjasim.core import registry
from sjasim.core.errors import PluginError, UnknownNameError


@pytest.fixture
def outside(monkeypatch):
    """A module outside sjasim with a plug-in."""

    class Config:
        pass

    class Mine:
        config_type = Config

    module = types.ModuleType("somebody_elses")
    module.Mine, module.text = Mine, "text"
    monkeypatch.setitem(sys.modules, "somebody_elses", module)
    return module


def test_names_import_the_folder_and_are_sorted():
    found = registry.names("anticipation")
    assert {"sia", "eca"} <= set(found)
    assert list(found) == sorted(found)
    assert "paper" in registry.names("choreography")
    assert "joints" in registry.names("sensing")


def test_an_unknown_name_lists_what_is_known():
    with pytest.raises(UnknownNameError, match=r"eca.*sia"):
        registry.resolve("anticipation", "sai")


def test_a_plug_in_of_another_package_is_named_by_module_and_class(outside):
    entry = registry.resolve("anticipation", "somebody_elses:Mine")
    assert entry.factory is outside.Mine
    assert entry.config is outside.Mine.config_type


def test_a_registered_class_named_by_its_module_keeps_its_config():
    entry = registry.resolve("anticipation", "sia")
    named = f"{entry.factory.__module__}:{entry.factory.__qualname__}"
    assert registry.resolve("anticipation", named) == entry


@pytest.mark.parametrize("name", ["no_such_module:X", "somebody_elses:Nothing", "somebody_elses:text"])
def test_an_absent_module_or_class_is_named(outside, name):
    with pytest.raises(PluginError, match=name.partition(":")[0]):
        registry.resolve("anticipation", name)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("def f(:", r"invalid syntax \(broken_one.py, line 1\)"),
        ("x = 1\nimport not_installed_here", r"ModuleNotFoundError: .*'not_installed_here' at .*broken_one.py, line 2"),
        ("x = 1\n\ny = z", r"NameError: .*'z' is not defined at .*broken_one.py, line 3"),
    ],
)
def test_a_module_that_cannot_be_imported_says_where_it_breaks(tmp_path, monkeypatch, text, says):
    (tmp_path / "broken_one.py").write_text(text)
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(PluginError, match=says):
        registry.resolve("anticipation", "broken_one:Method")


def test_a_name_is_taken_once_and_kinds_are_fixed():
    with pytest.raises(PluginError, match="registered already"):
        registry.register("anticipation", "sia")(dict)
    with pytest.raises(PluginError, match="no kind"):
        registry.register("weather", "rain")
