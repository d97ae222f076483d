"""An agent that is blocked passes on the right: still safe, and no agent waits forever."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import Pose
from crazychoir_fw.control.safety import ClosestRobotGetter, DoubleIntegratorCBF, SingleIntegratorCBF

KINDS = [SingleIntegratorCBF, DoubleIntegratorCBF]
STEP = 0.04  # [s]


def rows_of(filter_, offset, closing):
    return filter_.rows(offset) if isinstance(filter_, SingleIntegratorCBF) else filter_.rows(offset, closing)


@pytest.mark.parametrize("kind", KINDS)
@given(seed=st.integers(0, 10_000), near=st.integers(1, 5), keep_right=st.floats(0.0, 3.0))
def test_no_barrier_falls_faster_than_it_may(kind, seed, near, keep_right):
    filter_ = kind(keep_right=keep_right)
    dice = np.random.default_rng(seed)
    own = Pose(position=np.zeros((8, 3)), velocity=dice.uniform(-0.1, 0.1, (8, 3)))
    others = Pose(position=dice.uniform(-1.5, 1.5, (8, near, 3)), velocity=dice.uniform(-0.1, 0.1, (8, near, 3)))
    safe = filter_.filter(dice.uniform(-0.3, 0.3, (8, 2)), own, others)
    for i in np.flatnonzero(~filter_.braking):
        offset = -others.position[i, :, :2]
        A, b = rows_of(filter_, offset, own.velocity[i, :2] - others.velocity[i, :, :2])
        assert np.all(A @ safe[i] <= b + 1e-8)
        assert np.abs(safe[i]).max() <= filter_.limit + 1e-12


@pytest.mark.parametrize("kind", KINDS)
def test_who_is_not_held_up_flies_as_without(kind):
    own = Pose(position=np.zeros(3), velocity=np.zeros(3))
    behind = {1: Pose(position=np.array([-0.7, 0.0, 0.0]), velocity=np.zeros(3))}
    wish = [0.05, 0.02, 0.0]
    np.testing.assert_array_equal(kind(keep_right=1.0).filter(wish, own, behind), wish)


@pytest.mark.parametrize("kind", KINDS)
def test_what_is_taken_away_goes_to_the_right(kind):
    own = Pose(position=np.zeros(3), velocity=np.zeros(3))
    ahead = {1: Pose(position=np.array([0.49, 0.0, 0.0]), velocity=np.zeros(3))}
    left = kind().filter([0.1, 0.0, 0.0], own, ahead)
    right = kind(keep_right=1.0).filter([0.1, 0.0, 0.0], own, ahead)
    assert left[1] == 0.0
    assert right[0] == pytest.approx(left[0])
    assert right[1] == pytest.approx(left[0] - 0.1)


def test_a_negative_part_is_refused():
    with pytest.raises(RangeError, match=r"keep_right is -1.0, allowed: 0 or more"):
        SingleIntegratorCBF(keep_right=-1.0)


def fly(filter_, position, goal, seconds, wish=None):
    """Let ideal agents fly; return their least distance and how far from their goals they end."""
    position, velocity, least = position.copy(), np.zeros_like(position), np.inf
    getter = ClosestRobotGetter(3.0)
    first, second = np.triu_indices(len(position), 1)
    for k in range(int(seconds / STEP)):
        if isinstance(filter_, SingleIntegratorCBF):
            u = goal - position if wish is None else wish(k)
            position = position + STEP * filter_.filter_swarm(u, Pose(position=position), getter)
        else:
            u = 0.3 * (goal - position) - 0.9 * velocity if wish is None else wish(k)
            u = filter_.filter_swarm(u, Pose(position=position, velocity=velocity), getter)
            position = position + STEP * velocity + 0.5 * STEP**2 * u
            velocity = velocity + STEP * u
        least = min(least, np.linalg.norm((position[first] - position[second])[:, :2], axis=1).min())
    return least, np.abs(goal - position).max()


def circle(count):
    """Return places of a circle and the opposite ones, in perfect symmetry."""
    angle = 2 * np.pi * np.arange(count) / count
    places = max(1.0, 0.15 * count) * np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    return places, np.roll(places, -(count // 2), axis=0)


@pytest.mark.parametrize("count", [2, 10])
@pytest.mark.parametrize(
    "filter_",
    [
        SingleIntegratorCBF(0.3, 5.0, 0.2, keep_right=1.0),
        DoubleIntegratorCBF(0.3, 5.0, 1.0, 0.5, 0.8, keep_right=1.0),
    ],
    ids=["velocities", "accelerations"],
)
def test_a_perfect_swap_comes_to_an_end(filter_, count):
    least, error = fly(filter_, *circle(count), seconds=24.0)
    assert least >= filter_.distance
    assert error < 0.1


@pytest.mark.parametrize("kind", KINDS)
def test_without_it_a_perfect_swap_does_not(kind):
    least, error = fly(kind(0.3, 5.0), *circle(4), seconds=12.0)
    assert least >= 0.3
    assert error > 0.5


@pytest.mark.parametrize("kind", KINDS)
@settings(max_examples=6)
@given(seed=st.integers(0, 10_000))
def test_ideal_agents_never_come_too_near_whatever_they_want(kind, seed):
    """Everybody wants something else every half second, as fast as it is allowed."""
    filter_ = kind(distance=0.4, keep_right=1.0)
    dice = np.random.default_rng(seed)
    position = np.zeros((4, 3))
    position[:, :2] = 0.8 * np.array([(0, 0), (0, 1), (1, 0), (1, 1)]) + dice.uniform(-0.1, 0.1, (4, 2))
    wishes = dice.uniform(-3.0, 3.0, (20, 4, 3)) * filter_.limit
    least, _ = fly(filter_, position, position, 6.0, lambda k: wishes[k // 12])
    assert least >= 0.4 - 1e-4
