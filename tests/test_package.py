"""What importing the package does."""

import os

import pytest

import sjasim


@pytest.mark.parametrize("decorator", ["@njit(cache=True)", "@compiled_entry", "@compiled_inner"])
def test_compiled_functions_older_than_any_compiled_source_are_forgotten(tmp_path, decorator):
    def put(name, age_s, text=""):
        path = tmp_path / name
        path.write_text(text)
        os.utime(path, (1e9 - age_s, 1e9 - age_s))
        return path

    put("calls.py", 100, "@njit(cache=True)")
    put("called.py", 50, decorator)
    put("plain.py", 10)
    old, new = put("calls.f-1.py311.nbi", 60), put("called.g-1.py311.nbi", 40)
    sjasim._forget_stale(tmp_path, tmp_path / "absent")
    assert (old.exists(), new.exists()) == (False, True)
