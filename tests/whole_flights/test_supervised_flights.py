"""Permission to fly, and its timeouts: time lines of commander and supervisor through a whole world.

docs/reference/planner-commander.md#7.4, #8.2, #14.2, #14.6 and #18 (quirks 1 and 6), docs/reference/control-pid.md#11,
docs/reference/crtp-cflib.md#7, #12 and #15.
"""

import struct

import numpy as np
import pytest
from test_acceptance import hovering, record, reference_world

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.common.errors import StateError
from crazychoir_fw.simulation import DroneConfig, World

TICK_OF_STEP_0 = 1512


def hold_position(drone):
    drone.commander.send_position_setpoint(0.0, 0.0, 1.0, 0.0)


def hold_height(drone):
    drone.commander.send_hover_setpoint(0.0, 0.0, 0.0, 1.0)


def streaming(command, platform="cf2", settle=10.0):
    """Return a world whose drone hovers at 1 m under low-level setpoints at 100 Hz, and the drone."""
    world = reference_world(platform)
    drone = hovering(world, settle=10.0)
    record(world, settle, lambda: None, lambda: command(drone))
    return world, drone


def states(world, drone, seconds):
    """Run and return the states that were entered, by the tick (ms) of it."""
    entered, last = {}, drone.supervisor_state
    for _ in range(round(seconds * 1000)):
        world.step(1)
        if drone.supervisor_state != last:
            last = drone.supervisor_state
            entered[drone.struct.onboard.tick] = last
    return entered


def next_update(tick):
    """Return the tick of the first update of the supervisor at or after this one."""
    return TICK_OF_STEP_0 - (TICK_OF_STEP_0 - tick) // 40 * 40


def fresh_world(platform="cf2"):
    world = World([DroneConfig("cf1", platform=platform)], seed=1, visuals=False)
    return world, world.drones[0]


# ---------------------------------------------------------------- hand-over from low-level setpoints


@pytest.mark.parametrize(("gap_ms", "sag_mm"), [(0, 0), (20, 68), (50, 137), (100, 270)])
def test_vehicle_sags_between_a_relax_and_the_next_command(gap_ms, sag_mm):
    """docs/reference/planner-commander.md#8.2: null setpoints until a high-level command arrives."""
    world, drone = streaming(hold_position)
    height = drone.true_position[2]
    drone.commander.send_notify_setpoint_stop()
    world.step(gap_ms)
    drone.high_level_commander.go_to(0.0, 0.0, 1.0, 0.0, 1.0)
    _, z = record(world, 1.5, lambda: drone.true_position[2], every=5)
    assert 1000 * (height - z.min()) == pytest.approx(sag_mm, rel=0.05, abs=4.0)


@pytest.mark.parametrize("command", [hold_position, hold_height])
def test_change_of_mode_costs_the_vertical_integral(command):
    """docs/reference/control-pid.md#11: 35 to 50 mm of height, back after about 2 s."""
    world, drone = streaming(command)
    other = hold_height if command is hold_position else hold_position
    height = drone.true_position[2]
    times, z = record(world, 4.0, lambda: drone.true_position[2], lambda: other(drone))
    assert 35.0 <= 1000 * (height - z.min()) <= 50.0
    back = times[np.flatnonzero(np.abs(z - height) > 0.01)[-1]]
    # to within 10 mm, which the reference does not say: 2.1 to 2.3 s over six seeds, to the planner's mode 2.3 to 2.5 s
    assert back == pytest.approx(2.0, abs=0.5)


def test_equal_modes_cost_nothing():
    """Position setpoints take over from the planner, whose modes are the same."""
    world = reference_world()
    drone = hovering(world)
    height = drone.true_position[2]
    _, z = record(world, 3.0, lambda: drone.true_position[2], lambda: hold_position(drone))
    assert np.abs(z - height).max() < 0.01


