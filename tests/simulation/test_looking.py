"""What ranging decks see in a world: walls, boxes, bodies that move, other drones."""

import numpy as np
import pytest

from crazychoir_fw.common.errors import RangeError, UnknownNameError
from crazychoir_fw.simulation import DroneConfig, World, set_threads

SIDES = ("front", "back", "left", "right", "up")
IDEAL = {"range_noise": 0.0}


def scene_with(tmp_path, *parts, gravity="0 0 0"):
    """Return a scene of a floor and some more elements, without gravity: drones stay where they are put."""
    path = tmp_path / "scene.xml"
    floor = '<geom name="floor" type="plane" size="0 0 0.1"/>'
    path.write_text(
        f'<mujoco><option timestep="0.001" gravity="{gravity}"/><worldbody>{floor}{"".join(parts)}</worldbody></mujoco>'
    )
    return path


def ranges(drone, *names):
    return np.array([drone.log[f"range.{name}"] for name in names], dtype=float)


def test_decks_are_told_by_their_parameters():
    world = World([DroneConfig("a", decks=["multiranger"]), DroneConfig("b", (1, 0), decks=["zranger"])])
    flags = [[drone.param[f"deck.{name}"] for name in ("bcMultiranger", "bcZRanger2")] for drone in world.drones]
    assert flags == [[1, 0], [0, 1]]


def test_an_unknown_deck_is_refused_with_the_known_ones():
    with pytest.raises(UnknownNameError, match="cf1: decks names 'lidar', allowed: multiranger, zranger"):
        World([DroneConfig("cf1", decks=["lidar"])])
    with pytest.raises(RangeError, match="multiranger is 'yes', allowed: off | on"):
        World([DroneConfig("cf1", attributes={"multiranger": "yes"})])


@pytest.mark.parametrize("yaw_deg", [0.0, 90.0, -90.0, 180.0])
def test_multi_ranger_measures_the_room_within_its_noise(yaw_deg):
    """The walls of the room stand at x = +-2.5 m, y = +-2 m, its ceiling at 2.5 m."""
    place = (0.9, 0.6, 1.2)
    world = World([DroneConfig("cf1", place, yaw_deg=yaw_deg, decks=["multiranger"])], scene="room", seed=2)
    world.model.opt.gravity[:] = 0.0
    taken = []
    for _ in range(30):
        world.run(0.1)
        taken.append(ranges(world.drones[0], *SIDES))
    walls = {0.0: (1.6, 3.4, 1.4, 2.6), 90.0: (1.4, 2.6, 3.4, 1.6), -90.0: (2.6, 1.4, 1.6, 3.4)}
    expected = 1000 * np.array([*walls.get(yaw_deg, (3.4, 1.6, 2.6, 1.4)), 1.3])
    deviation = np.array([2.5 * (1 + np.exp(2.92135 * (d / 1000 - 2.5))) for d in expected])
    misses = (np.array(taken) - expected) / np.hypot(deviation, 0.3)
    assert np.abs(misses).max() < 4.5
    assert np.abs(misses.mean(axis=0)).max() < 4.0 / np.sqrt(30)
    assert misses.std() == pytest.approx(1.0, abs=0.2)


def test_readings_come_ten_times_a_second():
    world = World([DroneConfig("cf1", (0, 0, 1), decks=["multiranger"])], scene="room", seed=2)
    world.model.opt.gravity[:] = 0.0
    world.run(1.0)
    changes, before = 0, ranges(world.drones[0], *SIDES)
    for _ in range(1000):
        world.step()
        now = ranges(world.drones[0], *SIDES)
        changes += bool((now != before).any())
        before = now
    assert 8 <= changes <= 10  # noise may repeat a reading


@pytest.mark.parametrize(("x", "seen"), [(0.0, 700), (0.18, 700), (0.25, 1000), (0.6, 1000)])
def test_z_ranger_sees_the_top_of_a_box(tmp_path, x, seen):
    box = '<geom type="box" pos="0 0 0.15" size="0.2 0.2 0.15"/>'
    drone = DroneConfig("cf1", (x, 0, 1), decks=["zranger"], attributes=IDEAL)
    world = World([drone], scene=scene_with(tmp_path, box))
    world.run(0.1)
    assert world.drones[0].log["range.zrange"] == seen


