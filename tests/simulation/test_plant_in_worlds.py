"""Downwash, wind and payloads of whole worlds."""

import numpy as np
import pytest

from crazychoir_fw.common.errors import RangeError, StateError
from crazychoir_fw.simulation import DroneConfig, World, set_threads


def crossing(count=2, **vehicle):
    """Drones in the air close to each other, one of them about to cross above the others."""
    drones = [DroneConfig(f"cf{i}", (0.3 * i, 0.0), vehicle=vehicle) for i in range(count)]
    world = World(drones, seed=4, visuals=False)
    world.wait_until_ready()
    for i, drone in enumerate(world.drones):
        drone.high_level_commander.takeoff(0.3 + 0.25 * (i % 2), 1.0)
    world.run(2.0)
    world.drones[1].high_level_commander.go_to(-0.3, 0.0, 0.55, 0.0, 2.0)
    return world


@pytest.fixture
def one_thread_afterwards():
    yield
    set_threads(1)


def test_threads_do_not_change_a_bit_of_the_downwash(one_thread_afterwards):
    states = []
    for threads in (1, 2, 3):
        set_threads(threads)
        world = crossing(count=5)
        felt = []
        for _ in range(40):
            world.run(0.05)
            felt.append(world.drones[0].log["sim.downwash"])
        assert max(felt) > 0.01
        states.append(world.snapshot().tobytes())
    assert states[0] == states[1] == states[2]


def test_restored_flight_in_wash_and_gusts_goes_on_alike():
    world = crossing(**{"wind.turbulence": "indoor"})
    world.run(0.903)
    world.drones[0].blow_gust((1.0, 0.5, 0.0), 0.8)
    world.run(0.101)
    snapshot = world.snapshot()
    world.run(0.7)
    first = world.snapshot()
    world.restore(snapshot)
    world.run(0.7)
    assert world.snapshot().tobytes() == first.tobytes()


def test_wash_of_one_that_stands_is_not_felt():
    world = World([DroneConfig("low", (0, 0)), DroneConfig("high", (0, 0, 0.4))], visuals=False)
    world.run(0.02)
    assert world["low"].log["sim.downwash"] == 0.0


def test_downwash_can_be_switched_off():
    world = crossing(**{"downwash.enabled": False})
    most = 0.0
    for _ in range(60):
        world.run(0.02)
        most = max(most, world.drones[0].log["sim.downwash"])
    assert most == 0.0


def test_gust_pushes_a_drone_away_and_it_comes_back():
    world = World([DroneConfig("cf", (0, 0))], visuals=False)
    world.wait_until_ready()
    world["cf"].high_level_commander.takeoff(1.0, 1.5)
    world.run(4.0)
    start = world["cf"].true_position
    world["cf"].blow_gust((0.0, 4.0, 0.0), 1.0)
    farthest = 0.0
    for _ in range(200):
        world.run(0.01)
        farthest = max(farthest, world["cf"].true_position[1] - start[1])
    assert 0.05 < farthest < 1.0
    world.run(6.0)
    assert abs(world["cf"].true_position[1] - start[1]) < 0.05
    with pytest.raises(RangeError, match="blow_gust"):
        world["cf"].blow_gust((0.0, 400.0, 0.0), 1.0)


def test_wind_of_the_scene_is_felt(tmp_path):
    scene = tmp_path / "windy.xml"
    scene.write_text(
        '<mujoco><option timestep="0.001" wind="2 0 0"/>'
        '<worldbody><geom type="plane" size="5 5 1"/></worldbody></mujoco>'
    )
    world = World([DroneConfig("cf", (0, 0), vehicle={"wind.velocity": (0, 1, 0)})], scene=scene)
    assert list(world["cf"].struct.vehicle.wind.velocity) == [2.0, 1.0, 0.0]


def test_vehicle_with_mass_and_inertia_gets_them_on_its_body():
    inertia = (20e-6, 21e-6, 35e-6)
    world = World([DroneConfig("cf", (0, 0), vehicle={"mass": 0.035, "inertia": inertia})])
    assert world.model.body("cf").mass[0] == 0.035
    assert world.model.body("cf").inertia == pytest.approx(inertia)
    assert world["cf"].struct.vehicle.mass == pytest.approx(0.035)
    with pytest.raises(RangeError, match="principal values"):
        World([DroneConfig("cf", (0, 0), vehicle={"inertia": (1e-6, 1e-6, 50e-6)})])


def test_rigid_payload_is_part_of_the_body():
    """0.005 kg at (0.02, 0, -0.02) m on 0.029 kg: center of mass and inertia by the parallel axis theorem."""
    offset = np.array([0.02, 0.0, -0.02])
    world = World([DroneConfig("cf", (0, 0), payload={"mass": 0.005, "offset": offset})])
    body = world.model.body("cf")
    assert body.mass[0] == pytest.approx(0.034)
    assert body.ipos == pytest.approx(offset * 0.005 / 0.034)
    reduced = 0.029 * 0.005 / 0.034
    tensor = np.diag([16.571710e-6, 16.655602e-6, 29.261652e-6])
    tensor = tensor + reduced * (offset @ offset * np.eye(3) - np.outer(offset, offset))
    assert sorted(body.inertia) == pytest.approx(sorted(np.linalg.eigvalsh(tensor)), rel=1e-6)


def test_payload_drops_and_comes_back_with_the_snapshot():
    payload = {"mass": 0.006, "offset": (0, 0, -0.006), "detachable": True}
    world = World([DroneConfig("cf", (1, 0.5), payload=payload), DroneConfig("other", (0, 0))], visuals=False)
    world.wait_until_ready()
    drone = world["cf"]
    drone.high_level_commander.takeoff(0.6, 1.5)
    world.run(3.0)
    assert drone.is_flying
    snapshot = world.snapshot()
    hanging = drone.payload.position - drone.true_position
    assert np.linalg.norm(hanging - [0, 0, -0.006]) < 0.002
    drone.drop_payload()
    assert not drone.payload.is_attached
    world.run(0.5)
    assert drone.payload.position[2] < 0.02
    assert drone.true_position[2] > 0.6  # lighter now
    with pytest.raises(StateError, match="dropped its payload already"):
        drone.drop_payload()
    world.restore(snapshot)
    assert drone.payload.is_attached
    with pytest.raises(StateError, match="nothing detachable"):
        world["other"].drop_payload()


def test_payload_goes_along_when_its_drone_is_placed():
    payload = {"mass": 0.006, "offset": (0.01, 0, -0.006), "detachable": True}
    world = World([DroneConfig("cf", (0, 0), payload=payload)], visuals=False)
    world["cf"].place((1.0, 2.0, 0.5), yaw_deg=90.0)
    assert world["cf"].payload.position == pytest.approx([1.0, 2.01, 0.494], abs=1e-9)


@pytest.mark.parametrize(
    ("payload", "words"),
    [
        ({}, "payload is"),
        ({"mass": 1.0}, "payload.mass is 1.0, allowed: 0.00001 to 0.2 kg"),
        ({"mass": 0.01, "offset": (0, 0)}, "payload.offset"),
        ({"mass": 0.01, "offset": (0, 0, float("nan"))}, "payload.offset"),
        ({"mass": 0.01, "detachable": 1}, "payload.detachable"),
        ({"mass": 0.01, "weight": 1}, "'weight', allowed: mass, offset, detachable"),
    ],
)
def test_impossible_payload_is_refused(payload, words):
    with pytest.raises(RangeError) as caught:
        World([DroneConfig("cf", (0, 0), payload=payload)])
    assert words in str(caught.value)