def test_high_level_command_under_low_level_setpoints_is_lost():
    """docs/reference/planner-commander.md#8.2, "the other order does not work"."""
    world, drone = streaming(hold_position, settle=1.0)
    drone.high_level_commander.go_to(1.0, 0.0, 1.0, 0.0, 2.0)
    world.step(10)
    assert drone.log["supervisor.info"] & lib.CF_SUPERVISOR_INFO_HL_ACTIVE == 0  # told 25 times a second
    world.step(40)
    assert drone.log["supervisor.info"] & lib.CF_SUPERVISOR_INFO_HL_ACTIVE  # it runs unseen
    assert drone.log["ctrltarget.x"] == 0.0
    hold_position(drone)
    world.step(50)
    assert drone.log["supervisor.info"] & lib.CF_SUPERVISOR_INFO_HL_ACTIVE == 0  # and is stopped
    assert drone.log["ctrltarget.x"] == 0.0


def test_late_relax_takes_a_hidden_plan_up_in_its_middle():
    """docs/reference/planner-commander.md#8.2: a step to wherever the polynomial of the take-off has got to."""
    world, drone = fresh_world()
    world.wait_until_ready()
    drone.commander.send_stop_setpoint()
    drone.high_level_commander.takeoff(1.0, 2.0)
    world.run(1.0)
    assert drone.log["motor.m1"] == 0
    with pytest.raises(StateError, match="cf1: takeoff"):
        drone.high_level_commander.takeoff(1.0, 2.0)
    drone.commander.send_notify_setpoint_stop()
    world.step(10)
    # from the floor at 0.0145 m to 1 m, the middle of a symmetric profile
    assert drone.log["ctrltarget.z"] == pytest.approx(0.51, abs=0.02)


# ---------------------------------------------------------------- silence


def test_silence_levels_out_then_falls_then_locks():
    """The first multiples of 40 ms after 0.5 s and after 2.0 s, then 40 ms.

    docs/reference/planner-commander.md#18, quirk 1.
    """
    world, drone = streaming(hold_position)
    height = drone.true_position[2]
    hold_position(drone)
    last = drone.struct.onboard.tick
    lowest = []
    entered = {}
    for _ in range(2200):
        entered.update(states(world, drone, 0.001))
        if drone.supervisor_state == "Warning, level out":
            lowest.append(drone.true_position[2])
    assert entered == {
        next_update(last + 501): "Warning, level out",
        next_update(last + 2001): "Exception, free fall",
        next_update(last + 2001) + 40: "Locked",
    }
    # the change of modes resets the integrals; the height is held
    assert 1000 * (height - min(lowest)) == pytest.approx(40.0, abs=5.0)
    assert lowest[-1] == pytest.approx(height, abs=0.03)


def test_level_out_ends_with_the_next_setpoint():
    """docs/reference/planner-commander.md#14.5: from "Warning, level out" back to "Flying"."""
    world, drone = streaming(hold_height, settle=2.0)
    world.run(1.5)
    assert drone.supervisor_state == "Warning, level out"
    assert drone.is_flying
    record(world, 2.0, lambda: None, lambda: hold_height(drone))
    assert drone.supervisor_state == "Flying"
    assert drone.true_position[2] == pytest.approx(1.0, abs=0.06)


def test_setpoints_five_times_a_second_are_enough():
    """docs/reference/crtp-cflib.md#15: the rhythm of cflib's MotionCommander."""
    world, drone = streaming(hold_height, settle=1.0)
    for _ in range(25):
        hold_height(drone)
        assert states(world, drone, 0.2) == {}
    assert drone.supervisor_state == "Flying"


# ---------------------------------------------------------------- the end of a client, quirk 1

CLOSE_LINK = bytes(14)
TAKEOFF = bytes.fromhex("07 00 0000003F 00000000 01 0000803F")  # to 0.5 m in 1 s


def test_second_client_of_one_boot_finds_a_drone_that_does_not_obey():
    """The last packet of a client raises the priority, and the client does not lower it.

    docs/reference/planner-commander.md#18, quirk 1.
    """
    world, drone = fresh_world()
    world.wait_until_ready()
    drone.receive_packet(3, 0, CLOSE_LINK)
    world.run(1.0)
    assert drone.receive_packet(8, 0, TAKEOFF) == bytes([7, 0, 0, 0])  # no error
    world.run(1.5)
    assert drone.true_position[2] < 0.03
    assert drone.log["motor.m1"] == 0

    # what a simulated link does at the end of a session
    drone.receive_packet(7, 1, bytes(5))
    drone.receive_packet(8, 0, b"\x03\x00")
    assert drone.receive_packet(8, 0, TAKEOFF) == bytes([7, 0, 0, 0])
    world.run(3.0)
    assert drone.true_position[2] == pytest.approx(0.5, abs=0.1)


