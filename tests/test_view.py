"""Looking at kept sessions: one line for bad input, nothing lost, two sessions on one axis."""

import os

import numpy as np
import pytest

from sjasim import export, view
from sjasim.analysis import viewing
from sjasim.analysis.delay_breakdown import delay_report
from sjasim.analysis.session_metrics import measures
from sjasim.commands.main import main
from sjasim.record import atomic_folder, session_folder

from .record.rerun.test_recording import with_skeletons

pytest.importorskip("rerun")

from sjasim.record.rerun.rrd_reader import RECORDING, read_chunks, read_with_joints

NEEDS_VIEWER = pytest.mark.skipif(
    os.environ.get("SJASIM_VIEWER") != "1",
    reason="opens a viewer, which needs Vulkan (Debian: mesa-vulkan-drivers); SJASIM_VIEWER=1 asks for it",
)


@pytest.fixture(scope="module")
def log(make_session_log):
    return with_skeletons(make_session_log(iterations=1))


@pytest.fixture(scope="module")
def kept(log, tmp_path_factory):
    target = tmp_path_factory.mktemp("runs") / "one"
    return session_folder.write(log, target, measures(log).as_dict(), report=delay_report(log))


@pytest.fixture
def damaged(kept, tmp_path):
    """A copy of the folder in which one file's bytes can be replaced."""
    copy = tmp_path / "copy"
    copy.mkdir()
    for path in kept.iterdir():
        (copy / path.name).write_bytes(path.read_bytes())
    return copy


def refused(capsys, command, *arguments):
    """The one line that a command says when it refuses."""
    assert main(command, [str(word) for word in arguments]) == 2
    heard = capsys.readouterr()
    assert heard.out == ""
    assert heard.err.startswith("error: ")
    assert heard.err.count("\n") == 1
    return heard.err


def test_joints_come_back_from_the_recording(log, kept):
    again = read_with_joints(kept)
    assert np.array_equal(again.joints, log.joints)
    seen = ~np.isnan(again.skeletons[..., 3])
    assert seen[::2].all()
    assert np.array_equal(again.skeletons[seen], log.skeletons[seen])


def test_two_sessions_share_one_axis(kept, tmp_path):
    recording = viewing.viewable_recording([kept, kept], tmp_path)
    entities = {entity for entity, _ in read_chunks(recording)}
    for part in ("world/dancer_1/true", "world/dancer_1/tracked", "lanes/robot/moved", "curves/group/gsi"):
        assert {f"/A-sia-0/{part}", f"/B-sia-0/{part}"} <= entities


def test_a_folder_without_a_recording_gets_one(log, tmp_path):
    bare = session_folder.write(log, tmp_path / "bare", measures(log).as_dict(), recording=False)
    recording = viewing.viewable_recording([bare], tmp_path)
    assert recording != bare / RECORDING
    assert "/world/dancer_1/name" in {entity for entity, _ in read_chunks(recording)}
    assert 20 < viewing.picture_time_s(viewing.read_configs([bare])[0]) < 40


def test_an_existing_recording_is_opened_as_it_is(kept, tmp_path):
    assert viewing.viewable_recording([kept], tmp_path) == kept / RECORDING


