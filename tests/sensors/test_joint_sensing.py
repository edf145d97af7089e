"""Joints sensing: what is seen, and with which errors."""

from __future__ import annotations

import numpy as np
import pytest

from sjasim.assets.names import JOINT_INDEX, JOINTS
from sjasim.config import JointNoiseConfig, SensorConfig, SessionConfig
from sjasim.core import INFERRED, NOT_TRACKED, TRACKED, Skeletons
from sjasim.core.clock import stream
from sjasim.core.registry import resolve
from sjasim.sensors.joint_sensing import JointSensing

from .scripted import FRAME_HZ, NORTH, PLACES, Screen, Script, ScriptedView

EXACT = JointNoiseConfig(bias_m=0.0, drift_m=0.0, limb_drift_m=0.0)
STEADY = JointNoiseConfig(drift_m=0.0, limb_drift_m=0.0)
DRIFTING = JointNoiseConfig(bias_m=0.0)
BODY = np.array([not name.startswith(("Elbow", "Wrist", "Hand", "Thumb", "Knee", "Ankle", "Foot")) for name in JOINTS])


def sensing(
    noise: JointNoiseConfig = EXACT, seed: int = 0, group: int = 3, sensors: SensorConfig | None = None
) -> JointSensing:
    config = SessionConfig(sensing="joints", dancers=group, sensors=sensors or SensorConfig(), joint_noise=noise)
    return JointSensing(NORTH, config, stream(seed, "sensors", "north"))


def physics(**options: object) -> ScriptedView:
    return ScriptedView([Script(place, sway_m=0.0) for place in PLACES], **options)


def seen(sensor: JointSensing, view: ScriptedView) -> Skeletons:
    skeletons = sensor.sample(view)
    assert skeletons is not None
    return skeletons


def row(sensor: JointSensing, dancer: int) -> int:
    return sensor.dancers.tolist().index(dancer)


def errors(noise: JointNoiseConfig, frames: int, seed: int = 0, screens: list[Screen] | None = None) -> np.ndarray:
    """(frames, P, 25, 3) estimated minus true joints in the sensor's frame."""
    sensor, view, out = sensing(noise, seed), physics(screens=screens), []
    for tick in range(frames):
        view.time_s = tick / FRAME_HZ
        true = (view.joints_m[sensor.dancers] - NORTH.position) @ NORTH.world_from_sensor
        out.append(seen(sensor, view).joints - true)
    return np.array(out)


def test_without_errors_the_joints_are_the_true_ones_in_the_sensors_frame():
    sensor, view = sensing(), physics()
    skeletons = seen(sensor, view)
    world = skeletons.joints @ NORTH.world_from_sensor.T + NORTH.position
    assert np.allclose(world, view.joints_m[sensor.dancers], atol=1e-12)
    assert (skeletons.state == TRACKED).all()
    assert (skeletons.joints[:, :, 2] > 0).all()
    facing = skeletons.joints[:, JOINT_INDEX["ShoulderRight"], 0] > skeletons.joints[:, JOINT_INDEX["ShoulderLeft"], 0]
    assert facing.all()  # a person facing the sensor has the right shoulder on the sensor's left


def test_is_registered_under_its_name():
    assert resolve("sensing", "joints").factory.__name__ == "JointSensing"


def test_frame_values_are_read_only():
    skeletons = seen(sensing(), physics())
    with pytest.raises(ValueError, match="read-only"):
        skeletons.joints[0, 0, 0] = 0.0


def test_identities_are_a_permutation_of_the_sensors_own():
    orders = {tuple(sensing(seed=seed).dancers) for seed in range(40)}
    assert len(orders) == 6
    assert all(sorted(order) == [0, 1, 2] for order in orders)


@pytest.mark.parametrize(
    ("joints", "size_m", "correlation"),
    [(BODY, DRIFTING.drift_m, DRIFTING.drift_correlation),
     (~BODY, DRIFTING.limb_drift_m, DRIFTING.limb_drift_correlation)],
    ids=["body", "limbs"],
)  # fmt: skip
def test_the_drift_is_slow_and_faster_in_the_limbs(joints, size_m, correlation):
    drift = errors(DRIFTING, 3000)[:, :, joints]
    assert np.diff(drift, axis=0).std() == pytest.approx(size_m * np.sqrt(2 - 2 * correlation), rel=0.02)
    assert drift.std() == pytest.approx(size_m, rel=0.1)
    assert (drift[1:] * drift[:-1]).mean() / (drift**2).mean() == pytest.approx(correlation, abs=0.003)


def test_bias_is_constant_per_person_and_joint():
    values = errors(STEADY, 50)
    assert np.ptp(values, axis=0).max() < 1e-12
    assert values[0].std() == pytest.approx(STEADY.bias_m, rel=0.15)


def test_drift_runs_on_over_frames_not_taken():
    sensor, view = sensing(DRIFTING), physics()
    values = []
    for tick in range(0, 12000, 6):
        view.time_s = tick / FRAME_HZ
        values.append(seen(sensor, view).joints[:, BODY])
    drift = np.array(values) - np.mean(values, axis=0)
    assert (drift[1:] * drift[:-1]).mean() / (drift**2).mean() == pytest.approx(DRIFTING.drift_correlation**6, abs=0.01)


def screen_before(view: ScriptedView, dancer: int, joint: str, radius_m: float, **when: float) -> Screen:
    """A sphere half way between the sensor and a joint."""
    centre = (view.joints_m[dancer, JOINT_INDEX[joint]] + NORTH.position) / 2
    return Screen(tuple(centre), radius_m, **when)


