"""How much of a checkout flies: every release at every level, compared with the builtin provider and with physics."""

import struct

import numpy as np
import pytest
from level_flights import GENERIC, HIGH_LEVEL, RPYT, SUPERVISOR, airborne, everything, pieces, record, world_of
from miniature import RELEASES

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.common.errors import CrazychoirError, StateError
from crazychoir_fw.firmware.levels import ALGORITHMS, LEVELS, MODULES, STABILIZER
from crazychoir_fw.firmware.library import BUILD_LOG

NEWEST = "2026.08"
SYSTEM = (MODULES, STABILIZER)
TAKEOFF_2, GO_TO, LAND_2, STOP, START, DEFINE, SPIRAL = 7, 4, 8, 3, 5, 6, 11


@pytest.fixture(params=SYSTEM)
def word(request, level_word):
    """A provider that brings the firmware's own modules."""
    return level_word(NEWEST, request.param)


def duties(drone):
    return list(drone.struct.onboard.motors.list)


def printed(library):
    """Return what the compiler printed: it stands in the build log behind the commands, which are indented."""
    lines = (library.path.parent / BUILD_LOG).read_text().partition("\ncommands:\n")[2].splitlines()
    begin = next((i for i, line in enumerate(lines) if not line.startswith("  ")), len(lines))
    return "\n".join(lines[begin:])


# -- every release -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("level", LEVELS)
@pytest.mark.parametrize("release", RELEASES)
def test_every_release_builds_silently_and_flies_at_every_level(release, level, level_library, level_word):
    library = level_library(release, level)
    assert library.identity["level"] == level
    assert library.identity["notes"] == []
    assert printed(library) == ""

    world = airborne(level_word(release, level), height=0.6)
    drone = world.drones[0]
    np.testing.assert_allclose(drone.true_position, [0.0, 0.0, 0.6], atol=0.05)
    drone.high_level_commander.go_to(0.4, -0.2, 0.8, 0.5, duration_s=1.5)
    world.run(2.5)
    np.testing.assert_allclose(drone.true_position, [0.4, -0.2, 0.8], atol=0.08)
    drone.high_level_commander.upload_trajectory(1, pieces())
    drone.high_level_commander.start_trajectory(1, relative_position=True)
    world.run(2.5)
    np.testing.assert_allclose(drone.true_position, [0.4, -0.2, 0.8], atol=0.08)
    drone.high_level_commander.land(absolute_height_m=0.0, duration_s=2.0)
    world.run(3.0)
    assert drone.true_position[2] < 0.03
    assert duties(drone) == [0, 0, 0, 0]
    assert drone.failure is None
    assert drone.high_level_commander.is_trajectory_finished


@pytest.fixture
def around(level_word):
    """Return a provider with the algorithms of a release and our modules around them: the newest ones are builtin's."""

    def word(release):
        return "builtin" if release == NEWEST else level_word(release, ALGORITHMS)

    return word


@pytest.mark.parametrize("release", ["2025.12", "2026.08"])
def test_modules_fly_like_ours_bit_by_bit(release, around, level_word):
    ours, theirs = (everything(world_of(word)) for word in (around(release), level_word(release, MODULES)))
    assert ours[:, 2].max() > 0.6
    assert ours[-1, 2] < 0.03
    np.testing.assert_array_equal(theirs, ours)


def test_the_loop_of_a_checkout_flies_like_ours(level_word):
    ours, theirs = (everything(world_of(word)) for word in ("builtin", level_word(NEWEST, STABILIZER)))
    # the newest loop decides in one step whether motors may run, and looks at it in the next: 1 ms of difference
    np.testing.assert_allclose(theirs[:, :3], ours[:, :3], atol=0.02)
    np.testing.assert_allclose(theirs[-1, :3], ours[-1, :3], atol=0.02)


# -- the supervisor ------------------------------------------------------------------------------------------------


def test_emergency_stop_locks_until_reboot(word):
    world = airborne(word)
    drone = world.drones[0]
    drone.emergency_stop()
    world.run(0.1)
    assert duties(drone) == [0, 0, 0, 0]
    assert drone.is_locked
    assert drone.supervisor_state == "Locked"
    world.run(1.0)
    with pytest.raises(StateError):
        drone.high_level_commander.takeoff(absolute_height_m=0.5, duration_s=1.0)
    drone.reboot()
    world.wait_until_ready()
    drone.high_level_commander.takeoff(absolute_height_m=0.5, duration_s=1.5)
    world.run(2.0)
    assert drone.true_position[2] > 0.4