@pytest.mark.parametrize(("positioning", "decks"), [("flow", ()), ("none", ("zranger",))])
def test_a_box_below_shifts_the_estimated_height(tmp_path, positioning, decks):
    """The filter takes the floor for flat: above a box of 0.3 m it believes to be lower by as much."""
    box = '<geom type="box" pos="1.5 0 0.15" size="0.5 0.5 0.15"/>'
    heights = []
    for x in (0.0, 1.5):
        config = DroneConfig("cf1", (x, 0, 1), positioning=positioning, decks=decks, estimator="kalman", noise=0.0)
        world = World([config], scene=scene_with(tmp_path, box, gravity="0 0 -9.81"), seed=3)
        for _ in range(300):
            world.drones[0].place((x, 0.0, 1.0))
            world.run(0.01)
        heights.append(world.drones[0].log["stateEstimate.z"])
    assert heights[0] - heights[1] == pytest.approx(0.3, abs=0.05)


def test_flow_over_a_box_is_that_of_the_lower_height(tmp_path):
    box = '<geom type="box" pos="0 0 0.25" size="9 9 0.25"/>'
    counts = []
    for parts in ((), (box,)):
        config = DroneConfig("cf1", (0, 0, 1), positioning="flow", attributes={"flow_noise": 0.0, **IDEAL})
        world = World([config], scene=scene_with(tmp_path, *parts))
        world.data.qvel[0] = 1.0
        world.run(0.1)
        counts.append(world.drones[0].log["motion.deltaY"])
    assert counts[1] == pytest.approx(2 * counts[0], abs=1)
    assert abs(counts[0]) > 2


@pytest.mark.parametrize(
    ("offset", "side"), [((1, 0, 0), "front"), ((-1, 0, 0), "back"), ((0, 1, 0), "left"), ((0, -1, 0), "right")]
)
def test_another_drone_is_seen_at_its_hull(tmp_path, offset, side):
    drones = [
        DroneConfig("a", (0, 0, 1), decks=["multiranger"], attributes=IDEAL),
        DroneConfig("b", tuple(np.add((0, 0, 1), offset))),
    ]
    world = World(drones, scene=scene_with(tmp_path))
    world.run(0.1)
    assert world.drones[0].log[f"range.{side}"] == pytest.approx(945, abs=2)
    others = [name for name in SIDES if name != side]
    assert (ranges(world.drones[0], *others) > 8000).all()
    assert not ranges(world.drones[1], *SIDES).any()  # it carries no deck


@pytest.mark.parametrize(("angle_deg", "is_seen"), [(0, True), (12, True), (16, False), (90, False)])
def test_drones_are_seen_within_the_cone_of_27_degrees(tmp_path, angle_deg, is_seen):
    angle = np.radians(angle_deg)
    drones = [
        DroneConfig("a", (0, 0, 1), decks=["multiranger"], attributes=IDEAL),
        DroneConfig("b", (1.5 * np.cos(angle), 0.0, 1 + 1.5 * np.sin(angle))),
    ]
    world = World(drones, scene=scene_with(tmp_path))
    world.run(0.1)
    assert (world.drones[0].log["range.front"] < 1500) == is_seen


def test_a_drone_behind_a_wall_is_not_seen(tmp_path):
    wall = '<geom type="box" pos="0.5 0 1" size="0.02 1 1"/>'
    drones = [
        DroneConfig("a", (0, 0, 1), decks=["multiranger"], attributes=IDEAL),
        DroneConfig("b", (1, 0, 1)),
    ]
    world = World(drones, scene=scene_with(tmp_path, wall))
    world.run(0.1)
    assert world.drones[0].log["range.front"] == 480