def test_hidden_hand_is_inferred_and_its_error_grows_smoothly():
    view = physics()
    view.screens = [screen_before(view, 0, "HandLeft", 0.08, from_s=1.0, until_s=3.0)]
    sensor, hand, values, states = sensing(STEADY), JOINT_INDEX["HandLeft"], [], []
    for tick in range(180):
        view.time_s = tick / FRAME_HZ
        skeletons = seen(sensor, view)
        person = row(sensor, 0)
        true = (view.joints_m[0] - NORTH.position) @ NORTH.world_from_sensor
        values.append((skeletons.joints[person] - true)[hand])
        states.append(int(skeletons.state[person, hand]))
    size = np.linalg.norm(values, axis=1)
    assert states[29] == TRACKED
    assert set(states[30:90]) == {INFERRED}
    assert size[89] / size[29] == pytest.approx(STEADY.occluded_factor_hand, rel=0.01)
    assert states[90] == INFERRED  # seen again, but not settled yet
    back = states.index(TRACKED, 90)
    assert (back - 90) / FRAME_HZ < 0.45
    assert size[back] <= 1.5 * size[29] + 1e-9
    spine = seen(sensor, view).state[row(sensor, 0), JOINT_INDEX["SpineBase"]]
    assert spine == TRACKED


def test_hiding_the_torso_makes_no_jump_that_looks_like_motion():
    view = physics()
    screen = screen_before(view, 0, "SpineBase", 0.07, from_s=1.0, until_s=2.0)
    base = JOINT_INDEX["SpineBase"]
    biggest = 0.0
    for seed in range(30):
        values = errors(STEADY, 90, seed, [screen])[:, :, base, 2]
        biggest = max(biggest, np.abs(values[4:] - values[:-4]).max() / (4 / FRAME_HZ))
    assert biggest < 0.05  # m/s, where a move needs .20


def test_what_the_body_holds_in_place_is_tracked_while_hidden_and_farther_off():
    view, base = physics(), JOINT_INDEX["SpineBase"]
    screen = screen_before(view, 0, "SpineBase", 0.07, from_s=1.0)
    view.screens, view.time_s, sensor = [screen], 2.0, sensing()
    assert seen(sensor, view).state[row(sensor, 0), base] == TRACKED
    assert not sensor.visible[row(sensor, 0), base]
    far = np.array([np.linalg.norm(errors(STEADY, 180, seed, [screen])[:, :, base], axis=2) for seed in range(10)])
    grown = far[:, -1] / far[:, 29]
    assert grown.max() == pytest.approx(STEADY.occluded_factor, rel=0.01)
    assert grown.min() == pytest.approx(1.0)  # the others are not hidden


def test_a_hidden_torso_makes_the_person_untracked():
    view = physics()
    view.screens = [screen_before(view, 1, "SpineMid", 0.6)]
    sensor = sensing()
    skeletons = seen(sensor, view)
    person = row(sensor, 1)
    assert (skeletons.state[person] == NOT_TRACKED).all()
    assert np.isnan(skeletons.joints[person]).all()


def test_own_flesh_does_not_hide_a_joint_but_the_own_body_does():
    view, hand = physics(), JOINT_INDEX["HandLeft"]
    joint = view.joints_m[0, hand]
    towards = (NORTH.position - joint) / np.linalg.norm(NORTH.position - joint)
    sensor = sensing()
    for radius, before, state in ((0.1, 0.0, TRACKED), (0.1, 0.4, INFERRED)):
        view.screens = [Screen(tuple(joint + before * towards), radius, owner=0)]
        assert seen(sensor, view).state[row(sensor, 0), hand] == state
    view.screens = [Screen(tuple(joint), 0.1, owner=1)]
    assert seen(sensing(), view).state[row(sensor, 0), hand] == INFERRED


@pytest.mark.parametrize("place", [(0.0, -1.3), (0.0, 3.1), (2.6, 0.6), (0.0, 4.0)])
def test_out_of_range_or_view_nobody_is_tracked(place: tuple[float, float]):
    view = ScriptedView([Script(place)])
    assert (seen(sensing(group=1), view).state == NOT_TRACKED).all()


def test_field_of_view_is_judged_per_joint():
    view = ScriptedView([Script((0.0, 2.2))])  # 1.2 m before the sensor: head and feet are cut off
    state = seen(sensing(group=1), view).state[0]
    assert state[JOINT_INDEX["SpineBase"]] == TRACKED
    assert state[JOINT_INDEX["AnkleLeft"]] == state[JOINT_INDEX["Head"]] == NOT_TRACKED


def test_frame_loss_has_the_given_rate_and_its_own_stream():
    sensor, view = sensing(JointNoiseConfig(), sensors=SensorConfig(frame_loss=0.1)), physics()
    lost = 0
    for tick in range(3000):
        view.time_s = tick / FRAME_HZ
        lost += sensor.sample(view) is None
    assert 240 < lost < 360
    assert (sensor.dancers == sensing().dancers).all()


def test_same_seed_same_frames():
    assert (errors(JointNoiseConfig(), 40, seed=3) == errors(JointNoiseConfig(), 40, seed=3)).all()
    assert (errors(JointNoiseConfig(), 40, seed=3) != errors(JointNoiseConfig(), 40, seed=4)).any()
