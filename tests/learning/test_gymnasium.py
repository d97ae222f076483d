"""The environments as others check them: Gymnasium's checkers, seeds, autoreset, pictures."""

import warnings

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode

from crazychoir_fw.common.errors import CrazychoirError, RangeError, StateError, UnknownNameError
from crazychoir_fw.learning import Hover, Observation
from crazychoir_fw.learning.registration import NAMES
from crazychoir_fw.learning.single_env import SingleEnv
from crazychoir_fw.learning.vector_env import FlightVectorEnv

FEW = {"variants": 2}


@pytest.mark.parametrize("name", NAMES)
def test_check_env_has_nothing_to_say(name):
    env = gymnasium.make(f"crazychoir/{name}-v0", **FEW).unwrapped
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        # "Box observation space minimum value is -infinity" is what it is
        warnings.filterwarnings("ignore", message=".*infinity.*")
        check_env(env, skip_render_check=True)
    env.close()


def test_a_critic_sees_the_truth_beside_the_policy():
    task = Hover(**FEW, critic=Observation(("position_error", "velocity"), source="truth"))
    env = SingleEnv(task)
    check_env(env, skip_render_check=True)
    found, _ = env.reset(seed=3)
    assert found["critic"].shape == (6,)
    vectors = FlightVectorEnv(task, 3)
    found, _ = vectors.reset(seed=3)
    assert found in vectors.observation_space


def test_make_vec_makes_one_world():
    env = gymnasium.make_vec("crazychoir/Hover-v0", num_envs=5, **FEW)
    assert isinstance(env.unwrapped, FlightVectorEnv)
    assert len(env.unwrapped.flights.world.drones) == 5
    assert env.metadata["autoreset_mode"] == AutoresetMode.SAME_STEP
    first, _ = env.reset(seed=1)
    assert first in env.observation_space
    found, rewards, terminated, truncated, _ = env.step(env.action_space.sample())
    assert found in env.observation_space
    assert rewards.shape == terminated.shape == truncated.shape == (5,)
    assert terminated.dtype == truncated.dtype == bool


def test_a_vector_environment_is_so_many_single_ones():
    """Beside Gymnasium's own vector of single environments, with its autoreset in the same step."""
    task = Hover(**FEW, episode_s=0.25)
    ours = FlightVectorEnv(task, 3)
    theirs = gymnasium.vector.SyncVectorEnv([lambda: SingleEnv(task)] * 3, autoreset_mode=AutoresetMode.SAME_STEP)
    a, _ = ours.reset(seed=10)
    b, _ = theirs.reset(seed=10)
    assert np.array_equal(a, b)
    ended = 0
    for step in range(60):
        action = np.random.default_rng(step).uniform(-1, 1, (3, 4)).astype(np.float32)
        a, *numbers_a, infos_a = ours.step(action)
        b, *numbers_b, infos_b = theirs.step(action)
        assert np.array_equal(a, b)
        for x, y in zip(numbers_a, numbers_b, strict=True):
            assert np.array_equal(x.astype(np.float32), y.astype(np.float32))
        assert ("final_obs" in infos_a) == ("final_obs" in infos_b)
        if "final_obs" in infos_a:
            mask = infos_a["_final_obs"]
            assert np.array_equal(mask, infos_b["_final_obs"])
            ended += mask.sum()
            for row in np.flatnonzero(mask):
                assert np.array_equal(infos_a["final_obs"][row], infos_b["final_obs"][row])
    assert ended >= 6


def test_a_seed_repeats_and_none_goes_on():
    env = SingleEnv(Hover(**FEW))
    first, _ = env.reset(seed=5)
    second, _ = env.reset()
    assert not np.array_equal(first, second)
    again, _ = env.reset(seed=5)
    assert np.array_equal(first, again)
    after, _ = env.reset()
    assert np.array_equal(second, after)


def test_a_mask_begins_some_flights_again():
    env = FlightVectorEnv(Hover(**FEW), 4)
    before, _ = env.reset(seed=1)
    after, _ = env.reset(options={"reset_mask": np.array([True, False, False, True])})
    assert np.array_equal(before[1:3], after[1:3])
    assert not np.array_equal(before[0], after[0])


def test_observations_are_the_callers():
    env = FlightVectorEnv(Hover(**FEW), 2)
    first, _ = env.reset(seed=1)
    kept = first.copy()
    env.step(np.zeros((2, 4), np.float32))
    assert np.array_equal(first, kept)


def test_wrong_use_ends_in_one_sentence():
    env = SingleEnv(Hover(**FEW))
    with pytest.raises(StateError, match=r"call reset\(\) first"):
        env.step(np.zeros(4))
    env.reset(seed=0)
    with pytest.raises(RangeError, match=r"action has shape \(3,\), allowed: \(4,\)"):
        env.step(np.zeros(3))
    with pytest.raises(RangeError, match="number 2 of flight 0 is nan"):
        env.step(np.array([0, 0, np.nan, 0]))
    with pytest.raises(RangeError, match="options name wind"):
        env.reset(options={"wind": 3})
    with pytest.raises(UnknownNameError, match="did you mean 'rate_hz'"):
        SingleEnv("Hover", rate_h=50)
    with pytest.raises(UnknownNameError, match="there is no task 'Land'"):
        SingleEnv("Land")
    with pytest.raises(RangeError, match="render_mode is 'ansi'"):
        SingleEnv("Hover", render_mode="ansi")


def test_gymnasium_is_not_imported_by_the_package_itself():
    import subprocess
    import sys

    code = "import sys, crazychoir_fw, crazychoir_fw.cli; assert 'gymnasium' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_a_recorded_video_shows_the_flight(tmp_path):
    try:
        env = gymnasium.make("crazychoir/Hover-v0", render_mode="rgb_array", **FEW)
        env.reset(seed=1)
        picture = env.render()
    except CrazychoirError as error:
        pytest.skip(f"no OpenGL: {error}")
    assert picture.shape == (360, 640, 3)
    assert picture.std() > 10
    pytest.importorskip("moviepy")
    recorded = gymnasium.wrappers.RecordVideo(env, str(tmp_path), disable_logger=True)
    recorded.reset(seed=1)
    for _ in range(5):
        recorded.step(np.zeros(4, np.float32))
    recorded.close()
    assert list(tmp_path.glob("*.mp4"))
