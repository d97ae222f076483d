"""Drones that swap places through one point, against the closed-loop table of docs/reference/planner-commander.md#12.5.

The ellipsoids of two drones touch at 0.6 m; the table has 0.72 and 0.80 m for a pair and 0.53 to 0.60 m for eight
drones, and asks for 0.5 m with full dynamics. Here the full vehicle flies, with its noise, under the stock PID, and
with poses of the deviations that the firmware has from the factory: the filter then takes drag for speed, 18 % of it,
which damps. With the deviations of a client (3 mm, 40 mrad) velocities are right within 5 %, and drones come closer.
"""

import itertools
from pathlib import Path

import numpy as np
import pytest

from crazychoir_fw.flight.engine import fly
from crazychoir_fw.mission import load_mission
from crazychoir_fw.simulation import DroneConfig, World

EXAMPLES = Path(__file__).parents[2] / "examples"
HEIGHT = 1.0  # [m]
SPEED = 0.5  # [m/s]
LEAST = 0.5  # [m], required distance
FACTORY = {"mocap_std": 0.01, "mocap_attitude_std": 4.5e-3}  # deviations as the firmware has them


def circle(count, radius=2.0, noise=0.0):
    """Return places on a circle (m), shape (N, 2)."""
    angles = 2 * np.pi * np.arange(count) / count
    places = radius * np.column_stack([np.cos(angles), np.sin(angles)])
    return places + np.random.default_rng(1).normal(0.0, 1.0, places.shape) * noise


def hovering(places, controller=None, told=FACTORY, **parameters):
    """Return a world whose drones hover above these places; parameters are set in the air."""
    drones = [
        DroneConfig(f"cf{i + 1}", tuple(place), controller=controller, attributes=told)
        for i, place in enumerate(places)
    ]
    world = World(drones, seed=1, visuals=False)
    world.wait_until_ready()
    for drone in world.drones:
        drone.high_level_commander.takeoff(HEIGHT, 2.0)
    world.run(5.0)
    for drone in world.drones:
        for name, value in parameters.items():
            drone.param[f"colAv.{name}"] = value
    return world


def go_to(drone, goal, is_first):
    """The onboard planner flies to the goal, in 8 s."""
    if is_first:
        drone.high_level_commander.go_to(*goal, 0.0, 8.0)


def position(drone, goal, is_first):
    """The goal itself as a setpoint, far away."""
    drone.commander.send_position_setpoint(*goal, 0.0)


def velocity(drone, goal, is_first):
    """Straight towards the goal."""
    way = goal - drone.estimated_position
    drone.commander.send_velocity_world_setpoint(*(way * min(1.0, SPEED / np.linalg.norm(way))), 0.0)


def closest(world):
    """Return the min distance between two drones (m)."""
    return min(np.linalg.norm(a - b) for a, b in itertools.combinations(world.positions(), 2))


def swap(world, places, command, seconds):
    """Send all drones to the opposite side; return the min distance of the flight and the max from a goal (m)."""
    goals = np.column_stack([-np.asarray(places), np.full(len(places), HEIGHT)])
    least = np.inf
    for i in range(round(seconds * 100)):
        if i % 5 == 0:
            for drone, goal in zip(world.drones, goals, strict=True):
                command(drone, goal, i == 0)
        world.step(10)
        least = min(least, closest(world))
    return least, np.linalg.norm(world.positions() - goals, axis=1).max()


@pytest.mark.parametrize("command", [go_to, position, velocity])
def test_two_swap_places(command):
    places = circle(2)
    least, miss = swap(hovering(places, enable=1), places, command, 22.0)
    assert least >= LEAST
    assert least == pytest.approx(0.75, abs=0.1)  # the table: 0.72 and 0.80 m
    assert miss < 0.1


@pytest.mark.parametrize("command", [go_to, position, velocity])
def test_without_it_they_touch(command):
    places = circle(2)
    least, _ = swap(hovering(places), places, command, 10.0)
    assert least < 0.2


@pytest.mark.parametrize(("command", "seconds"), [(go_to, 40.0), (position, 20.0)])
def test_eight_swap_places(command, seconds):
    places = circle(8, noise=0.01)
    least, miss = swap(hovering(places, enable=1), places, command, seconds)
    # 0.594 to 0.598 m over six seeds, with and without the slow part of the noise of the inertial sensors
    assert least >= LEAST
    assert least == pytest.approx(0.6, abs=0.02)
    assert miss < 0.1


@pytest.mark.parametrize(("controller", "distance"), [("lee", (0.57, 0.60)), ("mellinger", (0.53, 0.56))])
def test_eight_swap_places_under_other_controllers(controller, distance):
    """The rows of the table with full dynamics: 0.57 to 0.59 m with Lee, 0.53 to 0.56 m with Mellinger."""
    places = circle(8, noise=0.01)
    least, miss = swap(hovering(places, controller, enable=1), places, position, 16.0)
    assert distance[0] <= least <= distance[1]
    assert miss < 0.1


