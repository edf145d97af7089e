"""Depth images of the active sensor: what is kept is what its camera sees, and a recording holds it."""

from __future__ import annotations

import dataclasses

import imageio.v3 as imageio
import numpy as np
import rerun as rr

from sjasim.config import SessionConfig
from sjasim.record.rerun.recording import save
from sjasim.session.session import Session
from sjasim.simulation.depth_recorder import PICTURES_HZ, STEP_MM, DepthRecorder

SECONDS = 1.0


def watched() -> tuple[Session, DepthRecorder]:
    session = Session(SessionConfig(method="none", humans="metronomic", sensing="joints"))
    watch = DepthRecorder(session)
    session.world.watchers.append(watch.tick)
    session.advance(SECONDS)
    return session, watch


def test_pictures_of_people_are_kept_and_recorded(tmp_path):
    session, watch = watched()
    assert len(watch.pictures) == SECONDS * PICTURES_HZ
    image = imageio.imread(watch.pictures[-1].png, extension=".png")
    assert image.shape == (106, 128)
    assert (image % STEP_MM == 0).all()
    near = image[(image > 1500) & (image < 4500)]
    assert len(near) > 500  # three people and the floor between them
    assert {picture.sensor for picture in watch.pictures} == {"east"}
    save(dataclasses.replace(session.log(), depth=tuple(watch.pictures)), tmp_path / "session.rrd")
    found = 0
    for chunk in rr.chunk.RrdReader(tmp_path / "session.rrd").stream():
        if str(chunk.entity_path) == "/depth" and not chunk.is_static:
            found += len(chunk.to_record_batch())
    assert found == len(watch.pictures)


def test_watching_changes_nothing():
    session, _ = watched()
    alone = Session(SessionConfig(method="none", humans="metronomic", sensing="joints"))
    alone.advance(SECONDS)
    assert np.array_equal(session.world.physics.data.qpos, alone.world.physics.data.qpos)
