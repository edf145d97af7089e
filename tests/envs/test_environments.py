"""The environments follow Gymnasium's rules, and a method gives the same log in one as in a session of its own."""

from __future__ import annotations

import dataclasses
import itertools
import multiprocessing
import subprocess
import sys
import types
import warnings

import gymnasium as gym
import numpy as np
import pytest
from gymnasium import error
from gymnasium.utils.env_checker import check_env
from gymnasium.wrappers import FlattenObservation, RecordEpisodeStatistics, RecordVideo, RescaleAction, TimeLimit
from sjasim_envs import ENVIRONMENTS
from sjasim_envs.dance import DanceEnv
from sjasim_envs.wrappers import InOrder, MethodPolicy

import sjasim
from sjasim.analysis.session_metrics import measures
from sjasim.anticipation.observation import MOVES, EventFeatures
from sjasim.core import registry

from .policies import FAST, repeat_move, run_episode

IDS = sorted(ENVIRONMENTS)
TABLES = ("device_events", "events", "commands", "decisions", "robot_events", "notices", "cues")


def make(name="sjasim/Dance-v0", **options):
    return gym.make(name, disable_env_checker=True, **{**FAST, **options})


@pytest.mark.parametrize("name", IDS)
def test_every_id_passes_gymnasiums_checker(name):
    """The only warning is about the continuous limits, which are the robot's: `RescaleAction` makes them -1 and 1."""
    env = gym.make(name, **FAST)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        check_env(env.unwrapped, skip_render_check=True)
    messages = [str(warning.message) for warning in caught]
    assert all("symmetric and normalized" in text for text in messages)
    assert len(messages) == (name == "sjasim/DanceContinuous-v0")

    # A second call of close has no effect.
    env.close()
    env.close()


def test_rendering_passes_gymnasiums_checker(monkeypatch):
    monkeypatch.setitem(DanceEnv.metadata, "render_modes", ["rgb_array"])  # human needs a display
    env = with_opengl(gym.make("sjasim/Dance-v0", render_mode="rgb_array", width=64, height=48, **FAST))
    check_env(env.unwrapped)
    env.reset(seed=0)
    picture = env.render()
    env.close()
    assert picture.shape == (48, 64, 3)
    assert picture.std() > 0


def test_importing_sjasim_registers_the_ids_and_loads_nothing_heavy():
    probe = (
        "import sys, sjasim, gymnasium; print(all(i in gymnasium.registry for i in "
        f"{IDS!r}), [m for m in ('mujoco', 'sjasim_envs.dance', 'sjasim.session.session') if m in sys.modules])"
    )
    answer = subprocess.run([sys.executable, "-c", probe], capture_output=True, text=True, check=True)
    assert answer.stdout.strip() == "True []"


def test_the_flat_observation_equals_the_flattened_named_one():
    flat = make("sjasim/DanceFlat-v0")
    flattened = FlattenObservation(make())
    assert flat.observation_space == flattened.observation_space
    assert np.array_equal(flat.reset(seed=3)[0], flattened.reset(seed=3)[0])
    for action in (0, 1, 1, 0, 3):
        assert np.array_equal(flat.step(action)[0], flattened.step(action)[0])


def test_observations_do_not_share_memory():
    for env, parts in ((make(), dict.values), (make("sjasim/DanceFlat-v0"), lambda row: [row])):
        kept = [env.reset(seed=3)[0], *(env.step(action)[0] for action in (1, 1, 0))]
        assert len({b"".join(part.tobytes() for part in parts(row)) for row in kept}) == len(kept)
        for one, other in itertools.combinations([part for row in kept for part in parts(row)], 2):
            assert not np.shares_memory(one, other)


def test_the_observation_of_method_policy_is_what_a_method_knows():
    env = MethodPolicy(make(method="eca"))
    env.reset(seed=3)
    session = env.unwrapped.session
    session.advance(9.0)
    env.unwrapped._steps = 270  # 9 s at 30 Hz
    row = env.step(1)[0]

    features = EventFeatures(session.context)
    for event in session.events:
        features.add(event)
    current = session.dispatcher.current
    assert len(session.events) > 2
    assert np.array_equal(row, features.row(session.time_s, MOVES.index(current.move), current.t_start_s))
    assert row in env.observation_space


