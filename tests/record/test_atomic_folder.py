"""Folders appear whole or not at all, and impossible places are refused before any work is done."""

import pytest

from sjasim.core.errors import RecordError
from sjasim.record import atomic_folder


@pytest.mark.parametrize("place", ["file", "file/below", "/proc/nowhere/x"])
def test_impossible_places_are_refused_before_anything_is_written(place, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(RecordError) as caught:
        atomic_folder.check_target(tmp_path / place)
    assert "\n" not in str(caught.value)
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


def test_checking_leaves_nothing(tmp_path):
    assert atomic_folder.check_target(tmp_path / "a" / "b") == tmp_path / "a" / "b"
    assert list(tmp_path.iterdir()) == []


def test_a_folder_appears_when_all_is_written(tmp_path):
    target = tmp_path / "a" / "b"
    with atomic_folder.atomic_folder(target) as draft:
        (draft / "x").write_text("1")
        assert not target.exists()
    assert [path.name for path in target.iterdir()] == ["x"]
    assert [path.name for path in target.parent.iterdir()] == ["b"]


def test_a_failure_leaves_what_was_there(tmp_path):
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
def test_of_two_runs_at_once_the_second_loses_nothing_of_the_first(tmp_path, before):
    target = tmp_path / "b"
    if before:
        target.mkdir()

    def fill():
        with atomic_folder.atomic_folder(atomic_folder.check_target(target)) as mine:
            (mine / "x").write_text("second")
            with atomic_folder.atomic_folder(atomic_folder.check_target(target)) as other:
                (other / "x").write_text("first")

    with pytest.raises(RecordError, match=r"b has been filled by another run meanwhile: .*--overwrite"):
        fill()
    assert (target / "x").read_text() == "first"
    assert [path.name for path in tmp_path.iterdir()] == ["b"]


def test_what_may_be_replaced_stands_until_the_new_one_does(tmp_path, monkeypatch):
    target = tmp_path / "b"
    target.mkdir()
    (target / "x").write_text("old")
    with atomic_folder.atomic_folder(target, overwrite=True) as draft:
        (draft / "x").write_text("new")
    assert (target / "x").read_text() == "new"
    real, moves = atomic_folder.os.replace, []

    def failing(source, place):
        moves.append(place)
        if len(moves) == 2:  # aside; the draft; back
            raise OSError(5, "Input/output error")
        real(source, place)

    monkeypatch.setattr(atomic_folder.os, "replace", failing)
    with pytest.raises(RecordError, match="Input/output error"), atomic_folder.atomic_folder(target, overwrite=True):
        pass
    assert (target / "x").read_text() == "new"
    assert [path.name for path in tmp_path.iterdir()] == ["b"]


def test_only_an_outcome_of_the_same_kind_is_replaced(tmp_path):
    (tmp_path / "x").write_text("")
    with pytest.raises(RecordError, match="not empty"):
        atomic_folder.check_target(tmp_path, holds="x")
    assert atomic_folder.check_target(tmp_path, overwrite=True, holds="x") == tmp_path
    with pytest.raises(RecordError, match="something else than y"):
        atomic_folder.check_target(tmp_path, overwrite=True, holds="y")