def test_stop_parameter_of_theirs_is_an_emergency_stop(word):
    world = airborne(word)
    drone = world.drones[0]
    drone.param["stabilizer.stop"] = 1
    world.run(0.1)
    assert drone.is_locked


def test_emergency_stop_watchdog_bites_when_it_is_no_longer_fed(word):
    world = airborne(word)
    drone = world.drones[0]
    for _ in range(8):
        drone.loc.send_emergency_stop_watchdog()
        world.run(0.25)
    assert drone.is_flying
    world.run(0.65)
    assert drone.is_flying
    world.run(0.2)
    assert drone.is_locked


@pytest.mark.parametrize("level", SYSTEM)
def test_brushless_platform_waits_for_arming(level, level_word):
    world = world_of(level_word(NEWEST, level, "cf21bl"), platform="cf21bl")
    drone = world.drones[0]
    world.run(3.0)
    assert not drone.can_fly
    assert drone.can_arm
    with pytest.raises(StateError):
        drone.high_level_commander.takeoff(absolute_height_m=0.5, duration_s=1.0)
    drone.arm()
    world.run(0.1)
    assert drone.can_fly
    assert drone.log["supervisor.info"] & 2
    drone.high_level_commander.takeoff(absolute_height_m=0.5, duration_s=1.5)
    world.run(2.0)
    assert drone.true_position[2] == pytest.approx(0.5, abs=0.05)
    drone.arm(False)
    world.run(0.1)
    assert duties(drone) == [0, 0, 0, 0]


def test_crash_stops_the_motors_and_is_recovered_from_on_the_feet(word):
    world = airborne(word)
    drone = world.drones[0]
    upside_down = [0.0, 0.0, 0.03, 0.0, 1.0, 0.0, 0.0]
    for _ in range(100):
        world.data.qpos[drone.qpos_address : drone.qpos_address + 7] = upside_down
        world.data.qvel[drone.qvel_address : drone.qvel_address + 6] = 0.0
        world.step(10)
    assert drone.is_crashed
    assert duties(drone) == [0, 0, 0, 0]
    with pytest.raises(StateError):
        drone.recover_from_crash()
    drone.place((0.0, 0.0, 0.02))
    world.run(1.5)
    drone.recover_from_crash()
    world.wait_until_ready()
    assert not drone.is_crashed


def test_setpoints_that_no_longer_come_level_out_and_then_stop(word):
    world = airborne(word)
    drone = world.drones[0]
    for _ in range(50):
        drone.commander.send_velocity_world_setpoint(0.3, 0.0, 0.0, 0.0)
        world.run(0.02)
    assert drone.true_velocity[0] > 0.15
    world.run(0.45)
    assert drone.supervisor_state == "Flying"
    world.run(0.15)
    assert drone.supervisor_state == "Warning, level out"
    assert drone.log["ctrltarget.roll"] == drone.log["ctrltarget.pitch"] == 0.0
    world.run(1.3)
    assert duties(drone) != [0, 0, 0, 0]
    world.run(0.2)
    assert drone.is_locked
    assert duties(drone) == [0, 0, 0, 0]


# -- parameters ----------------------------------------------------------------------------------------------------


def test_controllers_are_changed_in_flight(word):
    world = airborne(word)
    drone = world.drones[0]
    for number in (2, 1, 5, 1):
        drone.param["stabilizer.controller"] = number
        world.run(1.5)
        assert drone.param["stabilizer.controller"] == number
        assert drone.struct.onboard.controller_type == number
        np.testing.assert_allclose(drone.true_position, [0.0, 0.0, 0.5], atol=0.1)