@pytest.mark.parametrize(
    ("controller", "pair", "eight"), [("pid", 0.61, 0.51), ("lee", 0.71, 0.52), ("mellinger", 0.65, 0.47)]
)
def test_the_page_says_how_close_drones_come_with_the_poses_of_a_client(controller, pair, eight):
    """docs/collision_avoidance.md; Mellinger's overshoot takes eight drones below the required distance."""
    for places, distance in ((circle(2), pair), (circle(8, noise=0.01), eight)):
        least, miss = swap(hovering(places, controller, told={}, enable=1), places, position, 16.0)
        assert least == pytest.approx(distance, abs=0.02)
        assert miss < 0.1


@pytest.mark.parametrize("controller", ["lee", "mellinger"])
def test_two_swap_places_under_other_controllers(controller):
    """The table has 0.52 to 0.72 m; here the pair keeps more distance."""
    places = circle(2)
    least, miss = swap(hovering(places, controller, enable=1), places, position, 16.0)
    assert 0.52 <= least <= 0.85
    assert miss < 0.1


def test_eight_that_only_know_a_direction_keep_apart_though_they_may_wait_in_a_ring():
    """Velocities of 0.5 m/s that all point to the middle: 1 cm does not resolve the symmetry, but no drones touch."""
    places = circle(8, noise=0.01)
    least, _ = swap(hovering(places, enable=1), places, velocity, 20.0)
    assert least >= LEAST


def test_two_that_meet_keep_to_their_right():
    """Seen from above a pair circles its middle counter-clockwise."""
    places = circle(2)
    world = hovering(places, enable=1)
    turned = 0.0
    for drone, place in zip(world.drones, places, strict=True):
        drone.high_level_commander.go_to(*-place, HEIGHT, 0.0, 8.0)
    before = world.positions()
    for _ in range(150):
        world.step(100)
        a, b = (now[0] - now[1] for now in (before, world.positions()))
        turned += np.arctan2(a[0] * b[1] - a[1] * b[0], a[0] * b[0] + a[1] * b[1])
        before = world.positions()
    assert turned == pytest.approx(np.pi, abs=0.1)


def test_drone_between_hovering_ones_finds_its_way():
    """Twelve others hover about; the one that flies through them is alone to avoid them."""
    others = [(x + 0.13 * y, y) for x in (-1.5, 0.0, 1.5) for y in (-2.25, -0.75, 0.75, 2.25)]
    world = hovering([(-3.5, -0.65), *others])
    flyer = world.drones[0]
    flyer.param["colAv.enable"] = 1
    least = np.inf
    for _ in range(2500):
        flyer.commander.send_position_setpoint(3.5, -0.65, HEIGHT, 0.0)
        world.step(10)
        least = min(least, np.linalg.norm(world.positions()[1:] - flyer.true_position, axis=1).min())
    assert len(flyer.peers) == 10
    assert least >= LEAST
    np.testing.assert_allclose(flyer.true_position, (3.5, -0.65, HEIGHT), atol=0.1)


def test_drone_stays_in_its_box():
    world = hovering([(0.0, 0.0)], enable=1, bboxMaxX=0.8, bboxMinY=-0.4)
    drone = world.drones[0]
    for _ in range(100):
        drone.commander.send_position_setpoint(3.0, -2.0, HEIGHT, 0.0)
        world.step(100)
    np.testing.assert_allclose(drone.true_position, (0.8, -0.4, HEIGHT), atol=0.05)


def test_peer_that_nobody_hears_of_is_forgotten_after_its_time():
    """A drone that the cameras have lost blocks the way for maxPeerLocAge, and no longer."""
    world = hovering([(-1.0, 0.0), (0.0, 0.0)], enable=1, maxPeerLocAge=3000)
    first, second = world.drones
    world.run(0.1)
    second.struct.vehicle.mocap.is_lost = True
    second.place((0.0, 5.0, HEIGHT))
    first.commander.send_position_setpoint(0.0, 0.0, HEIGHT, 0.0)
    world.run(0.4)
    assert first.log["ctrltarget.x"] < -0.5
    for _ in range(30):
        first.commander.send_position_setpoint(0.0, 0.0, HEIGHT, 0.0)
        world.run(0.1)
    assert first.log["ctrltarget.x"] == pytest.approx(0.0, abs=1e-6)


def least_distance(log):
    positions = log.stack("sim.x", "sim.y", "sim.z")
    pairs = itertools.combinations(range(positions.shape[1]), 2)
    return min(np.linalg.norm(positions[:, i] - positions[:, j], axis=1).min() for i, j in pairs)


def test_example_keeps_its_drones_apart_by_one_parameter(tmp_path):
    path = EXAMPLES / "swap_places.yaml"
    assert least_distance(fly(load_mission(path), visuals=False).log) >= LEAST
    without = tmp_path / "without.yaml"
    without.write_text(path.read_text().replace("colAv.enable: 1", "colAv.enable: 0"))
    assert least_distance(fly(load_mission(without), visuals=False).log) < 0.2
