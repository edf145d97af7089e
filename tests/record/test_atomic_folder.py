"""Folders appear complete or not at all, and impossible targets are refused before any computation."""

import pytest

from sjasim.core.errors import RecordError
from sjasim.record import atomic_folder


@pytest.mark.parametrize("place", ["file", "file/below", "/proc/nowhere/x"])
def test_impossible_targets_are_refused_before_anything_is_written(place, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(RecordError) as caught:
        atomic_folder.check_target(tmp_path / place)
    assert "\n" not in str(caught.value)
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


def test_the_check_leaves_nothing_on_disk(tmp_path):
    assert atomic_folder.check_target(tmp_path / "a" / "b") == tmp_path / "a" / "b"
    assert list(tmp_path.iterdir()) == []


def test_a_folder_appears_once_everything_is_written(tmp_path):
    target = tmp_path / "a" / "b"
    with atomic_folder.atomic_folder(target) as draft:
        (draft / "x").write_text("1")
        assert not target.exists()
    assert [path.name for path in target.iterdir()] == ["x"]
    assert [path.name for path in target.parent.iterdir()] == ["b"]


def test_a_failure_keeps_the_earlier_folder(tmp_path):
    (tmp_path / "b").mkdir()
    (tmp_path / "b" / "x").write_text("old")

    def fill():
        with atomic_folder.atomic_folder(tmp_path / "b", overwrite=True) as draft:
            (draft / "x").write_text("new")
            raise OSError(28, "No space left on device")

    with pytest.raises(RecordError, match="No space left"):
        fill()
    assert (tmp_path / "b" / "x").read_text() == "old"
    assert [path.name for path in tmp_path.iterdir()] == ["b"]


@pytest.mark.parametrize("before", [False, True])
def test_of_two_concurrent_runs_the_second_keeps_the_result_of_the_first(tmp_path, before):
    target = tmp_path / "b"
    if before:
        target.mkdir()

    def fill():
        with atomic_folder.atomic_folder(atomic_folder.check_target(target)) as second:
            (second / "x").write_text("second")
            with atomic_folder.atomic_folder(atomic_folder.check_target(target)) as first:
                (first / "x").write_text("first")

    with pytest.raises(RecordError, match=r"b has been filled by another run meanwhile: .*--overwrite"):
        fill()
    assert (target / "x").read_text() == "first"
    assert [path.name for path in tmp_path.iterdir()] == ["b"]


def test_the_earlier_folder_is_restored_if_the_draft_cannot_be_renamed(tmp_path, monkeypatch):
    target = tmp_path / "b"
    target.mkdir()
    (target / "x").write_text("old")
    with atomic_folder.atomic_folder(target, overwrite=True) as draft:
        (draft / "x").write_text("new")
    assert (target / "x").read_text() == "new"
    rename = atomic_folder.os.replace
    calls = []

    def failing(source, place):
        calls.append(place)
        # Call 1 moves the earlier folder away, call 2 the draft to the target, call 3 the earlier folder back.
        if len(calls) == 2:
            raise OSError(5, "Input/output error")
        rename(source, place)

    monkeypatch.setattr(atomic_folder.os, "replace", failing)
    with pytest.raises(RecordError, match="Input/output error"), atomic_folder.atomic_folder(target, overwrite=True):
        pass
    assert (target / "x").read_text() == "new"
    assert [path.name for path in tmp_path.iterdir()] == ["b"]


def test_only_a_result_of_the_same_kind_is_replaced(tmp_path):
    (tmp_path / "x").write_text("")
    with pytest.raises(RecordError, match="not empty"):
        atomic_folder.check_target(tmp_path, holds="x")
    assert atomic_folder.check_target(tmp_path, overwrite=True, holds="x") == tmp_path
    with pytest.raises(RecordError, match="something else than y"):
        atomic_folder.check_target(tmp_path, overwrite=True, holds="y")