def test_method_policy_needs_the_named_observation():
    with pytest.raises(error.Error, match="last_iteration"):
        MethodPolicy(make("sjasim/DanceFlat-v0"))


def test_in_order_sends_each_step_once_and_near_its_beat():
    env = InOrder(make(step_hz=5))
    env.reset(seed=3)
    session = env.unwrapped.session
    forward, backward, turn = (MOVES.index(name) for name in ("forward", "backward", "turn"))
    start_s = session.context.iteration_start_s[1]
    seen = []
    wanted = ((-2.0, turn), (0.0, forward), (0.2, backward), (0.4, forward))
    for t_s, action in [(start_s + after_s, action) for after_s, action in wanted]:
        while session.time_s < t_s - 1e-9:
            env.step(env.unwrapped.action_space.start if not seen else seen[-1][0])
        env.step(action)
        current = session.dispatcher.current
        seen.append((0 if current is None else MOVES.index(current.move), len(session.commands)))
    assert [move for move, _ in seen] == [0, forward, forward, forward]
    assert seen[1] == seen[-1]


def test_in_order_needs_the_four_moves():
    env = InOrder(make())
    env.reset(seed=0)
    with pytest.raises(error.InvalidAction, match="1 forward"):
        env.step(4)
    with pytest.raises(error.Error, match="four moves"):
        InOrder(make("sjasim/DanceContinuous-v0"))


def test_stable_baselines_learns_on_it():
    algorithms = pytest.importorskip("stable_baselines3", reason="the extra rl is not installed")
    env = MethodPolicy(make(step_hz=5))
    model = algorithms.PPO("MlpPolicy", env, n_steps=32, batch_size=32, n_epochs=1, device="cpu").learn(32)
    assert env.action_space.contains(int(model.predict(env.reset(seed=0)[0])[0]))


class TestLogs:
    """Methods that run in an environment."""

    @pytest.mark.parametrize("method", ["sia"])
    def test_a_method_through_the_environment_leaves_the_same_log(self, method):
        options = {"first_followed_iteration": 1}
        config = sjasim.SessionConfig(method=method, sensing="joints", seed=4, iterations=1, method_options=options)
        log = sjasim.run_session(config)
        env = make(method=method, dance={"rehearsal": True}, method_options=options)

        total, rows = run_episode(env, repeat_move, seed=4)
        same = env.unwrapped.session.log()
        assert same.config == log.config
        for table in TABLES:
            assert getattr(same, table) == getattr(log, table), table
        assert all(np.array_equal(same.odometry[key], column) for key, column in log.odometry.items())

        figures = measures(log)
        assert [row["gsi"] for row in rows] == [figures.gsi]
        assert [row["gsi_full_edges"] for row in rows] == [figures.gsi_full_edges]
        assert rows[0]["ta_mean_s"] == pytest.approx(figures.ta_mean_s, abs=1e-12)
        assert np.abs(rows[0]["event_errors_s"])[~np.isnan(rows[0]["event_errors_s"])] == pytest.approx(figures.ta_s)
        assert total > 0.0

    @pytest.mark.parametrize("method", [name for name in registry.names("anticipation") if name != "learned"])
    def test_every_registered_method_can_be_used(self, method):
        env = make()
        env.reset(seed=0, options={"method": method})
        assert env.unwrapped.session.config.method == method
        observation = env.step(0)[0]
        assert all(np.isfinite(part).all() for part in observation.values())