def test_estimators_are_changed_in_flight(word):
    """Without a place the drone drifts, and sinks before the height is found: as the builtin one does."""
    paths = []
    for provider in ("builtin", word):
        world = airborne(provider, decks=["zranger"])
        drone = world.drones[0]
        path = []
        for number, seconds in ((1, 2.0), (2, 2.0)):
            drone.param["stabilizer.estimator"] = number
            for _ in range(10):
                world.run(seconds / 10)
                path.append(drone.true_position)
            assert drone.param["stabilizer.estimator"] == number
            assert drone.struct.onboard.estimator_type == number
        np.testing.assert_allclose(drone.true_position, [0.0, 0.0, 0.5], atol=0.1)
        paths.append(path)
    np.testing.assert_allclose(paths[1], paths[0], atol=0.02)


def test_parameters_and_log_variables_of_theirs_take_the_place_of_ours(word):
    ours, theirs = world_of("builtin", word).drones
    assert sorted(set(ours.param) - set(theirs.param)) == []
    assert sorted(set(ours.log) - set(theirs.log)) == []
    # where ours would lie, nothing is read and nothing is written
    theirs.struct.onboard.high_level.vtoff = 9.0
    assert theirs.param["hlCommander.vtoff"] == 0.5
    theirs.param["supervisor.landedTimeout"] = 4321
    assert theirs.struct.onboard.supervisor.landedTimeout != 4321


def test_takeoff_velocity_of_theirs_counts(word):
    heights = []
    for velocity in (0.25, 0.5):
        world = world_of(word, parameters={"hlCommander.vtoff": velocity})
        drone = world.drones[0]
        world.wait_until_ready()
        drone.receive_packet(HIGH_LEVEL, 0, record(9, "f?f?f", 1.0, False, 0.0, False, 0.0))
        world.run(2.0)
        assert drone.param["hlCommander.vtoff"] == velocity
        heights.append(drone.true_position[2])
    assert heights[0] < 0.55 < 0.85 < heights[1]


def test_every_command_of_c_reaches_the_modules(word):
    world = world_of(word)
    world.wait_until_ready()
    drone = world.drones[0]
    cf = drone.struct
    assert lib.cf_takeoff_with_velocity(cf, 0.9, True, 0.6, 0.0, True) == lib.CF_OK
    world.run(2.5)
    assert drone.true_position[2] == pytest.approx(0.9, abs=0.1)
    memory, read = pieces().astype("<f4").tobytes(), ffi.new("uint8_t[]", 264)
    assert lib.cf_write_trajectory(cf, 132, len(memory), memory) == lib.CF_OK
    assert lib.cf_read_trajectory(cf, 132, len(memory), read) == lib.CF_OK
    assert bytes(read) == memory
    assert lib.cf_land_with_velocity(cf, 0.0, False, 0.6, 0.0, True) == lib.CF_OK
    world.run(1.0)
    assert 0.1 < drone.true_position[2] < 0.8
    assert lib.cf_stop(cf) == lib.CF_OK
    world.run(0.1)
    assert duties(drone) == [0, 0, 0, 0]


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_commands_with_bad_numbers_are_refused_before_they_are_sent(bad, level_word):
    cf = world_of(level_word(NEWEST, MODULES)).drones[0].struct
    refused = [
        lib.cf_takeoff(cf, bad, 1.0, 0.0, True),
        lib.cf_land(cf, 0.0, 1.0, bad, False),
        lib.cf_takeoff_with_velocity(cf, 1.0, False, bad, 0.0, True),
        lib.cf_land_with_velocity(cf, 0.0, False, 0.5, bad, False),
        lib.cf_go_to(cf, 0.0, bad, 1.0, 0.0, 1.0, False, False),
        lib.cf_spiral(cf, ffi.new("cf_spiral_t *", {"duration": 1.0, "radius0": bad})),
        lib.cf_start_trajectory(cf, 1, bad, False, False, False),
    ]
    assert set(refused) == {lib.CF_ERR_VALUE}
    assert lib.cf_start_trajectory(cf, 9, 1.0, False, False, False) == lib.CF_ERR_UNKNOWN
    assert lib.cf_define_trajectory(cf, 1, 9, 0, 1) == lib.CF_ERR_UNKNOWN
    assert lib.cf_write_trajectory(cf, 1 << 20, 1, b"x") != lib.CF_OK