# ---------------------------------------------------------------- ground


def test_preflight_timeout_takes_the_motors_away_for_80_ms():
    """An auto-armed vehicle that waits for 30 s on the floor leaves and re-enters the ready state.

    docs/reference/planner-commander.md#14.6.
    """
    world, drone = fresh_world()
    world.wait_until_ready()
    world.run(30.0 + 1.4 - world.time)
    ready = TICK_OF_STEP_0 + 120
    entered = states(world, drone, 0.33)
    away = next_update(ready + 30001)
    assert entered == {away: "Pre-flight checks not passed", away + 40: "Pre-flight checks passed"}
    with pytest.raises(StateError, match="blocked by the supervisor"):
        drone.high_level_commander.takeoff(0.5, 1.0)
    assert states(world, drone, 0.1) == {away + 80: "Ready to fly"}
    drone.high_level_commander.takeoff(0.5, 1.0)
    world.run(2.0)
    assert drone.is_flying


@pytest.mark.parametrize("platform", ["cf2", "cf21bl"])
def test_landed_vehicle_disarms_after_its_time(platform):
    """Landed 2 s after the last thrust, at rest 3 s later; brushed rearm.

    docs/reference/planner-commander.md#14.2 and #14.5.
    """
    world, drone = fresh_world(platform)
    world.wait_until_ready()
    drone.high_level_commander.takeoff(0.4, 1.0)
    world.run(2.0)
    drone.high_level_commander.land(0.0, 1.0)
    world.run(0.5)
    idle = {"cf2": 0, "cf21bl": 7000}[platform]
    last_thrust = 0
    entered = {}
    for _ in range(6200):
        entered.update(states(world, drone, 0.001))
        if max(drone.struct.onboard.motors.list) > idle:
            last_thrust = drone.struct.onboard.tick
    # the supervisor saw the thrust at its latest update before the end of it
    landed = next_update(last_thrust + 1) - 40 + 2000
    timeline = {landed: "Landed", landed + 3040: "Reset", landed + 3080: "Pre-flight checks not passed"}
    timeline[landed + 3120] = "Pre-flight checks passed"
    if platform == "cf2":
        timeline[landed + 3160] = "Ready to fly"
    assert entered == timeline
    assert drone.can_arm == (platform == "cf21bl")


def test_landing_cuts_the_motors_at_its_end_whatever_the_height():
    """Within 10 ms, and a landing to 0.4 m drops the vehicle.

    docs/reference/planner-commander.md#7.4 and #18, quirk 6.
    """
    world = reference_world()
    drone = hovering(world, settle=4.0)
    drone.high_level_commander.land(0.4, 2.0)
    world.step(2000)
    assert drone.log["motor.m1"] > 0
    world.step(12)  # an evaluation, and the next attitude tick
    assert drone.log["motor.m1"] == 0
    assert drone.true_position[2] > 0.3
    world.run(1.0)
    assert drone.true_position[2] < 0.03


# ---------------------------------------------------------------- emergency stop


@pytest.mark.parametrize(("port", "channel"), [(6, 1), (9, 1)])
def test_watchdog_stops_a_second_after_its_last_notification(port, channel):
    """The byte is the same on both ports.

    docs/reference/planner-commander.md#14.2, docs/reference/crtp-cflib.md#7 and #14.
    """
    world, drone = fresh_world()
    world.wait_until_ready()
    drone.high_level_commander.takeoff(0.5, 1.0)
    world.run(2.0)
    for _ in range(5):
        drone.receive_packet(port, channel, b"\x04")
        last = drone.struct.onboard.tick
        assert states(world, drone, 0.9) == {}
    assert states(world, drone, 0.5) == {
        next_update(last + 1000): "Exception, free fall",
        next_update(last + 1000) + 40: "Locked",
    }


def stop_by_parameter(drone):
    drone.param["stabilizer.stop"] = 1


