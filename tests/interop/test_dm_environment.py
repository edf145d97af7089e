"""The dm_env adapter, and the pair of dm_control and MuJoCo that is installed."""

import subprocess
import sys

import numpy as np
import pytest

FAST = {"iterations": 1, "dance": {"rehearsal": False}}


@pytest.fixture(scope="module")
def dm():
    pytest.importorskip("dm_control", reason="dm-control is not installed (Python 3.13 and newer have none)")

    from sjasim.interop import dm_environment

    return dm_environment


def test_dm_control_and_mujoco_fit_together(dm):
    assert dm
    from dm_control import mjcf

    model = mjcf.RootElement()
    model.worldbody.add("geom", type="sphere", size=[0.1])
    physics = mjcf.Physics.from_mjcf_model(model)
    physics.step()
    assert physics.data.time > 0.0


def test_it_keeps_the_interface(dm):
    from dm_env import StepType

    environment = dm.DanceEnvironment(seed=1, **FAST)
    first = environment.reset()
    assert first.step_type is StepType.FIRST
    assert set(first.observation) == set(environment.observation_spec())
    for name, spec in environment.observation_spec().items():
        spec.validate(first.observation[name])
    action = environment.action_spec().validate(np.array([0.3, 0.0], dtype=np.float32))
    before = environment.physics.named.data.qpos.copy()
    for _ in range(20):
        then = environment.step(action)
    assert then.step_type is StepType.MID
    assert then.discount == 1.0
    assert environment.physics.data.time == pytest.approx(20 / 30)
    assert not np.array_equal(before, environment.physics.data.qpos)
    environment.close()


def test_what_a_viewer_does_to_its_physics_does_not_change_the_dance(dm):
    def dance(meddle):
        environment = dm.DanceEnvironment(seed=1, **FAST)
        environment.reset()
        for _ in range(10):
            if meddle:
                environment.physics.data.qpos[:] = 0.0
                environment.physics.forward()
            last = environment.step(np.zeros(2, dtype=np.float32))
        return np.concatenate([part.ravel() for part in last.observation.values()])

    assert np.array_equal(dance(True), dance(False))


def test_dm_controls_viewer_can_run_it(dm):
    from dm_control.viewer import runtime

    environment = dm.DanceEnvironment(seed=1, **FAST)
    run = runtime.Runtime(environment)
    changed = []
    run.on_physics_changed += lambda: changed.append(run.get_time())
    for _ in range(3):
        run.tick(0.05, paused=False)
    assert run.state is runtime.State.RUNNING
    assert run.get_time() > 0.0
    assert len(changed) == 1


def test_without_dm_control_the_reason_is_named():
    probe = (
        "import sys; sys.modules['dm_control'] = None\n"
        "try:\n import sjasim.interop.dm_environment\nexcept ImportError as e: print(e)"
    )
    answer = subprocess.run([sys.executable, "-c", probe], capture_output=True, text=True, check=True)
    assert "sjasim.interop needs dm_control" in answer.stdout
