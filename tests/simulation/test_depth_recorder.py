"""Recorded depth images: they show the scene, they are in the rerun recording, and they do not change the session."""

from __future__ import annotations

import dataclasses

import imageio.v3 as imageio
import numpy as np
import pytest
import rerun as rr

from sjasim.record.rerun.recording import save
from sjasim.session.session import Session
from sjasim.simulation.depth_recorder import PICTURES_HZ, STEP_MM, DepthRecorder

DURATION_S = 1.0


@pytest.fixture(scope="module")
def config(short_config):
    return dataclasses.replace(short_config, method="none")


@pytest.fixture(scope="module")
def recorded(config) -> tuple[Session, DepthRecorder]:
    """One second of a session whose depth images are recorded."""
    session = Session(config)
    recorder = DepthRecorder(session)
    session.world.watchers.append(recorder.tick)
    session.advance(DURATION_S)
    return session, recorder


def test_images_show_the_scene_at_the_recorded_resolution(recorded):
    session, recorder = recorded
    assert len(recorder.pictures) == DURATION_S * PICTURES_HZ
    assert {picture.sensor for picture in recorder.pictures} == {session.server.active}
    image_mm = imageio.imread(recorder.pictures[-1].png, extension=".png")
    assert image_mm.shape == (106, 128)
    assert (image_mm % STEP_MM == 0).all()
    near = image_mm[(image_mm > 1500) & (image_mm < 4500)]
    assert len(near) > 500  # three dancers and the floor between them


def test_the_rerun_recording_has_every_image(recorded, tmp_path):
    session, recorder = recorded
    save(dataclasses.replace(session.log(), depth=tuple(recorder.pictures)), tmp_path / "session.rrd")
    found = 0
    for chunk in rr.chunk.RrdReader(tmp_path / "session.rrd").stream():
        if str(chunk.entity_path) == "/depth" and not chunk.is_static:
            found += len(chunk.to_record_batch())
    assert found == len(recorder.pictures) > 0


def test_recording_does_not_change_the_session(recorded, config):
    session, _ = recorded
    alone = Session(config)
    alone.advance(DURATION_S)
    assert np.array_equal(session.world.physics.data.qpos, alone.world.physics.data.qpos)