@pytest.mark.parametrize(
    ("name", "content", "says"),
    [
        ("session.rrd", lambda data: data[: len(data) // 2], "session.rrd cannot be read"),
        ("session.rrd", lambda data: b"nonsense", "session.rrd cannot be read"),
        ("session.json", lambda data: data.replace(b'"schema": 2', b'"schema": 99'), "version 1 or 2"),
        ("session.json", lambda data: b"{", "damaged"),
    ],
)
def test_damaged_folders_give_one_line(damaged, tmp_path, capsys, name, content, says):
    (damaged / name).write_bytes(content((damaged / name).read_bytes()))
    assert says in refused(capsys, view.command, damaged, "--screenshot", tmp_path / "a.png")


def test_other_folders_and_existing_pictures_give_one_line(kept, tmp_path, capsys):
    assert "not a session's folder" in refused(capsys, view.command, tmp_path, "--screenshot", tmp_path / "a.png")
    (tmp_path / "a.png").write_bytes(b"mine")
    assert "--overwrite" in refused(capsys, view.command, kept, "--screenshot", tmp_path / "a.png")
    assert "folder does not exist" in refused(capsys, view.command, kept, "--screenshot", tmp_path / "no" / "a.png")
    assert (tmp_path / "a.png").read_bytes() == b"mine"


def test_without_a_display_a_picture_is_offered(kept, capsys, monkeypatch):
    monkeypatch.setattr(view.sys, "platform", "linux")
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    assert "--screenshot" in refused(capsys, view.command, kept)


def test_a_folder_that_is_none_is_named_first(tmp_path, capsys):
    assert "not a session's folder" in refused(capsys, view.command, tmp_path / "none")


def test_figures_of_two_kept_sessions_are_compared(kept, tmp_path, capsys):
    pytest.importorskip("matplotlib")
    assert main(view.command, [str(kept), str(kept), "--plots", str(tmp_path / "plots")]) == 0
    names = {path.name for path in (tmp_path / "plots").iterdir()}
    assert {"timing.png", "A-sia-0-raster.png", "B-sia-0-delays.png"} <= names
    capsys.readouterr()
    assert "--overwrite" in refused(capsys, view.command, kept, "--plots", tmp_path / "plots")
    assert "not a session's folder" in refused(capsys, view.command, tmp_path, "--plots", tmp_path / "other")
    assert not (tmp_path / "other").exists()


def test_csv_holds_the_tables(log, kept, tmp_path, capsys):
    assert main(export.command, [str(kept), "--csv", str(tmp_path / "csv")]) == 0
    lines = (tmp_path / "csv" / "events.csv").read_text().splitlines()
    assert lines[0] == '"session","agent","kind","t_s","t_arrival_s","early","iteration","source"'
    assert [float(line.split(",")[3]) for line in lines[1:]] == [event.t_s for event in log.events]
    capsys.readouterr()
    assert "--overwrite" in refused(capsys, export.command, kept, "--csv", tmp_path / "csv")


def test_a_damaged_table_leaves_no_tables_behind(damaged, tmp_path, capsys):
    (damaged / "events.parquet").write_bytes(b"PAR1")
    assert "events.parquet cannot be read" in refused(capsys, export.command, damaged, "--csv", tmp_path / "csv")
    assert not (tmp_path / "csv").exists()


def test_export_wants_to_know_what(kept, capsys):
    assert "--mcap FILE" in refused(capsys, export.command, kept)


def test_an_earlier_session_is_replaced_only_on_request(log, kept, tmp_path):
    target = session_folder.write(log, tmp_path / "one", measures(log).as_dict(), recording=False)
    with pytest.raises(session_folder.RecordError, match="--overwrite"):
        atomic_folder.check_target(target)
    session_folder.write(log, target, {**measures(log).as_dict(), "again": 1}, recording=False, overwrite=True)
    assert session_folder.read_summary(target)["again"] == 1
    assert [path.name for path in tmp_path.iterdir()] == ["one"]
    (target / "session.json").unlink()
    with pytest.raises(session_folder.RecordError, match="something else"):
        atomic_folder.check_target(target, overwrite=True)


@pytest.mark.parametrize("at", ["-1", "107", "nan"])
def test_a_time_outside_the_recording_is_refused(kept, tmp_path, capsys, at):
    said = refused(capsys, view.command, kept, "--screenshot", tmp_path / "a.png", f"--at={at}")
    assert f"at = {float(at)} is not allowed: a session time from 0 to " in said
    assert list(tmp_path.iterdir()) == []
    assert "only with --screenshot" in refused(capsys, view.command, kept, "--at", 10)


@pytest.mark.parametrize(("words", "says"), [("no adapter found", "mesa-vulkan-drivers"), ("bang", "at once: bang")])
def test_a_viewer_that_dies_after_its_first_answer_says_why(monkeypatch, words, says):
    import subprocess
    import sys

    from sjasim.record.rerun import viewer

    def dying(headless, size, log):
        return subprocess.Popen([sys.executable, "-c", f"print({words!r})"], stdout=log), "nowhere"

    monkeypatch.setattr(viewer, "start", dying)
    monkeypatch.setattr(viewer, "wait_until_ready", lambda *given: None)
    with pytest.raises(session_folder.RecordError, match=says), viewer.headless_viewer():
        raise ConnectionError("transport error")


@pytest.mark.parametrize("slow_tries", [0, 3, 4])
def test_a_viewer_that_is_slow_to_draw_is_asked_again(tmp_path, slow_tries):
    from sjasim.record.rerun import viewer

    class SlowViewer:
        asked = 0

        def save_screenshot(self, path):
            self.asked += 1
            if self.asked <= slow_tries:
                raise TimeoutError("deadline expired")
            (tmp_path / "a.png").write_bytes(b"drawn")

    if slow_tries == viewer.DRAWING_TRIES:
        with pytest.raises(session_folder.RecordError, match="did not draw in time"):
            viewer._save_screenshot(SlowViewer(), tmp_path / "a.png")
    else:
        viewer._save_screenshot(SlowViewer(), tmp_path / "a.png")
        assert (tmp_path / "a.png").read_bytes() == b"drawn"


@pytest.mark.slow
@NEEDS_VIEWER
def test_the_viewer_draws_every_view_without_a_display(kept, tmp_path):
    from sjasim.record.rerun.viewer import screenshot

    assert screenshot(kept / RECORDING, tmp_path / "a.png", 30.0) == []
    assert (tmp_path / "a.png").stat().st_size > 50_000


@pytest.mark.slow
@NEEDS_VIEWER
def test_a_live_session_reaches_a_viewer_that_only_this_machine_can_reach(log):
    import psutil
    import rerun as rr

    from sjasim.config.toml_file import from_plain
    from sjasim.record.rerun.live_view import LiveView
    from sjasim.record.rerun.viewer import wait_until_ready

    live = LiveView(from_plain(log.config), headless=True)
    try:
        wait_until_ready(live.process, live.url)
        for now in (5.0, 10.0, 20.0):
            live.tick(now, lambda: log)
        live.finish(log, delay_report(log))
        state = rr.experimental.ViewerClient.connect(live.url).get_state()
        assert [item.store_id.rpartition(":")[2] for item in state.recordings] == ["sia-0-live"]
        doors = [c.laddr.ip for c in psutil.Process(live.process.pid).net_connections() if c.status == "LISTEN"]
        assert set(doors) == {"127.0.0.1"}
    finally:
        live.close()


def test_nothing_heavy_is_loaded_before_it_is_needed():
    import subprocess
    import sys

    names = "sjasim.run, sjasim.view, sjasim.export, sjasim.session.session, sjasim.analysis.delay_breakdown"
    heavy = ("rerun", "matplotlib", "mcap_ros2", "imageio_ffmpeg", "PIL")
    probe = f"import sys, {names}; print([name for name in {heavy!r} if name in sys.modules])"
    answer = subprocess.run([sys.executable, "-c", probe], capture_output=True, text=True, check=True)
    assert answer.stdout.strip() == "[]"
