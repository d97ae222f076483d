"""Both safety filters: rows, optimum, braking, and flights where each agent's goal is another's place."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import Pose
from crazychoir_fw.control.safety import ClosestRobotGetter, DoubleIntegratorCBF, SingleIntegratorCBF


def crowd(seed, count, near):
    """Return random agents and the neighbors of each; some have no neighbors."""
    dice = np.random.default_rng(seed)
    own = Pose(position=dice.uniform(-1, 1, (count, 3)), velocity=dice.uniform(-0.1, 0.1, (count, 3)))
    others = own.position[:, None] + dice.uniform(-1.5, 1.5, (count, near, 3))
    others[dice.random((count, near)) < 0.2] = np.nan
    return dice.uniform(-0.3, 0.3, (count, 3)), own, Pose(position=others, velocity=np.zeros_like(others))


CASES = {"seed": st.integers(0, 10_000), "near": st.integers(0, 5)}


def half_planes(filter_, own, others, i):
    known = ~np.isnan(others.position[i, :, 0])
    offset = own.position[i, :2] - others.position[i, known, :2]
    closing = own.velocity[i, :2] - others.velocity[i, known, :2]
    return filter_.rows(offset) if isinstance(filter_, SingleIntegratorCBF) else filter_.rows(offset, closing)


@pytest.mark.parametrize("kind", [SingleIntegratorCBF, DoubleIntegratorCBF])
@given(**CASES)
def test_solutions_satisfy_all_constraints(kind, seed, near):
    filter_ = kind()
    limit = getattr(filter_, "max_velocity", None) or filter_.max_acceleration
    desired, own, others = crowd(seed, 8, near)
    safe = filter_.filter(desired, own, others)
    np.testing.assert_array_equal(safe[:, 2], desired[:, 2])
    for i in np.flatnonzero(~filter_.braking):
        A, b = half_planes(filter_, own, others, i)
        assert np.all(A @ safe[i, :2] <= b + 1e-8)
        assert np.abs(safe[i, :2]).max() <= limit + 1e-12


@pytest.mark.parametrize("kind", [SingleIntegratorCBF, DoubleIntegratorCBF])
@given(**CASES)
def test_one_by_one_and_all_at_once_are_the_same(kind, seed, near):
    filter_ = kind()
    desired, own, others = crowd(seed, 5, near)
    together = filter_.filter(desired, own, others)
    braking, least = filter_.braking, filter_.least_barrier
    for i in range(5):
        neighbors = {
            k: Pose(position=others.position[i, k], velocity=others.velocity[i, k])
            for k in range(near)
            if not np.isnan(others.position[i, k, 0])
        }
        alone = filter_.filter(desired[i], Pose(position=own.position[i], velocity=own.velocity[i]), neighbors)
        np.testing.assert_allclose(alone, together[i], atol=1e-12)
        assert filter_.braking == braking[i]
        assert filter_.least_barrier == pytest.approx(least[i])


def test_nobody_near_changes_only_what_is_too_much():
    far = Pose(position=np.full((1, 3), 50.0))
    own = Pose(position=np.zeros(3))
    filter_ = SingleIntegratorCBF(max_velocity=0.2)
    np.testing.assert_array_equal(filter_.filter([0.1, 0.5, 7.0], own, far), [0.1, 0.2, 7.0])
    np.testing.assert_array_equal(filter_.filter([0.1, 0.5], own, {}), [0.1, 0.2])


def test_velocity_row_of_the_table():
    offset = np.array([0.6, 0.0])
    A, b = SingleIntegratorCBF(distance=0.4, gamma=5.0).rows(offset)
    np.testing.assert_allclose(A, [-1.2, 0.0])
    assert b == pytest.approx(5.0 * (0.36 - 0.16) ** 3)


def test_acceleration_row_of_the_table():
    """With `legacy`, the row is that of the table divided by the distance."""
    offset, closing = np.array([0.8, 0.6]), np.array([-0.1, 0.05])
    filter_ = DoubleIntegratorCBF(distance=0.4, gamma=0.1, kappa=1.0, max_acceleration=0.1, legacy=True)
    A, b = filter_.rows(offset, closing)
    dot = offset @ closing
    h = dot + np.sqrt(0.2 * 0.6)
    table = 0.5 * (0.1 * h**3 - dot**2 + closing @ closing + 0.2 * dot / np.sqrt(2 * 0.2 * 0.6))
    np.testing.assert_allclose(A, -offset)
    assert b == pytest.approx(table)


@given(seed=st.integers(0, 10_000))
def test_acceleration_row_is_the_derivative_of_the_barrier(seed):
    """Two agents at the edge of their rows: h falls as fast as it may, -gamma h^3."""
    dice = np.random.default_rng(seed)
    filter_ = DoubleIntegratorCBF(gamma=0.7)
    offset, closing = dice.uniform(0.5, 1.0, 2), dice.uniform(-0.2, 0.2, 2)
    A, b = filter_.rows(offset, closing)
    u = A * b  # on the boundary, for A has length 1
    dt = 1e-6
    later = filter_.barriers(offset + dt * closing, closing + dt * 2 * u)
    before = filter_.barriers(offset - dt * closing, closing - dt * 2 * u)
    h = filter_.barriers(offset, closing)
    assert (later - before) / (2 * dt) == pytest.approx(-0.7 * h**3, abs=1e-6)


def test_saturated_solutions_are_no_failures():
    filter_ = DoubleIntegratorCBF()
    own = Pose(position=np.zeros(3), velocity=np.zeros(3))
    other = {1: Pose(position=np.array([2.0, 0, 0]), velocity=np.zeros(3))}
    np.testing.assert_allclose(filter_.filter([-1.0, 0.0, 0.0], own, other), [-0.1, 0.0, 0.0])
    assert not filter_.braking


def test_who_is_too_near_backs_off():
    filter_ = SingleIntegratorCBF()
    own = Pose(position=np.zeros(3))
    near = {1: Pose(position=np.array([0.3, 0.0, 0.0])), 2: Pose(position=np.array([0.0, 0.55, 0.0]))}
    np.testing.assert_allclose(filter_.filter([1.0, 1.0, 0.0], own, near), [-0.4, 0.0, 0.0], atol=1e-12)
    assert filter_.braking
    assert filter_.least_barrier == pytest.approx(0.09 - 0.16)


def test_who_cannot_stop_in_time_brakes():
    filter_ = DoubleIntegratorCBF()
    own = Pose(position=np.zeros(3), velocity=np.array([0.9, 0.0, 0.0]))
    other = {1: Pose(position=np.array([0.6, 0.0, 0.0]), velocity=np.zeros(3))}
    np.testing.assert_allclose(filter_.filter([0.1, 0.1, 0.0], own, other), [-0.2, 0.0, 0.0])
    assert filter_.braking


def test_who_rests_too_near_may_leave_but_not_come_nearer():
    filter_ = DoubleIntegratorCBF()
    own = Pose(position=np.zeros(3), velocity=np.zeros(3))
    other = {1: Pose(position=np.array([0.35, 0.0, 0.0]), velocity=np.zeros(3))}
    np.testing.assert_allclose(filter_.filter([-0.05, 0.02, 0.0], own, other), [-0.05, 0.02, 0.0])
    np.testing.assert_allclose(filter_.filter([0.05, 0.02, 0.0], own, other), [0.0, 0.02, 0.0], atol=1e-12)


def swap(filter_, count, seed, seconds, dt=0.02, sensing_distance=3.0):
    """Fly all agents to the opposite place of a circle; return the min distance (m) and the final positions."""
    angle = 2 * np.pi * np.arange(count) / count
    radius = max(1.0, 0.12 * count)
    position = radius * np.stack([np.cos(angle), np.sin(angle), 1 / radius + 0 * angle], axis=1)
    position[:, :2] += np.random.default_rng(seed).normal(0, 0.05, (count, 2))
    goal = np.roll(position, -(count // 2), axis=0)
    velocity, least = np.zeros_like(position), np.inf
    getter = ClosestRobotGetter(sensing_distance)
    for _ in range(int(seconds / dt)):
        if isinstance(filter_, SingleIntegratorCBF):
            position = position + dt * filter_.filter_swarm(goal - position, Pose(position=position), getter)
        else:
            wish = 0.2 * (goal - position) - 0.6 * velocity
            u = filter_.filter_swarm(wish, Pose(position=position, velocity=velocity), getter)
            position = position + dt * velocity + 0.5 * dt**2 * u
            velocity = velocity + dt * u
        apart = np.linalg.norm(position[:, None, :2] - position[None, :, :2], axis=-1)
        least = min(least, apart[np.triu_indices(count, 1)].min())
    return least, np.abs(goal - position).max()


@pytest.mark.parametrize("count", [2, 10])
@pytest.mark.parametrize("kind", [SingleIntegratorCBF, DoubleIntegratorCBF])
def test_head_on_swap_keeps_the_distance(kind, count):
    filter_ = kind()
    least, _ = swap(filter_, count, seed=1, seconds=20.0)
    assert least >= filter_.distance


@pytest.mark.parametrize("kind", [SingleIntegratorCBF, DoubleIntegratorCBF])
def test_blind_they_would_collide(kind):
    """The flights above are ones that need the filter."""
    least, _ = swap(kind(), 2, seed=1, seconds=20.0, sensing_distance=0.01)
    assert least < 0.3


def test_two_that_follow_velocities_reach_their_goals():
    _, error = swap(SingleIntegratorCBF(distance=0.3, gamma=5.0), 2, seed=2, seconds=40.0)
    assert error < 0.01


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (lambda: SingleIntegratorCBF(distance=0.0), "distance is 0.0, allowed: above 0 m"),
        (lambda: DoubleIntegratorCBF(kappa=-1.0), "kappa is -1.0"),
        (lambda: SingleIntegratorCBF().filter(1.0, Pose(), {}), "desired input has shape"),
        (lambda: SingleIntegratorCBF().filter([0, 0, 0], Pose(), {}), "own pose: there is no position"),
        (lambda: DoubleIntegratorCBF().filter([0, 0, 0], Pose(position=np.zeros(3)), {}), "there is no velocity"),
        (
            lambda: SingleIntegratorCBF().filter(np.zeros((2, 3)), Pose(position=np.zeros(3)), {}),
            r"own pose: shape is \(\), allowed: \(2,\)",
        ),
        (
            lambda: SingleIntegratorCBF().filter(
                np.zeros((2, 3)), Pose(position=np.zeros((2, 3))), Pose(position=np.zeros((3, 1, 3)))
            ),
            r"other poses have shape \(3, 1\)",
        ),
    ],
)
def test_bad_arguments_are_named(call, says):
    with pytest.raises(RangeError, match=says):
        call()
