import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import Pose
from crazychoir_fw.control.safety import ClosestRobotGetter, stacked


@given(seed=st.integers(0, 10_000), count=st.sampled_from([0, 1, 2, 20, 65, 200]), distance=st.sampled_from([0.5, 3.0]))
def test_pairs_are_those_of_all_distances(seed, count, distance):
    dice = np.random.default_rng(seed)
    positions = dice.uniform(-6, 6, (count, 3))
    positions[dice.random(count) < 0.05] = np.nan
    first, second, length = ClosestRobotGetter(distance).pairs(positions)
    every = np.linalg.norm(positions[:, None, :2] - positions[None, :, :2], axis=-1)
    expected = {(i, j) for i, j in np.argwhere(every < distance).tolist() if i < j}
    found = [(min(i, j), max(i, j)) for i, j in zip(first.tolist(), second.tolist(), strict=True)]
    assert set(found) == expected
    assert len(found) == len(expected)
    np.testing.assert_allclose(length, every[first, second])


def test_nearest_comes_first():
    poses = Pose(position=np.array([[0.0, 0, 0], [2.0, 0, 5], [1.0, 0, 0], [9.0, 0, 0]]), velocity=np.zeros((4, 3)))
    getter = ClosestRobotGetter()
    assert getter.neighbors(poses.position).tolist() == [[2, 1], [2, 0], [0, 1], [-1, -1]]
    assert [list(one) for one in getter.closest(poses)] == [[2, 1], [2, 0], [0, 1], []]
    gathered = getter.gathered(poses)
    np.testing.assert_array_equal(gathered.position[0], poses.position[[2, 1]])
    assert np.isnan(gathered.position[3]).all()
    assert np.isnan(gathered.velocity[3]).all()


def test_poses_of_one_agent_stack():
    assert stacked({}).position.shape == (0, 3)
    both = stacked({3: Pose(position=np.ones(3), velocity=np.zeros(3)), 1: Pose(position=np.zeros(3))})
    assert both.position.shape == (2, 3)
    assert both.velocity is None


def test_bad_arguments_are_named():
    with pytest.raises(RangeError, match="sensing_distance is 0"):
        ClosestRobotGetter(0.0)
    with pytest.raises(RangeError, match="no position"):
        ClosestRobotGetter().closest(Pose())
