"""Swarms as PettingZoo's checkers see them, and what drones see of each other."""

import warnings

import numpy as np
import pytest
from pettingzoo.test import parallel_api_test, parallel_seed_test

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.learning import Swap, Swarm, Velocity
from crazychoir_fw.learning.parallel_env import SwarmEnv

FEW = {"variants": 2}


@pytest.mark.parametrize("name", ["Swarm", "Swap"])
def test_the_api_test_has_nothing_to_say(name):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        parallel_api_test(SwarmEnv(name, episode_s=0.5, **FEW), num_cycles=100)


def test_a_seed_decides_everything():
    parallel_seed_test(lambda: SwarmEnv(Swarm(**FEW, episode_s=1.0)), num_cycles=30)


def test_drones_see_their_nearest_neighbors_first():
    env = SwarmEnv(Swarm(**FEW, drones=5, neighbors=2, radius=1.0, start_box=(0.0, 0.0, 0.0)))
    found, _ = env.reset(seed=1)
    own = env.task.observation.size
    seen = found["drone0"][own:].reshape(2, 6)
    side = 2.0 * np.sin(np.pi / 5)
    assert np.allclose(np.linalg.norm(seen[:, :3], axis=1), side, atol=0.01)
    assert found["drone0"] in env.observation_space("drone0")


def test_drones_that_meet_are_out_and_the_others_fly_on():
    task = Swap(**FEW, drones=4, action=Velocity(max_speed=1.0), start_box=(0.0, 0.0, 0.0))
    env = SwarmEnv(task)
    env.reset(seed=1)
    ended = {}
    while env.agents:
        goals = env.flights.reading.reference.position - env.flights.reading.estimate.position
        # the first two fly to their goals straight through the middle, the others stay
        numbers = {agent: env.possible_agents.index(agent) for agent in env.agents}
        actions = {agent: np.append(np.clip(goals[n], -1, 1), 0.0) * (n in (0, 2)) for agent, n in numbers.items()}
        _, rewards, terminated, truncated, _ = env.step({k: v.astype(np.float32) for k, v in actions.items()})
        assert all(np.isfinite(reward) for reward in rewards.values())
        ended |= {agent: "out" for agent, is_out in terminated.items() if is_out}
        ended |= {agent: "late" for agent, is_late in truncated.items() if is_late}
    assert ended["drone0"] == ended["drone2"] == "out"
    assert ended["drone1"] == ended["drone3"] == "late"


def test_wrong_use_ends_in_one_sentence():
    env = SwarmEnv(Swarm(**FEW))
    env.reset(seed=0)
    with pytest.raises(RangeError, match="there is no action of 'drone1'"):
        env.step({"drone0": np.zeros(4)})
    with pytest.raises(RangeError, match="drone0: action has shape"):
        env.step({agent: np.zeros(3) for agent in env.agents})
    with pytest.raises(RangeError, match="allowed: a SwarmTask"):
        SwarmEnv("Hover")
    with pytest.raises(RangeError, match="neighbors is 4, allowed: 0 to 3"):
        Swarm(neighbors=4)
