"""Stable-Baselines3 takes the environments; its own checker has nothing to say."""

import warnings

import numpy as np
import pytest

pytest.importorskip("stable_baselines3", reason="extra [train]")

from stable_baselines3 import PPO
from stable_baselines3.common.env_checker import check_env

from crazychoir_fw.learning import Hover
from crazychoir_fw.learning.policy import read_policy
from crazychoir_fw.learning.sb3 import Sb3Flights
from crazychoir_fw.learning.single_env import SingleEnv

FEW = {"variants": 2}


def test_check_env_has_nothing_to_say():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(SingleEnv(Hover(**FEW)), skip_render_check=True)


def test_ppo_learns_a_little_and_its_file_is_read(tmp_path):
    task = Hover(**FEW, episode_s=0.5)
    env = Sb3Flights(task, 8)
    env.seed(1)
    model = PPO("MlpPolicy", env, n_steps=16, batch_size=64, n_epochs=1, seed=0, device="cpu")
    model.learn(1024)
    assert len(model.ep_info_buffer) > 0
    model.save(tmp_path / "p.zip")
    policy = read_policy(tmp_path / "p.zip", task)
    x = np.random.default_rng(0).standard_normal((100, task.observation.size)).astype(np.float32)
    assert np.abs(policy.act(x) - model.predict(x, deterministic=True)[0]).max() < 1e-5