def test_bodies_that_move_are_seen_where_they_are(tmp_path):
    ball = '<body pos="1 0 1"><freejoint/><geom type="sphere" size="0.1" mass="1"/></body>'
    config = DroneConfig("cf1", (0, 0, 1), decks=["multiranger"], attributes=IDEAL)
    world = World([config], scene=scene_with(tmp_path, ball))
    world.run(0.1)
    assert world.drones[0].log["range.front"] == 900
    world.data.qvel[0] = 0.5
    world.run(0.2)
    # kinematics are those of the start of the step
    assert world.drones[0].log["range.front"] == pytest.approx(1000, abs=1)


def test_a_mesh_that_moves_is_seen(tmp_path):
    path = scene_with(tmp_path, '<body pos="1.5 0 0.7"><freejoint/><geom type="mesh" mesh="wedge"/></body>')
    corners = "-0.3 -0.3 0 0.3 -0.3 0 -0.3 0.3 0 0.3 0.3 0 -0.3 -0.3 0.7 -0.3 0.3 0.7"
    mesh = f'<asset><mesh name="wedge" vertex="{corners}"/></asset>'
    path.write_text(path.read_text().replace("<worldbody>", mesh + "<worldbody>"))
    world = World([DroneConfig("cf1", (0, 0, 1), decks=["multiranger"], attributes=IDEAL)], scene=path)
    world.run(0.1)
    assert world.drones[0].log["range.front"] == pytest.approx(1200, abs=1)


# ------------------------------------------------------------------------------------ the same bits


def swarm(seed=5):
    """Nine drones in the room that see walls and each other."""
    places = [(0.6 * i - 0.6, 0.6 * j - 0.6, 0.6 + 0.1 * i) for i in range(3) for j in range(3)]
    positionings = ["mocap", "flow", "mocap"]
    drones = [
        DroneConfig(f"cf{i}", place, decks=["multiranger", "zranger"], positioning=positionings[i % 3])
        for i, place in enumerate(places)
    ]
    world = World(drones, scene="room", seed=seed, visuals=False)
    world.data.qvel[:] = np.random.default_rng(1).uniform(-0.3, 0.3, world.model.nv)
    return world


def bits(world):
    return world.data.plugin_state.tobytes() + world.data.qpos.tobytes()


def test_threads_do_not_change_a_bit_of_what_is_seen():
    flights = []
    for threads in (1, 2):
        set_threads(threads)
        world = swarm()
        world.run(0.6)
        flights.append(bits(world))
    assert flights[0] == flights[1]
    assert world.drones[0].log["range.front"] > 0


def test_a_restored_flight_sees_the_same():
    world = swarm()
    world.run(0.33)
    start = world.snapshot()
    world.run(0.5)
    first, events = bits(world), list(world.events)
    world.restore(start)
    world.run(0.2)
    world.run(0.3)
    assert bits(world) == first
    assert world.events == events
    other = swarm()
    other.restore(start)
    other.run(0.5)
    assert bits(other) == first


def test_a_drone_over_a_floor_flies_alike_in_a_swarm_and_alone():
    """Also the flow deck, which then looks for others below itself."""
    config = DroneConfig("cf1", (0, 0, 0.8), positioning="flow", decks=["multiranger"])
    alone = World([config], seed=4)
    pair = World([config, DroneConfig("cf2", (3, 0, 0.8))], seed=4)
    for world in (alone, pair):
        world.run(0.38)  # they fall; where they land MuJoCo solves their contacts together
    np.testing.assert_array_equal(alone.drones[0].memory, pair.drones[0].memory)


def test_a_payload_does_not_blind_the_decks_of_its_drone():
    payload = {"mass": 0.003, "offset": (0.0, 0.0, -0.006), "detachable": True}
    world = World([DroneConfig("cf1", payload=payload, decks=["zranger"], attributes=IDEAL)])
    world.wait_until_ready()
    drone = world.drones[0]
    drone.high_level_commander.takeoff(0.6, 1.5)
    world.run(4.0)
    assert drone.log["range.zrange"] == pytest.approx(1000 * drone.true_position[2], abs=15)
    assert drone.true_position[2] == pytest.approx(0.6, abs=0.1)  # the integrator is still learning the load
    drone.drop_payload()
    world.run(2.0)  # it lies on the floor below, 12 mm high
    assert drone.log["range.zrange"] == pytest.approx(1000 * drone.true_position[2] - 12, abs=15)
