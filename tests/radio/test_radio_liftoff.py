"""The handler repeats a take-off that the drone dropped, as all do for some 0.1 s every 30 s on the floor."""

import struct

import pytest
from fake_drone import FLYING, READY, UNARMED

from crazychoir_fw.radio import RadioHandlerFPQR, RadioHandlerVel, RadioHandlerXYZ
from crazychoir_fw.radio.liftoff import Liftoff
from crazychoir_fw.radio.modes import Mode

CLIMB = struct.pack("<BBff?f", 7, 0, 0.5, 0.0, True, 2.0).hex(" ")


def pass_time(swarm, clock, seconds, step=0.1):
    for _ in range(round(seconds / step)):
        clock.now += step
        swarm.tick()


def plans(drone):
    return [data for port, _, data in drone.take() if port == 8]


@pytest.mark.parametrize("handler", [RadioHandlerXYZ, RadioHandlerVel, RadioHandlerFPQR])
@pytest.mark.parametrize("dropped", [0, 1, 3])
def test_a_takeoff_that_is_dropped_is_given_again(fly, air, clock, handler, dropped):
    drone = air["fake://0"]
    swarm = fly(handler)
    drone.commands_to_drop = dropped
    swarm.takeoff(0.5, 2.0)
    pass_time(swarm, clock, 1.8)
    assert plans(drone) == [CLIMB] * (1 + dropped)
    # commands wait until it is up, however late it began
    assert swarm[0].mode is Mode.TAKING_OFF
    pass_time(swarm, clock, 0.4 * dropped + 0.4)
    assert swarm[0].mode is Mode.READY
    assert plans(drone) == []


@pytest.mark.parametrize("dropped", [0, 2])
def test_a_goal_that_is_dropped_is_given_again(fly, air, clock, dropped):
    drone = air["fake://0"]
    swarm = fly(RadioHandlerXYZ)
    drone.commands_to_drop = dropped
    assert swarm.command(0, 1.0, 0.0, 0.5, 2.0)
    pass_time(swarm, clock, 10.0)
    sent = plans(drone)
    assert len(sent) == 1 + dropped
    assert len(set(sent)) == 1


def test_in_the_air_nobody_looks_any_more(fly, air, clock):
    drone = air["fake://0"]
    swarm = fly(RadioHandlerXYZ)
    swarm.command(0, 1.0, 0.0, 0.5, 2.0)
    pass_time(swarm, clock, 1.0)
    drone.packets.clear()
    swarm.command(0, 0.0, 0.0, 0.5, 2.0)
    pass_time(swarm, clock, 3.0)
    assert [port for port, _, _ in drone.packets] == [8]


def test_the_newest_goal_is_given_again(fly, air, clock):
    drone = air["fake://0"]
    swarm = fly(RadioHandlerXYZ)
    drone.commands_to_drop = 2
    swarm.command(0, 1.0, 0.0, 0.5, 2.0)
    swarm.command(0, 0.0, 1.0, 0.5, 2.0)
    first, second = plans(drone)
    pass_time(swarm, clock, 2.0)
    assert plans(drone) == [second]
    assert first != second


@pytest.mark.parametrize("end", ["stop", "land", "disarm"])
def test_nothing_is_given_again_after_the_end(fly, air, clock, end):
    drone = air["fake://0"]
    swarm = fly(RadioHandlerXYZ)
    drone.commands_to_drop = 1
    swarm.command(0, 1.0, 0.0, 0.5, 2.0)
    if end == "disarm":
        swarm[0].arm(False)
    else:
        getattr(swarm, end)()
    pass_time(swarm, clock, 3.0)
    assert not drone.bits & FLYING
    goals = [data for data in plans(drone) if data.startswith("0c")]
    assert len(goals) == 1


def test_a_drone_that_was_disarmed_by_the_reset_is_armed_again(fly, air, clock):
    drone = air["fake://0"]
    drone.bits = UNARMED
    swarm = fly(RadioHandlerXYZ)
    swarm[0].make_ready()
    drone.bits, drone.commands_to_drop = UNARMED, 1  # 30 s later
    drone.packets.clear()
    swarm.command(0, 1.0, 0.0, 0.5, 2.0)
    pass_time(swarm, clock, 2.0)
    assert drone.take().count((9, 1, "01 01")) == 1
    assert drone.bits & FLYING


def test_a_drone_that_flies_with_its_motors_off_is_told_again(fly, air, clock):
    """A reset while motors begin to turn leaves it in the state Flying for 2 s.

    docs/reference/planner-commander.md#14.2.
    """
    drone = air["fake://0"]
    swarm = fly(RadioHandlerXYZ)
    drone.commands_to_drop = 1
    swarm.command(0, 1.0, 0.0, 0.5, 2.0)
    drone.bits |= 1 << 4
    pass_time(swarm, clock, 2.0)
    assert len(plans(drone)) == 1
    drone.bits &= ~(1 << 4)
    pass_time(swarm, clock, 2.0)
    assert len(plans(drone)) == 1
    assert drone.bits & FLYING


def test_a_drone_that_stays_on_the_floor_is_reported(fly, air, clock):
    drone = air["fake://0"]
    swarm = fly(RadioHandlerXYZ, ready_timeout_s=2.0)
    told = []
    swarm.on_event = lambda agent, kind, text: told.append((kind, text))
    drone.commands_to_drop = 100
    swarm.command(0, 1.0, 0.0, 0.5, 2.0)
    pass_time(swarm, clock, 1.8)
    assert (len(plans(drone)), told) == (5, [])
    pass_time(swarm, clock, 5.0)
    assert len(plans(drone)) <= 1
    assert told == [("grounded", "does not take off: its motors may run")]


def test_a_drone_that_crashes_at_its_takeoff_does_not_start_in_somebodys_hand(fly, air, clock):
    drone = air["fake://0"]
    swarm = fly(RadioHandlerXYZ)
    told = []
    swarm.on_event = lambda agent, kind, text: told.append((kind, text))
    drone.commands_to_drop = 1
    swarm.command(0, 1.0, 0.0, 0.5, 2.0)
    drone.bits = 1 << 7
    pass_time(swarm, clock, 0.5)
    assert told == [("grounded", "does not take off: it has crashed; put it on its feet, and call recover()")]
    drone.bits = READY
    pass_time(swarm, clock, 5.0)
    assert len(plans(drone)) == 1


def test_a_drone_with_old_firmware_is_told_once(fly, air, clock):
    drone = air["fake://0"]
    drone.protocol = 11
    swarm = fly(RadioHandlerXYZ)
    drone.commands_to_drop = 1
    swarm.command(0, 1.0, 0.0, 0.5, 2.0)
    pass_time(swarm, clock, 8.0)
    assert len(plans(drone)) == 1


def test_who_does_not_answer_is_asked_again():
    given = []
    liftoff = Liftoff(1.0)
    liftoff.expect(lambda: given.append(True), 10.0)
    assert liftoff.due == pytest.approx(10.3)
    assert liftoff.look(None, False, 10.3)
    assert liftoff.look(False, True, 10.6)
    assert liftoff.look(True, True, 10.9)
    assert (given, liftoff.is_expected, liftoff.has_happened) == ([True], False, True)
    liftoff.forget()
    liftoff.expect(lambda: given.append(True), 20.0)
    assert not liftoff.look(False, True, 21.0)
    assert given == [True]
