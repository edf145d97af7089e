"""The dm_env environment, and whether the installed versions of dm_control and MuJoCo fit together."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

FAST = {"iterations": 1, "dance": {"rehearsal": False}}


@pytest.fixture(scope="module")
def dm_environment():
    pytest.importorskip("dm_control", reason="dm-control is not installed (Python 3.13 and newer have none)")

    from sjasim.interop import dm_environment

    return dm_environment


def test_dm_control_and_mujoco_fit_together(dm_environment):
    from dm_control import mjcf

    model = mjcf.RootElement()
    model.worldbody.add("geom", type="sphere", size=[0.1])
    physics = mjcf.Physics.from_mjcf_model(model)
    physics.step()
    assert physics.data.time > 0.0


def test_observations_and_steps_follow_the_interface(dm_environment):
    from dm_env import StepType

    environment = dm_environment.DanceEnvironment(seed=1, **FAST)
    first = environment.reset()
    assert first.step_type is StepType.FIRST
    assert set(first.observation) == set(environment.observation_spec())
    for name, spec in environment.observation_spec().items():
        spec.validate(first.observation[name])

    action = environment.action_spec().validate(np.array([0.3, 0.0], dtype=np.float32))
    qpos = environment.physics.named.data.qpos.copy()
    for _ in range(20):
        last = environment.step(action)
    assert last.step_type is StepType.MID
    assert last.discount == 1.0
    assert environment.physics.data.time == pytest.approx(20 / 30)
    assert not np.array_equal(qpos, environment.physics.data.qpos)
    environment.close()


def test_a_viewer_that_changes_its_physics_does_not_change_the_session(dm_environment):
    def final_observation(change_physics):
        environment = dm_environment.DanceEnvironment(seed=1, **FAST)
        environment.reset()
        for _ in range(10):
            if change_physics:
                environment.physics.data.qpos[:] = 0.0
                environment.physics.forward()
            last = environment.step(np.zeros(2, dtype=np.float32))
        return np.concatenate([part.ravel() for part in last.observation.values()])

    assert np.array_equal(final_observation(True), final_observation(False))


def test_the_viewers_runtime_can_run_it(dm_environment):
    from dm_control.viewer import runtime

    environment = dm_environment.DanceEnvironment(seed=1, **FAST)
    run = runtime.Runtime(environment)
    changes_s = []
    run.on_physics_changed += lambda: changes_s.append(run.get_time())
    for _ in range(3):
        run.tick(0.05, paused=False)
    assert run.state is runtime.State.RUNNING
    assert run.get_time() > 0.0
    assert len(changes_s) == 1


def test_without_dm_control_the_import_error_says_so():
    probe = (
        "import sys; sys.modules['dm_control'] = None\n"
        "try:\n import sjasim.interop.dm_environment\nexcept ImportError as e: print(e)"
    )
    answer = subprocess.run([sys.executable, "-c", probe], capture_output=True, text=True, check=True)
    assert "sjasim.interop needs dm_control" in answer.stdout