class TestSeeds:
    """Seeds of people, performances and action spaces."""

    def test_the_same_seed_gives_the_same_trajectory(self):
        def trajectory():
            env = make()
            env.action_space.seed(1)
            rows = [env.reset(seed=5)[0]]
            rows += [env.step(env.action_space.sample())[0] for _ in range(40)]
            return np.array([np.concatenate([part.ravel() for part in row.values()]) for row in rows])

        assert np.array_equal(trajectory(), trajectory())

    def test_people_and_action_space_have_separate_seeds(self):
        def configuration(action_seed, **reset):
            env = make()
            env.action_space.seed(action_seed)
            env.reset(**reset)
            return env.unwrapped.session.config

        assert configuration(1, seed=7) == configuration(2, seed=7)
        again = [configuration(1, seed=seed, options={"people": 3}) for seed in (8, 9)]
        assert {config.seed for config in again} == {3}
        assert len({config.performance for config in again}) == 2
        one, other = (gym.make("sjasim/Dance-v0").action_space for _ in range(2))
        one.seed(1)
        other.seed(1)
        assert [one.sample() for _ in range(9)] == [other.sample() for _ in range(9)]

    def test_episodes_after_a_seed_are_drawn_from_it(self):
        env = make()
        drawn = [[env.reset(seed=1)[1]["seed"], *(env.reset()[1]["seed"] for _ in range(2))] for _ in range(2)]
        assert drawn[0] == drawn[1]
        assert len(set(drawn[0])) == 3
        assert make(seed=12).reset()[1]["seed"] == 12

    def test_options_of_reset_hold_for_one_episode(self):
        env = make()
        fault = {"kind": "dancer_late", "target": "dancer_2", "value": 0.5}
        env.reset(seed=1, options={"humans": "one-late", "faults": [fault]})
        config = env.unwrapped.session.config
        assert config.humans == "one-late"
        assert config.faults[0].value == 0.5
        env.reset(seed=1)
        assert env.unwrapped.session.config == dataclasses.replace(env.unwrapped.config, seed=1)


class TestBadInput:
    """What is not allowed is named in an error of Gymnasium's."""

    @pytest.mark.parametrize("action", [4, -1, 0.5, np.nan, "forward", None, [1], np.array([1, 2])])
    def test_discrete_actions(self, action):
        env = make()
        env.reset(seed=0)
        with pytest.raises(error.InvalidAction, match="1 forward"):
            env.step(action)

    @pytest.mark.parametrize(
        ("action", "named"),
        [([0.7, 0], "v = 0.7"), ([0, -4], "omega = -4"), ([np.nan, 0], "v = nan"), ([0], "v .m/s. and omega"),
         ("go", "v .m/s. and omega"), (None, "v .m/s. and omega"), ([0, np.inf], "omega = inf")],
    )  # fmt: skip
    def test_continuous_actions(self, action, named):
        env = make("sjasim/DanceContinuous-v0")
        env.reset(seed=0)
        with pytest.raises(error.InvalidAction, match=named):
            env.step(action)

    @pytest.mark.parametrize(
        ("options", "named"),
        [({"iteratoins": 2}, "did you mean 'iterations'"), ({"iterations": 0}, "iterations"),
         ({"sensors": {"rate": 3}}, "sensors.rate"), ({"method": "none"}, "humans|robot"), ({"step_hz": 0}, "step_hz"),
         ({"reward": {"timming": 1.0}}, "reward.timming"), ({"reward": {"drift": np.nan}}, "reward.drift"),
         ({"layout": "rows", "dancers": 9}, "dancers"), ({"method": "tarantella"}, "tarantella"),
         ({"method": "learned"}, "learned.policy"), ({"humans": "nobody"}, "nobody"), ({"width": 0}, "0 x 480"),
         ({"height": "tall"}, "640 x tall"), ({"skip_rehearsal": "no"}, "skip_rehearsal"),
         ({"reward": 3}, "reward = 3"),
         ({"config": {"iterations": 3}}, "SessionConfig")],
    )  # fmt: skip
    def test_options_of_make(self, options, named):
        with pytest.raises(error.Error, match=named):
            gym.make("sjasim/Dance-v0", **options)

    @pytest.mark.parametrize(
        ("options", "named"),
        [({"poeple": 3}, "poeple"), ({"people": "all"}, "seed"), ({"humans": "nobody"}, "nobody"),
         ({"faults": [{"kind": "rain", "target": "robot"}]}, "rain"), ({"method": "tarantella"}, "tarantella"),
         (["people"], "mapping")],
    )  # fmt: skip
    def test_options_of_reset(self, options, named):
        with pytest.raises(error.Error, match=named):
            make().reset(options=options)

    def test_calls_in_a_wrong_order(self):
        env = make(dance={"rehearsal": False, "bpm": 180.0, "lead_in_s": 1.0, "tail_s": 0.0}).unwrapped
        with pytest.raises(error.ResetNeeded, match="reset"):
            env.step(0)
        with pytest.raises(error.ResetNeeded, match="reset"):
            _ = env.session
        env.reset(seed=0)
        env.session.advance(env.session.end_s - 0.01)
        env._steps = int(env.session.end_s * 30)
        assert env.step(0)[2]
        with pytest.raises(error.ResetNeeded, match="over"):
            env.step(0)
        env.close()
        for call in (env.reset, lambda: env.step(0)):
            with pytest.raises(error.ClosedEnvironmentError):
                call()