def test_reboot_brings_back_what_a_drone_was_at_boot(word):
    world = airborne(word)
    drone = world.drones[0]
    drone.param["hlCommander.vtoff"] = 2.0
    drone.param["stabilizer.controller"] = 2
    drone.high_level_commander.land(absolute_height_m=0.0, duration_s=1.5)
    world.run(2.0)
    drone.reboot()
    assert drone.param["hlCommander.vtoff"] == 0.5
    assert drone.param["stabilizer.controller"] == 1
    assert not drone.can_fly
    world.wait_until_ready()
    drone.high_level_commander.takeoff(absolute_height_m=0.5, duration_s=1.5)
    world.run(2.5)
    assert drone.true_position[2] == pytest.approx(0.5, abs=0.05)


# -- clients -------------------------------------------------------------------------------------------------------


def test_commands_before_the_first_tick_are_obeyed(word):
    world = world_of(word)
    drone = world.drones[0]
    drone.high_level_commander.set_group_mask(2)
    drone.high_level_commander.upload_trajectory(1, pieces())
    world.run(0.1)
    assert drone.param["hlCommander.groupmask"] == 2


def test_groups_are_obeyed(word):
    world = world_of(word, word)
    first, second = world.drones
    world.wait_until_ready()
    first.high_level_commander.set_group_mask(1)
    second.high_level_commander.set_group_mask(2)
    for drone in world.drones:
        drone.high_level_commander.takeoff(absolute_height_m=0.5, duration_s=1.5, group_mask=2)
    world.run(2.0)
    assert first.true_position[2] < 0.05
    assert second.true_position[2] == pytest.approx(0.5, abs=0.05)
    assert [drone.param["hlCommander.groupmask"] for drone in world.drones] == [1, 2]
    second.param["hlCommander.groupmask"] = 4
    world.run(0.01)
    second.high_level_commander.land(absolute_height_m=0.0, duration_s=1.0, group_mask=2)
    world.run(1.5)
    assert second.true_position[2] > 0.4


def packets():
    """Packets of a client, in an order that a flight takes: port, channel, data, and how long they are flown (s)."""
    takeoff = record(TAKEOFF_2, "ff?f", 0.5, 0.0, False, 1.0)
    definition = struct.pack("<BBBBIB", DEFINE, 3, 1, 0, 0, 2)
    return [
        (SUPERVISOR, 0, bytes([0x0C]), 0.0),
        (SUPERVISOR, 0, bytes([1]), 0.0),
        (SUPERVISOR, 1, bytes([1, 1]), 0.1),
        (HIGH_LEVEL, 0, bytes([0, 5]), 0.0),
        (HIGH_LEVEL, 0, takeoff, 1.2),
        *[(SUPERVISOR, 0, bytes([query]), 0.0) for query in range(1, 13)],
        (HIGH_LEVEL, 0, takeoff[:5], 0.0),
        (HIGH_LEVEL, 0, record(GO_TO, "?fffff", True, 0.2, 0.0, 0.0, 0.0, 1.0), 0.5),
        (HIGH_LEVEL, 0, record(START, "??Bf", True, False, 9, 1.0), 0.0),
        (HIGH_LEVEL, 0, definition, 0.0),
        (HIGH_LEVEL, 0, record(SPIRAL, "??fffff", False, False, 1.0, 0.2, 0.3, 0.0, 1.0), 0.5),
        (HIGH_LEVEL, 0, bytes([99, 0, 0]), 0.0),
        (GENERIC, 0, b"\x07" + struct.pack("<4f", 0.1, 0.0, 0.5, 0.0), 0.2),
        (GENERIC, 0, b"\x08" + struct.pack("<4f", 0.1, 0.0, 0.0, 0.0), 0.2),
        (GENERIC, 0, b"\x0a" + struct.pack("<4f", 0.1, 0.0, 5.0, 0.5), 0.2),
        (GENERIC, 0, b"\x09" + struct.pack("<4f", 1.0, 0.0, 5.0, 0.5), 0.1),
        (RPYT, 0, bytes(14), 0.0),
        (RPYT, 0, struct.pack("<3fH", 1.0, -1.0, 3.0, 40000), 0.1),
        (GENERIC, 1, b"\0" + struct.pack("<I", 0), 0.0),
        (HIGH_LEVEL, 0, record(LAND_2, "ff?f", 0.0, 0.0, True, 1.0), 1.5),
        (HIGH_LEVEL, 0, record(STOP, ""), 0.1),
        (SUPERVISOR, 1, bytes([2]), 0.0),
        (SUPERVISOR, 1, bytes([3]), 0.1),
        (SUPERVISOR, 0, bytes([7]), 0.0),
        (HIGH_LEVEL, 0, takeoff, 0.0),
    ]


