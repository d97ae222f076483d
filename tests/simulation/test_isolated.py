"""Drones with the attribute `isolated` are not there for each other, and windows know it."""

import numpy as np

from crazychoir_fw._core import lib
from crazychoir_fw.simulation import DroneConfig, World


def hovering(count, isolated, **options):
    attributes = {"isolated": "on"} if isolated else {}
    drones = [
        DroneConfig(f"d{i}", (0.3 * i * (not isolated), 0.0), attributes=attributes, **options) for i in range(count)
    ]
    world = World(drones, seed=1, visuals=False)
    world.wait_until_ready()
    for drone in world.drones:
        drone.high_level_commander.takeoff(0.8, 1.0)
    world.run(2.0)
    return world


def test_drones_at_one_place_fly_as_if_alone():
    many, alone = hovering(3, True), hovering(1, True)
    assert np.array_equal(many.positions()[0], alone.positions()[0])
    assert np.ptp(many.positions(), axis=0).max() < 0.02
    assert all(drone.struct.vehicle.downwash == 0.0 for drone in many.drones)
    assert not [event for event in many.events if event.details.get("what") == "drone"]


def test_they_stand_on_the_floor_and_see_no_other():
    world = hovering(2, True, decks=["multiranger"], parameters={"colAv.enable": 1})
    assert not len(world.drones[0].peers)
    assert world.drones[0].log["range.front"] > 4000
    for drone in world.drones:
        drone.high_level_commander.land(0.0, 1.0)
    world.run(3.0)
    assert np.all(world.positions()[:, 2] < 0.03)


def test_windows_are_possible_at_one_place():
    world = hovering(2, True)
    model, data = world.model._address, world.data._address
    lib.cf_plugin_overlap(model, data, True)
    assert lib.cf_plugin_window(model, data, 20) == 20
    lib.cf_plugin_overlap(model, data, False)


def test_step_motion_is_step():
    one, other = hovering(2, True), hovering(2, True)
    one.step(100)
    for _ in range(10):
        other.step_motion(10)
    assert np.array_equal(one.data.qpos, other.data.qpos)
    assert bytes(one.drones[1].memory) == bytes(other.drones[1].memory)
