"""Contacts of drones that begin: told once, in order, with what and how fast."""

import mujoco
import numpy as np
import pytest
from worlds import make_world

from crazychoir_fw.simulation import DroneConfig, World, set_threads


def floating(*drones, scene="arena", **options):
    """Return a world without gravity: (name, position, velocity) of each drone."""
    world = World([DroneConfig(name, place) for name, place, _ in drones], scene=scene, visuals=False, **options)
    world.model.opt.gravity[:] = 0.0
    for drone, (_, _, velocity) in zip(world.drones, drones, strict=True):
        address = world.model.joint(f"{drone.id}/root").dofadr[0]
        world.data.qvel[address : address + 3] = velocity
    return world


def kinds(world):
    return [(event.kind, event.drone) for event in world.events]


def test_standing_drones_tell_nothing():
    world = make_world(4)
    world.run(1.0)
    assert world.events == []
    assert world.drones[0].log["sim.contacts"] == 4


def test_a_landing_is_a_touchdown_and_no_collision(hovering_world):
    drone = hovering_world.drones[0]
    assert hovering_world.events == []
    assert drone.log["sim.contacts"] == 0
    drone.high_level_commander.land(0.0, 2.0)
    hovering_world.run(4.0)
    assert kinds(hovering_world) == [("touchdown", "cf1")]
    event = hovering_world.events[0]
    assert event.details["what"] == event.details["other"] == "floor"
    assert 0 < event.details["speed"] < 1.0
    assert 3.0 < event.time < hovering_world.time
    assert drone.log["sim.contacts"] == 4


@pytest.mark.parametrize(("height", "kind"), [(0.03, "touchdown"), (0.17, "touchdown"), (0.25, "collision")])
def test_a_fall_is_told_by_its_speed(height, kind):
    world = World([DroneConfig("cf1", (0, 0, 1.0))], scene="arena")
    world.run(0.2)
    world.drones[0].place((0.0, 0.0, 0.0145 + height))
    world.run(1.0)
    event = world.events[0]
    assert (event.kind, event.details["what"]) == (kind, "floor")
    assert event.details["speed"] == pytest.approx(np.sqrt(2 * 9.81 * height), rel=0.05)
    assert event.time == pytest.approx(0.2 + np.sqrt(2 * height / 9.81), rel=0.05)


def test_a_fall_on_the_back_is_a_collision_however_slow():
    world = World([DroneConfig("cf1", (0, 0, 0.05))])
    world.data.qpos[3:7] = 0, 1, 0, 0
    world.data.qvel[2] = -0.1
    world.run(0.5)
    assert kinds(world)[0] == ("collision", "cf1")
    assert world.events[0].details["what"] == "floor"


def test_a_table_carries_too():
    """The top of the table in the room is at 0.75 m."""
    world = World([DroneConfig("cf1", (-1.2, 1.1, 1.5))], scene="room")
    world.run(0.2)
    world.drones[0].place((-1.2, 1.1, 0.79))
    world.run(0.5)
    assert kinds(world) == [("touchdown", "cf1")]
    assert world.events[0].details["other"] == "table_top"


def test_a_drone_that_flies_into_a_wall_is_told_with_place_and_speed():
    world = floating(("cf1", (1.5, 0.5, 1.2), (2.0, 0.3, 0.0)), scene="room")
    world.run(0.6)
    assert kinds(world) == [("collision", "cf1")]
    details = world.events[0].details
    assert (details["what"], details["other"]) == ("obstacle", "wall_east_left")
    assert details["speed"] == pytest.approx(2.0, rel=0.15)  # slowed by the air
    assert details["position"][0] == pytest.approx(2.5, abs=0.01)
    assert world.events[0].time == pytest.approx((1.0 - 0.055) / 2.0, rel=0.15)


def test_two_drones_that_collide_are_told_once():
    world = floating(("a", (0, 0, 1), (0.5, 0, 0)), ("b", (0.5, 0, 1), (-1.0, 0, 0)))
    world.run(1.0)
    assert kinds(world) == [("collision", "a")]
    details = world.events[0].details
    assert (details["what"], details["other"]) == ("drone", "b")
    assert details["speed"] == pytest.approx(1.5, abs=0.05)


def test_what_is_touched_again_later_is_told_again():
    world = floating(("cf1", (2.4, 0.5, 1.2), (0.5, 0.0, 0.0)), scene="room")
    world.run(0.5)
    world.data.qvel[0] = 0.5
    world.run(1.0)
    assert kinds(world) == [("collision", "cf1")] * 2


def test_a_body_without_names_is_told_by_its_number(tmp_path):
    path = tmp_path / "scene.xml"
    path.write_text(
        '<mujoco><worldbody><geom type="plane" size="0 0 1"/><geom type="box" pos="1 0 1" size=".1 1 1"/>'
        '<body name="crate" pos="-1 0 1"><freejoint/><geom type="box" size=".1 1 1"/></body></worldbody></mujoco>'
    )
    world = World([DroneConfig("cf1", (0.5, 0, 1)), DroneConfig("cf2", (-0.5, 0, 1))], scene=path)
    world.model.opt.gravity[:] = 0.0
    for name, speed in (("cf1", 1.0), ("cf2", -1.0)):
        world.data.qvel[world.model.joint(f"{name}/root").dofadr[0]] = speed
    world.run(0.6)
    assert {event.drone: event.details["other"] for event in world.events} == {"cf1": "geom 1", "cf2": "crate"}


def test_events_come_in_the_order_of_time_at_any_number_of_threads():
    def fly(threads):
        set_threads(threads)
        drones = [(f"cf{i}", (0.4 * i, 0.0, 1.0), (0.6 * (-1) ** i, 0.0, 0.0)) for i in range(5)]
        world = floating(*drones, scene="room")
        for _ in range(5):
            world.run(0.2)
        return world.events

    events = fly(1)
    assert len(events) == 2
    assert [event.time for event in events] == sorted(event.time for event in events)
    assert fly(2) == events


def test_a_restored_world_tells_the_same_again_and_nothing_twice():
    world = floating(("a", (0, 0, 1), (0.5, 0, 0)), ("b", (0.5, 0, 1), (-1.0, 0, 0)))
    world.run(0.2)
    before = world.snapshot()
    world.run(0.3)
    during = world.snapshot()
    events = list(world.events)
    assert len(events) == 1
    world.restore(before)
    assert world.events == []
    world.run(0.3)
    assert world.events == events
    world.restore(during)
    world.run(0.1)
    assert world.events == events


def test_a_flood_of_events_is_bounded_and_counted():
    """While the caller takes no events, the queue keeps 512 and counts the others."""
    world = make_world(20, seed=1)
    world.run(0.2)
    for _ in range(30):
        world.data.time += 1.0  # long enough for the contacts with the floor to begin again
        mujoco.mj_step(world.model, world.data)
    world.step()
    assert [event.kind for event in world.events] == ["touchdown"] * 512 + ["collisions_lost"]
    assert world.events[-1].details == {"count": 20 * 30 - 512}