def answers(word):
    world = world_of(word)
    drone = world.drones[0]
    drone.high_level_commander.upload_trajectory(1, pieces())
    world.run(2.0)
    received = []
    for port, channel, data, seconds in packets():
        try:
            received.append(drone.receive_packet(port, channel, data))
        except CrazychoirError as error:
            received.append(type(error).__name__)
        world.run(seconds)
    return received, world.data.qpos.copy()


@pytest.mark.parametrize("release", ["2025.12", "2026.08"])
def test_answers_to_packets_are_those_of_builtin(release, around, level_word):
    ours, path = answers(around(release))
    theirs, other = answers(level_word(release, MODULES))
    asked = [f"port {port} channel {channel}: {data.hex(' ')}" for port, channel, data, _ in packets()]
    if release == NEWEST:
        assert dict(zip(asked, theirs, strict=True)) == dict(zip(asked, ours, strict=True))
    np.testing.assert_array_equal(other, path)


def test_a_trajectory_that_was_defined_by_a_packet_is_started_by_a_command(word):
    world = airborne(word)
    drone = world.drones[0]
    drone.high_level_commander.upload_trajectory(1, pieces(), offset=0)
    drone.receive_packet(HIGH_LEVEL, 0, struct.pack("<BBBBIB", DEFINE, 7, 1, 0, 0, 2))
    drone.high_level_commander.start_trajectory(7, relative_position=True)
    world.run(1.0)
    assert drone.true_position[0] > 0.1


# -- other drones, and decks ---------------------------------------------------------------------------------------


def test_drones_of_theirs_avoid_each_other(word):
    distances = []
    for enable in (0, 1):
        world = airborne(word, word, spacing=1.0, parameters={"colAv.enable": enable})
        first, second = world.drones
        first.high_level_commander.go_to(1.0, 0.02, 0.5, 0.0, duration_s=3.0)
        second.high_level_commander.go_to(0.0, -0.02, 0.5, 0.0, duration_s=3.0)
        nearest = np.inf
        for _ in range(300):
            world.step(10)
            nearest = min(nearest, np.linalg.norm(first.true_position[:2] - second.true_position[:2]))
        distances.append(nearest)
    assert distances[0] < 0.2
    assert distances[1] > 0.3


DECKS = {
    "lighthouse": {"positioning": "lighthouse"},
    "loco_tdoa3": {"positioning": "loco_tdoa3"},
    "loco_twr": {"positioning": "loco_twr"},
    "flow": {"positioning": "flow"},
}


@pytest.mark.parametrize("deck", DECKS)
def test_drones_of_theirs_fly_with_a_deck(deck, level_word):
    paths = []
    for provider in ("builtin", level_word(NEWEST, MODULES), level_word(NEWEST, STABILIZER)):
        world = airborne(provider, **DECKS[deck])
        drone = world.drones[0]
        drone.high_level_commander.go_to(0.3, 0.2, 0.6, 0.0, duration_s=1.5)
        world.run(2.5)
        assert drone.failure is None
        np.testing.assert_allclose(drone.true_position, [0.3, 0.2, 0.6], atol=0.25)
        paths.append(drone.true_position)
    # before the filter has found its place, it sees the first sweeps differently
    np.testing.assert_allclose(paths[1], paths[0], rtol=0.0, atol=0.001 if deck == "lighthouse" else 0.0)
    np.testing.assert_allclose(paths[2], paths[0], atol=0.1)


def test_a_height_is_held_with_the_complementary_estimator_of_theirs(word):
    world = world_of(word, positioning="none", decks=["zranger"], estimator="complementary")
    drone = world.drones[0]
    world.wait_until_ready()
    assert drone.param["stabilizer.estimator"] == 1
    for _ in range(150):
        drone.commander.send_zdistance_setpoint(0.0, 0.0, 0.0, 0.4)
        world.run(0.02)
    assert drone.failure is None
    assert drone.true_position[2] == pytest.approx(0.4, abs=0.1)
