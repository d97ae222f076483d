"""Curves in the memory of a Crazyflie, and in files of missions."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import Pose, TrajectoryPoint
from crazychoir_fw.common.trajectory_files import read_pieces
from crazychoir_fw.onboard.trajectories import pack_compressed
from crazychoir_fw.planning import (
    FixedHeading,
    MinimumSnap,
    PathHeading,
    Spline,
    Trajectory,
    cubic_spline,
    fit_drawn,
    minimum_snap,
    to_compressed,
    to_pieces,
)
from crazychoir_fw.simulation import DroneConfig, World

angles = np.linspace(0, 2 * np.pi, 400)
FIGURE8 = np.stack([np.sin(angles), np.sin(2 * angles) / 2, 1 + 0.1 * np.sin(angles)], axis=1)
FINE = fit_drawn(FIGURE8, 3 * angles, distance=0.05).curve  # 140 pieces

curves = st.builds(
    lambda make, intervals, seed: make(
        np.concatenate([[0.0], np.cumsum(intervals)]),
        np.random.default_rng(seed).uniform(-2, 2, (len(intervals) + 1, 3)),
    ),
    st.sampled_from([cubic_spline, minimum_snap]),
    st.lists(st.floats(1.0, 2.0), min_size=1, max_size=12),
    st.integers(0, 100),
)


@settings(max_examples=20)
@given(curves)
def test_pieces_that_fit_are_exact(curve):
    onboard = to_pieces(curve)
    assert len(onboard.rows) == len(curve)
    assert onboard.rows.dtype == np.float32
    assert onboard.position_error < 1e-4
    assert onboard.yaw_error == 0.0


@settings(max_examples=20)
@given(curves)
def test_compressed_trajectories_are_off_by_millimeters(curve):
    onboard = to_compressed(curve)
    # 1 mm each of rounding and of shorter forms, on three axes; half a millisecond of time
    fastest = np.linalg.norm(curve.velocity(np.linspace(0, curve.duration, 200)), axis=1).max()
    assert onboard.position_error < 2e-3 * 3**0.5 + 1e-3 * fastest
    assert onboard.size == len(pack_compressed(onboard.start, onboard.segments))


def test_more_pieces_than_the_memory_holds_are_fitted():
    assert len(FINE) > 100
    onboard = to_pieces(FINE)
    assert len(onboard.rows) == 31
    assert onboard.position_error < 0.002
    few = to_pieces(FINE, max_pieces=6)
    assert len(few.rows) == 6
    assert onboard.position_error < few.position_error < 0.2
    # what is fitted joins
    rows = few.rows.astype(float)
    ends = rows[:, :-1].reshape(-1, 4, 8) @ (rows[:, -1:] ** np.arange(8))[:, :, None]
    np.testing.assert_allclose(ends[:-1, :, 0], rows[1:, :-1].reshape(-1, 4, 8)[:, :, 0], atol=1e-5)
    with pytest.raises(RangeError, match="max_pieces is 0"):
        to_pieces(FINE, max_pieces=0)


def test_compressed_trajectories_fit_the_memory():
    # three axes of degree 7 take 45 bytes a piece
    finer = minimum_snap(np.arange(100.0), np.random.default_rng(1).uniform(-1, 1, (100, 3)))
    onboard = to_compressed(finer)
    assert onboard.size <= 4096
    assert len(onboard.segments) < len(finer)
    # a tenth of the pieces have to go
    assert onboard.position_error < 0.02


@pytest.mark.parametrize("make", [to_pieces, to_compressed])
def test_yaw_along_the_path_is_cut_until_it_fits(make):
    curve = minimum_snap([0, 4, 8], [[0, 0, 1], [2, 0, 1], [2, 2, 1]])
    onboard = make(Trajectory(curve, PathHeading(curve)))
    assert onboard.yaw_error < 0.02
    assert len(getattr(onboard, "rows", getattr(onboard, "segments", ()))) > 2
    assert make(Trajectory(curve, FixedHeading(0.5))).yaw_error < 0.002


def test_missions_read_what_is_written(tmp_path):
    onboard = to_pieces(FINE)
    onboard.write(tmp_path / "figure8.csv")
    np.testing.assert_allclose(read_pieces(tmp_path / "figure8.csv"), onboard.rows, rtol=1e-6, atol=1e-12)


def point(time, *position):
    return TrajectoryPoint(time, np.array(position, dtype=float))


PATH = [point(1.5, 0.4, 0.0, 1.0), point(3.0, 0.4, 0.5, 1.2), point(4.6, -0.2, 0.1, 0.9)]


TOLD = ("ctrltarget.x", "ctrltarget.y", "ctrltarget.z", "controller.yaw")


@pytest.fixture(scope="module")
def hovering():
    """A world with a drone in the air."""
    world = World([DroneConfig("cf1", (0.0, 0.0))], seed=1)
    world.wait_until_ready()
    world.drones[0].high_level_commander.takeoff(1.0, 2.0)
    world.run(3.0)
    return world, world.snapshot()


@pytest.mark.parametrize("is_compressed", [False, True])
@pytest.mark.parametrize("make", [Spline, lambda: MinimumSnap(yaw="path")])
def test_the_onboard_planner_says_the_same_as_the_handler(make, is_compressed, hovering):
    world, start = hovering
    world.restore(start)
    drone = world.drones[0]
    commander = drone.high_level_commander
    handler = make()
    home = Pose(np.array([drone.log[f"ctrltarget.{axis}"] for axis in "xyz"]))
    handler.set_trajectory(PATH, home, world.time)
    if is_compressed:
        onboard = to_compressed(handler.trajectory)
        commander.upload_compressed_trajectory(1, onboard.start, onboard.segments)
    else:
        commander.upload_trajectory(1, to_pieces(handler.trajectory).rows)
    commander.start_trajectory(1)

    positions, yaws = [], []
    for _ in range(480):
        world.step(10)
        told = np.array([drone.log[name] for name in TOLD])
        # the onboard planner looks at its own clock, every 10 ms
        near = [handler.evaluate(world.time - late) for late in np.arange(0.02, -0.001, -0.001)]
        positions.append(min(np.linalg.norm(told[:3] - reference.position) for reference in near))
        turns = [np.degrees(reference.yaw) - told[3] for reference in near]
        yaws.append(min(abs((turn + 180) % 360 - 180) for turn in turns))
    assert max(positions) < (0.003 if is_compressed else 0.0005)
    assert max(yaws) < 1.0
    np.testing.assert_allclose(told[:3], PATH[-1].position, atol=0.002)