@pytest.mark.parametrize("context", ["spawn", "forkserver"])
def test_an_environment_in_another_process_observes_the_same(context):
    if context not in multiprocessing.get_all_start_methods():
        pytest.skip(f"no {context} here")
    envs = gym.make_vec(
        "sjasim/DanceFlat-v0", num_envs=1, vectorization_mode="async", vector_kwargs={"context": context}, **FAST
    )
    envs.reset(seed=2)
    observations = envs.step(np.array([1]))[0]
    envs.close()

    env = make("sjasim/DanceFlat-v0")
    env.reset(seed=2)
    assert np.array_equal(observations[0], env.step(1)[0])


def with_opengl(env):
    """The environment, after a reset; skips the test without OpenGL."""
    env.reset(seed=0)
    try:
        env.render()
    except error.DependencyNotInstalled as missing:
        pytest.skip(str(missing))
    return env


def test_record_video_gets_a_frame_of_every_step(monkeypatch, tmp_path):
    """The package moviepy, which writes the file, need not be installed: a fake one collects the frames."""
    videos = []

    class Clip:
        def __init__(self, frames, fps):
            videos.append((np.array(frames), fps))

        def write_videofile(self, path, **_):
            assert str(tmp_path) in path

    library, clips = types.ModuleType("moviepy"), types.ModuleType("moviepy.video.io.ImageSequenceClip")
    clips.ImageSequenceClip = Clip
    for name in ("moviepy", "moviepy.video", "moviepy.video.io"):
        monkeypatch.setitem(sys.modules, name, library)
    monkeypatch.setitem(sys.modules, clips.__name__, clips)

    env = with_opengl(make(render_mode="rgb_array", width=160, height=120, step_hz=10))
    env = RecordVideo(env, str(tmp_path / "videos"), episode_trigger=lambda _: True)
    env.reset(seed=0)
    for _ in range(3):
        env.step(0)
    env.close()
    ((frames, fps),) = videos
    assert frames.shape == (4, 120, 160, 3)
    assert fps == 10
    assert frames[0].std() > 10


def test_gymnasiums_wrappers_can_be_applied():
    env = RecordEpisodeStatistics(FlattenObservation(TimeLimit(make(step_hz=5), max_episode_steps=4)))
    observation, _ = env.reset(seed=1)
    assert observation in env.observation_space
    for _ in range(4):
        _, _, terminated, truncated, info = env.step(0)
    assert (terminated, truncated, info["episode"]["l"]) == (False, True, 4)
    driven = RescaleAction(make("sjasim/DanceContinuous-v0"), np.float32(-1.0), np.float32(1.0))
    driven.reset(seed=1)
    driven.step(np.ones(2, dtype=np.float32))
    assert driven.unwrapped.session.dispatcher.current.speed_m_s == pytest.approx(0.65)


def test_pictures_have_the_requested_size():
    env = with_opengl(make(render_mode="rgb_array", width=160, height=120))
    picture = env.render()
    assert picture.shape == (120, 160, 3)
    assert picture.dtype == np.uint8
    assert picture.std() > 10
    env.close()


def test_without_opengl_the_error_names_the_package(monkeypatch):
    def missing(*_):
        raise AttributeError("no GLContext")

    monkeypatch.setattr("mujoco.Renderer", missing)
    env = make(render_mode="rgb_array")
    env.reset(seed=0)
    with pytest.raises(error.DependencyNotInstalled, match="libegl1"):
        env.render()


def test_human_rendering_without_a_display_is_refused(monkeypatch):
    monkeypatch.setattr(sys, "platform", "linux")
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    with pytest.raises(error.Error, match="display"):
        gym.make("sjasim/Dance-v0", render_mode="human")


def test_an_unknown_render_mode_is_refused():
    with pytest.raises(error.UnsupportedMode, match="ansi"):
        make(render_mode="ansi")
