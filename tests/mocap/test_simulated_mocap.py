"""True poses as a motion-capture system would tell them."""

from dataclasses import replace

import numpy as np
import pytest

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import Pose
from crazychoir_fw.mocap import Estimator, MocapConfig, SimulatedMocap

LEVEL = np.array([0.0, 0.0, 0.0, 1.0])
CALM = replace(MocapConfig.default(), position_noise=0.0, attitude_noise=0.0, latency=0.0)


def run(mocap, truth, steps, dt=0.001):
    """Return what arrives, with when."""
    return [(k * dt, seen) for k in range(steps) for seen in mocap.step(k * dt, truth)]


def still(count):
    return Pose(np.zeros((count, 3)), np.tile(LEVEL, (count, 1)))


def test_its_numbers_are_those_of_the_vehicle_model():
    config = MocapConfig.default()
    assert (config.rate, config.latency) == (100.0, 0.008)
    assert (config.position_noise, config.attitude_noise) == (0.001, 0.002)
    assert (config.dropout, config.outlier, config.outlier_size) == (0.0, 0.0, 0.5)


def test_without_noise_it_tells_the_truth_at_its_rate():
    truth = Pose(np.array([1.0, 2.0, 3.0]), LEVEL)
    seen = run(SimulatedMocap(CALM), truth, 100)
    assert len(seen) == 10
    np.testing.assert_allclose([pose.time for _, pose in seen], 0.01 * np.arange(10), atol=1e-12)
    np.testing.assert_array_equal(seen[3][1].position, truth.position)
    np.testing.assert_array_equal(seen[3][1].orientation, LEVEL)


def test_poses_come_late_and_say_when_they_were():
    for when, pose in run(SimulatedMocap(replace(CALM, latency=0.025)), still(1), 200):
        assert when - pose.time == pytest.approx(0.025)


def test_the_grid_of_frames_does_not_drift_with_steps_that_do_not_fit():
    seen = run(SimulatedMocap(CALM), still(1), 1054, dt=0.0095)  # 10 s
    assert len(seen) == 1001
    mocap = SimulatedMocap(replace(CALM, rate=30.0))
    assert len(run(mocap, still(1), 10_001)) == 301


def test_after_a_pause_there_is_one_frame():
    mocap = SimulatedMocap(CALM)
    mocap.step(0.0, still(1))
    assert len(mocap.step(5.0, still(1))) == 1
    assert len(mocap.step(5.005, still(1))) == 0
    assert len(mocap.step(5.01, still(1))) == 1


def test_noise_has_the_strength_that_was_asked_for():
    config = replace(MocapConfig.default(), position_noise=0.01, attitude_noise=0.02, latency=0.0)
    seen = run(SimulatedMocap(config, seed=2), still(10), 3000)
    positions = np.array([pose.position for _, pose in seen])
    assert positions.std() == pytest.approx(0.01, rel=0.03)
    turns = 2.0 * np.array([pose.orientation for _, pose in seen])[..., :3]
    assert turns.std() == pytest.approx(0.02, rel=0.03)


def test_drops_and_outliers_are_as_frequent_as_asked_for():
    config = replace(CALM, dropout=0.2, outlier=0.1, outlier_size=0.4)
    positions = np.array([pose.position for _, pose in run(SimulatedMocap(config, seed=5), still(20), 3000)])
    lost = np.isnan(positions[..., 0])
    assert lost.mean() == pytest.approx(0.2, abs=0.02)
    error = np.linalg.norm(positions[~lost], axis=-1)
    assert (error > 0.0).mean() == pytest.approx(0.1, abs=0.02)
    assert error[error > 0.0].min() >= 0.1 and error.max() <= 0.4


def test_the_dice_of_a_drone_are_its_own():
    config = replace(MocapConfig.default(), dropout=0.1, outlier=0.1)
    few, many = SimulatedMocap(config, seed=7), SimulatedMocap(config, seed=7)
    many.occlude([0])
    for (_, a), (_, b) in zip(run(few, still(2), 500), run(many, still(5), 500), strict=True):
        np.testing.assert_array_equal(a.position[1], b.position[1])
        assert np.isnan(b.position[0]).all()


def test_the_same_seed_sees_the_same_and_another_one_does_not():
    def positions(seed):
        return np.array([pose.position for _, pose in run(SimulatedMocap(seed=seed), still(2), 200)])

    np.testing.assert_array_equal(positions(1), positions(1))
    assert (positions(1) != positions(2)).all()


def test_whom_the_cameras_see_again_comes_back():
    mocap = SimulatedMocap(CALM)
    mocap.occlude([0])
    assert np.isnan(mocap.step(0.0, still(1))[0].position).all()
    mocap.reveal([0])
    assert not np.isnan(mocap.step(0.01, still(1))[0].position).any()


def test_the_estimator_finds_the_velocity_behind_noise_drops_and_wrong_markers():
    config = replace(MocapConfig.default(), dropout=0.05, outlier=0.02)
    mocap, estimator = SimulatedMocap(config, seed=3), Estimator()
    errors = []
    for k in range(3000):
        t = 0.001 * k
        for pose in mocap.step(t, Pose(np.array([np.sin(t), np.cos(t), 0.5 * t]), LEVEL)):
            estimate = estimator.update(pose)
            if pose.time > 0.3:
                t0 = estimate.time
                errors.append(estimate.velocity - np.array([np.cos(t0), -np.sin(t0), 0.5]))
    # 1 mm of noise becomes 40 1/s sqrt(2 / (1 + 0.6)) 1 mm = 0.045 m/s; a delay of 20 ms at 1 m/s^2 adds to it
    assert np.sqrt(np.mean(np.square(errors))) < 0.07


@pytest.mark.parametrize(
    ("wrong", "word"),
    [
        ({"rate": 0.0}, "rate is 0.0"),
        ({"latency": -1.0}, "latency"),
        ({"dropout": 1.5}, "dropout"),
        ({"outlier": np.nan}, "outlier"),
    ],
)
def test_what_is_no_system_is_refused(wrong, word):
    with pytest.raises(RangeError, match=word):
        replace(MocapConfig.default(), **wrong)
