"""Spirals and compressed trajectories flown by a simulated drone (docs/reference/planner-commander.md#5 and #6.5)."""

import math
from pathlib import Path

import numpy as np
import pytest
from test_acceptance import hovering, record, reference_world

from crazychoir_fw.common.trajectory_files import read_pieces
from crazychoir_fw.onboard.trajectories import compress, pack_compressed

FIGURE8 = Path(__file__).parents[2] / "examples" / "figure8.csv"


def yaw(drone):
    w, x, y, z = drone.true_quat_wxyz
    return math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))


@pytest.mark.parametrize("sideways", [False, True])
@pytest.mark.parametrize("clockwise", [False, True])
def test_spiral_is_flown_about_its_axis(sideways, clockwise):
    world = reference_world(drag="none")
    drone = hovering(world)
    drone.high_level_commander.go_to(0, 0, 1, 0, 1.0)
    world.run(3.0)
    drone.high_level_commander.spiral(math.pi, 0.6, 0.6, 0.5, 6.0, sideways=sideways, clockwise=clockwise)
    _, samples = record(world, 6.0, lambda: [*drone.true_position, yaw(drone)])
    world.run(3.0)

    # the axis: ahead (sideways clockwise), behind, to the right (clockwise) or to the left
    side = 1.0 if clockwise else -1.0
    axis = np.array([0.6 * side, 0.0] if sideways else [0.0, -0.6 * side])
    radius = np.linalg.norm(samples[:, :2] - axis, axis=1)
    assert np.abs(radius - 0.6).max() < 0.2
    assert drone.true_position == pytest.approx([*(2 * axis), 1.5], abs=0.06)
    turned = np.unwrap(samples[:, 3])[-1]
    assert turned == pytest.approx(-side * math.pi, abs=0.3)


def test_compressed_figure8_is_flown_like_the_uncompressed_one():
    pieces = read_pieces(FIGURE8)
    start, segments = compress(pieces)
    assert len(pack_compressed(start, segments)) < pieces.nbytes / 4

    paths = []
    for is_compressed in (False, True):
        world = reference_world(drag="none")
        drone = hovering(world)
        commander = drone.high_level_commander
        if is_compressed:
            duration = commander.upload_compressed_trajectory(1, start, segments, offset=3)
        else:
            duration = commander.upload_trajectory(1, pieces)
        commander.start_trajectory(1, relative_position=True)
        _, path = record(world, duration, lambda drone=drone: drone.true_position)
        assert commander.is_trajectory_finished
        paths.append(path)
        world.run(1.0)
        commander.land(0.0, 2.0)
        world.run(3.0)
        assert drone.true_position[2] < 0.03
        assert drone.failure is None

    plain, compressed = paths
    assert np.ptp(plain[:, 0]) > 1.5
    assert np.ptp(plain[:, 1]) > 0.7
    common = min(len(plain), len(compressed))  # durations are whole milliseconds
    assert np.abs(plain[:common] - compressed[:common]).max() < 0.02


def test_spiral_goes_over_into_a_landing():
    """A smooth go-to brakes where the spiral ends; the landing then starts at rest."""
    world = reference_world(drag="none")
    drone = hovering(world)
    commander = drone.high_level_commander
    commander.spiral(2.0, 0.5, 0.3, 0.2, 4.0)
    world.run(4.0)
    commander.go_to(0.0, 0.0, 1.0, 0.0, 3.0)
    world.run(5.0)
    assert drone.true_position == pytest.approx([0.0, 0.0, 1.0], abs=0.05)
    commander.land(0.0, 2.0)
    world.run(3.0)
    assert drone.true_position[2] < 0.03
    assert drone.log["motor.m1"] == 0