@pytest.mark.parametrize(
    "stop",
    [
        lambda drone: drone.receive_packet(6, 1, b"\x03"),
        lambda drone: drone.receive_packet(9, 1, b"\x03"),
        lambda drone: drone.emergency_stop(),
        stop_by_parameter,
    ],
    ids=["port 6", "port 9", "call", "stabilizer.stop"],
)
def test_emergency_stop_latches_until_a_reboot(stop):
    """Only a reboot undoes it.

    docs/reference/control-pid.md#4, docs/reference/planner-commander.md#14.2, docs/reference/crtp-cflib.md#7 and #14.
    """
    world, drone = fresh_world()
    world.wait_until_ready()
    drone.high_level_commander.takeoff(0.5, 1.0)
    world.run(2.0)
    stop(drone)
    asked = drone.struct.onboard.tick
    fall = next_update(asked + 1)
    assert states(world, drone, 0.2) == {fall: "Exception, free fall", fall + 40: "Locked"}
    drone.param["stabilizer.stop"] = 0
    assert drone.receive_packet(9, 1, b"\x01\x01") == b"\x81\x00\x00"  # refused
    assert drone.receive_packet(9, 0, b"\x07") == b"\x87\x01"
    assert states(world, drone, 1.0) == {}
    assert [drone.log[f"motor.m{i}"] for i in (1, 2, 3, 4)] == [0, 0, 0, 0]
    drone.reboot()
    world.wait_until_ready()
    assert drone.can_fly


# ---------------------------------------------------------------- crash


def test_fallen_drone_crashes_and_recovers_by_packets():
    """100 ms upside down, then only an upright one recovers.

    docs/reference/planner-commander.md#14.3, #14.5 and #14.10.
    """
    world, drone = fresh_world()
    world.wait_until_ready()
    drone.high_level_commander.takeoff(0.3, 1.0)
    world.run(2.0)
    drone._qpos[3:7] = [0, 1, 0, 0]
    entered = states(world, drone, 3.0)
    assert list(entered.values()) == ["Crashed"]
    assert drone.receive_packet(9, 0, b"\x06") == b"\x86\x01"  # tumbled
    assert drone.receive_packet(9, 0, b"\x08") == b"\x88\x01"  # crashed
    assert drone.receive_packet(9, 1, b"\x02") == b"\x82\x00\x00"
    drone.place((0.0, 0.0, 0.0145))
    assert states(world, drone, 1.0) == {}
    assert drone.receive_packet(9, 1, b"\x02") == b"\x82\x01\x01"
    recovered = next_update(drone.struct.onboard.tick + 1)
    assert states(world, drone, 0.2) == {
        recovered: "Pre-flight checks not passed",
        recovered + 40: "Pre-flight checks passed",
        recovered + 80: "Ready to fly",
    }


# ---------------------------------------------------------------- replies to clients


def test_bitfield_of_a_flight():
    """docs/reference/crtp-cflib.md#7, docs/reference/planner-commander.md#14.7."""
    world, drone = fresh_world("cf21bl")

    def bits():
        world.run(0.1)
        reply = drone.receive_packet(9, 0, b"\x0c")
        assert reply[0] == 0x8C
        return struct.unpack("<H", reply[1:])[0]

    can_arm, armed, can_fly, flying, active, finished = 0x01, 0x02, 0x08, 0x10, 0x100, 0x200
    world.run(2.0)
    assert bits() == can_arm | finished
    assert drone.receive_packet(9, 1, b"\x01\x01") == b"\x81\x01\x01"
    assert bits() == armed | can_fly | finished
    drone.high_level_commander.takeoff(0.5, 1.0)
    assert bits() == armed | can_fly | flying | active
    world.run(1.5)
    assert bits() == armed | can_fly | flying | active | finished
    drone.high_level_commander.land(0.0, 1.0)
    world.run(1.5)
    assert bits() == armed | can_fly | flying | finished
    world.run(6.0)
    assert bits() == can_arm | finished


def test_manual_setpoint_scales_its_percents_as_cflib_does():
    """docs/reference/crtp-cflib.md#12: 10001 counts and 499.99 for each percent."""
    _, drone = fresh_world()
    for percent, counts in [(0, 10001), (50, 35000), (100, 60000)]:
        drone.commander.send_setpoint_manual(0.0, 0.0, 0.0, percent, False)
        assert ffi.addressof(drone.struct.onboard.commander, "setpoint").thrust == counts
