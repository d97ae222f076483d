"""Every memory with the client's own class for it."""

import numpy as np
import pytest
from cflib.crazyflie.mem import (
    LighthouseBsCalibration,
    LighthouseBsGeometry,
    LighthouseMemHelper,
    MemoryElement,
)
from memory_client import MemoryClient

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.crtp.memories.eeprom import Configuration
from crazychoir_fw.simulation import DroneConfig, World


def connected(**chosen):
    world = World([DroneConfig("cf1", **chosen)], visuals=False)
    return MemoryClient(world, world["cf1"]).connect()


@pytest.mark.parametrize(
    ("chosen", "of_decks"),
    [
        ({}, []),
        ({"positioning": "lighthouse"}, [0x01]),
        ({"positioning": "loco_twr", "decks": ["multiranger", "zranger"]}, [0x11, 0x13, 0x01, 0x01, 0x01]),
    ],
)
def test_the_client_connects(chosen, of_decks):
    client = connected(**chosen)
    assert [memory.type for memory in client.mem.mems] == [0x00, 0x10, 0x17, 0x12, 0x14, 0x15, 0x19, *of_decks]
    assert all(memory.valid for memory in client.mem.get_mems(MemoryElement.TYPE_1W))


def test_memories_outlive_a_session():
    client = connected()
    memory = client.memory(MemoryElement.TYPE_DRIVER_LED)
    client.mem.write(memory, 0, bytes((0xF8, 0)))
    client.read()
    client.station.end_session()
    client.connect().carry_out()
    assert client.drone.lights.ring[0].tolist() == [1.0, 0.0, 0.0]


# ---------------------------------------------------------------------------- decks


@pytest.mark.parametrize(
    ("chosen", "decks"),
    [
        ({"positioning": "flow"}, [("bcFlow2", 0x0F)]),
        ({"positioning": "lighthouse"}, [("bcLighthouse4", 0x10)]),
        ({"positioning": "loco_tdoa3"}, [("bcDWM1000", 0x06)]),
        ({"decks": ["multiranger"]}, [("bcMultiranger", 0x0C)]),
        ({"decks": ["zranger"]}, [("bcZRanger2", 0x0E)]),
        ({"positioning": "flow", "decks": ["multiranger"]}, [("bcFlow2", 0x0F), ("bcMultiranger", 0x0C)]),
        ({"positioning": "mocap"}, []),
    ],
)
def test_the_client_learns_which_decks_there_are(chosen, decks):
    client = connected(**chosen)
    found = client.mem.get_mems(MemoryElement.TYPE_1W)
    assert [(deck.elements["Board name"], deck.pid) for deck in found] == decks
    for deck in found:
        assert (deck.valid, deck.vid, deck.size) == (True, 0xBC, 112)
        assert deck.elements["Board revision"] == "A"
        assert client.drone.param[f"deck.{deck.elements['Board name']}"] == 1
        assert client.mem.ow_search(pid=deck.pid) is deck


def test_serial_numbers_differ():
    world = World([DroneConfig(f"cf{i}", positioning="flow", decks=["multiranger"]) for i in (1, 2)], visuals=False)
    clients = [MemoryClient(world, drone).connect() for drone in world.drones]
    serials = [deck.addr for client in clients for deck in client.mem.get_mems(MemoryElement.TYPE_1W)]
    assert len(set(serials)) == 4
    assert {len(serial) for serial in serials} == {16}


def test_a_deck_can_be_written_and_erased():
    client = connected(positioning="flow")
    deck = client.memory(MemoryElement.TYPE_1W)
    deck.elements["Custom"] = "mine"
    client.call(deck.write_data)
    deck.elements = {}
    client.call(deck.update)
    assert (deck.valid, deck.elements["Custom"], deck.elements["Board name"]) == (True, "mine", "bcFlow2")
    client.call(deck.erase)
    client.connect()  # and the client survives it
    assert not client.memory(MemoryElement.TYPE_1W).valid


@pytest.mark.parametrize(("positioning", "names"), [("lighthouse", ["bcLighthouse4"]), ("flow", [])])
def test_decks_with_firmware_are_listed(positioning, names):
    client = connected(positioning=positioning)
    manager = client.memory(MemoryElement.TYPE_DECK_MEMORY)
    (decks,) = client.call(manager.query_decks)
    assert [deck.name for deck in decks.values()] == names
    for deck in decks.values():
        assert deck.is_valid
        assert deck.is_started
        assert not (deck.supports_read or deck.supports_write or deck.supports_fw_upgrade or deck.is_bootloader_active)


# ---------------------------------------------------------------------------- tester


def test_the_tester_is_read_and_written_without_an_error():
    client = connected()
    client.world.wait_until_ready()
    tester = client.memory(MemoryElement.TYPE_MEMORY_TESTER)
    client.call(tester.read_data, 5, 1000)
    assert tester.readValidationSuccess
    client.call(tester.write_data, 5, 1000)
    client.carry_out()
    assert client.drone.log["memTst.errCntW"] == 0


def test_wrong_bytes_for_the_tester_are_counted_until_they_are_cleared():
    client = connected()
    client.world.wait_until_ready()
    tester = client.memory(MemoryElement.TYPE_MEMORY_TESTER)
    client.mem.write(tester, 0x10, bytes((0x10, 0x12)))
    client.mem.write(tester, 0x100, bytes((0, 1, 2)))
    client.mem.write(tester, 0x20, bytes(30))
    client.read()
    client.carry_out()
    assert client.drone.log["memTst.errCntW"] == 3  # packets
    client.drone.param["memTst.resetW"] = 1
    client.world.run(0.1)
    assert client.drone.log["memTst.errCntW"] == 0


# ---------------------------------------------------------------------------- lights


def test_colors_of_the_ring_arrive():
    client = connected()
    ring = client.memory(MemoryElement.TYPE_DRIVER_LED)
    ring.leds[0].set(255, 0, 0)
    ring.leds[1].set(0, 255, 0)
    ring.leds[11].set(0, 0, 255)
    client.call(ring.write_data)
    assert not client.drone.lights.ring.any()
    client.carry_out()
    expected = np.zeros((12, 3))
    expected[0, 0] = expected[1, 1] = expected[11, 2] = 1.0
    assert np.array_equal(client.drone.lights.ring, expected)


def test_a_show_of_the_ring_arrives():
    client = connected()
    show = client.memory(MemoryElement.TYPE_DRIVER_LEDTIMING)
    for i in range(1, 119):
        show.add(time=i, rgb={"r": 255, "g": 0, "b": 0}, leds=i % 16, fade=i % 2 == 0, rotate=i % 8)
    client.call(show.write_data)
    client.carry_out()
    entries = client.drone.lights.show
    assert len(entries) == 118
    assert entries[2] == (3, (1.0, 0.0, 0.0), 3, False, 3)
    assert entries[3] == (4, (1.0, 0.0, 0.0), 4, True, 4)


def test_lights_are_part_of_a_snapshot_and_dark_after_a_boot():
    client = connected()
    ring = client.memory(MemoryElement.TYPE_DRIVER_LED)
    ring.leds[3].set(255, 255, 255)
    before = client.drone.snapshot()
    client.call(ring.write_data)
    client.carry_out()
    lit = client.drone.snapshot()
    client.drone.restore(before)
    assert not client.drone.lights.ring.any()
    client.drone.restore(lit)
    assert client.drone.lights.ring[3].tolist() == [1.0, 1.0, 1.0]
    client.drone.reboot()
    assert not client.drone.lights.ring.any()


# ---------------------------------------------------------------------------- configuration


def test_the_configuration_block_is_valid_from_the_start():
    world = World([DroneConfig("cf1"), DroneConfig("cf2")], visuals=False)
    client = MemoryClient(world, world["cf2"]).connect()
    block = client.memory(MemoryElement.TYPE_I2C)
    client.call(block.update)
    assert block.valid
    assert block.elements == {
        "version": 1,
        "radio_channel": 80,
        "radio_speed": 2,
        "pitch_trim": 0.0,
        "roll_trim": 0.0,
        "radio_address": 0xE7E7E7E702,
    }


def test_trims_and_address_count_after_a_reboot_and_stay():
    client = connected()
    block = client.memory(MemoryElement.TYPE_I2C)
    client.call(block.update)
    block.elements |= {"radio_channel": 42, "pitch_trim": 2.0, "roll_trim": -1.0, "radio_address": 0xE7E7E7E733}
    client.call(block.write_data)
    client.carry_out()
    onboard = client.drone.struct.onboard
    assert (onboard.radio_id, onboard.sensors.is_trimmed) == (1, False)
    for _ in range(2):
        client.drone.reboot()
        assert (onboard.radio_id, onboard.sensors.is_trimmed) == (0x33, True)
        assert onboard.sensors.trim_sin_pitch == pytest.approx(np.sin(np.radians(2.0)))
        assert onboard.sensors.trim_sin_roll == pytest.approx(np.sin(np.radians(-1.0)))
    block.elements = {}
    client.call(block.update)
    assert (block.valid, block.elements["radio_channel"]) == (True, 42)


def test_a_block_of_the_first_version_is_understood():
    client = connected()
    block = client.memory(MemoryElement.TYPE_I2C)
    block.elements = {"version": 0, "radio_channel": 10, "radio_speed": 1, "pitch_trim": 3.0, "roll_trim": 0.0}
    client.call(block.write_data)
    client.carry_out()
    client.drone.reboot()
    assert client.drone.struct.onboard.sensors.is_trimmed
    assert client.drone.struct.onboard.radio_id == 1
    client.call(block.update)
    assert block.valid


def test_a_damaged_block_changes_nothing():
    client = connected()
    eeprom = client.memory(MemoryElement.TYPE_I2C)
    client.mem.write(eeprom, 7, np.float32(5.0).tobytes())  # a trim, and the old checksum
    client.read()
    client.carry_out()
    assert Configuration.of(client.drone) is None
    client.drone.reboot()
    assert not client.drone.struct.onboard.sensors.is_trimmed
    client.call(eeprom.update)
    assert not eeprom.valid


def test_trims_that_are_no_numbers_change_nothing():
    client = connected()
    eeprom = client.memory(MemoryElement.TYPE_I2C)
    client.call(eeprom.update)
    eeprom.elements["pitch_trim"] = float("nan")
    client.call(eeprom.write_data)
    client.carry_out()
    client.drone.reboot()
    assert not client.drone.struct.onboard.sensors.is_trimmed


def test_the_block_can_be_written_without_a_client():
    client = connected()
    chosen = Configuration(channel=20, speed=1, address=0xE7E7E7E7AB, pitch_trim=0.5)
    chosen.write(client.drone)
    assert Configuration.of(client.drone) == chosen
    eeprom = client.memory(MemoryElement.TYPE_I2C)
    client.call(eeprom.update)
    assert eeprom.valid
    assert eeprom.elements["radio_address"] == 0xE7E7E7E7AB


@pytest.mark.parametrize(
    "wrong",
    [{"channel": 126}, {"channel": -1}, {"speed": 3}, {"address": 1 << 40}, {"pitch_trim": float("inf")}],
)
def test_a_block_out_of_range_is_refused(wrong):
    drone = World([DroneConfig("cf1")], visuals=False)["cf1"]
    with pytest.raises(RangeError, match="cf1: Configuration"):
        Configuration(**wrong).write(drone)


# ---------------------------------------------------------------------------- lighthouse


def test_base_stations_are_read_as_the_drone_knows_them():
    client = connected(positioning="lighthouse")
    helper = LighthouseMemHelper(client.cf)
    (geometries,) = client.call(helper.read_all_geos)
    (calibrations,) = client.call(helper.read_all_calibs)
    assert list(geometries) == list(calibrations) == [0, 1]
    for number, geometry in geometries.items():
        station = client.drone.struct.onboard.estimator.stations.list[number]
        assert geometry.valid
        assert geometry.origin == list(station.origin)
        assert geometry.rotation_matrix == [list(row) for row in station.rotation]
        assert np.allclose(
            np.array(geometry.rotation_matrix) @ np.transpose(geometry.rotation_matrix), np.eye(3), atol=1e-6
        )
    assert [(calibration.uid, calibration.valid) for calibration in calibrations.values()] == [(1, True), (2, True)]


def test_a_drone_without_the_deck_knows_no_base_stations():
    client = connected()
    (geometries,) = client.call(LighthouseMemHelper(client.cf).read_all_geos)
    assert [geometry.valid for geometry in geometries.values()] == [False, False]


def geometry(origin, valid=True):
    result = LighthouseBsGeometry()
    result.origin, result.rotation_matrix, result.valid = origin, np.eye(3).tolist(), valid
    return result


def calibration():
    result = LighthouseBsCalibration()
    for number, sweep in enumerate(result.sweeps):
        names = ("phase", "tilt", "curve", "gibmag", "gibphase", "ogeemag", "ogeephase")
        for i, name in enumerate(names):
            setattr(sweep, name, (number * 7 + i + 1) / 128)
    result.uid, result.valid = 0xDEADBEEF, True
    return result


def test_what_is_written_is_read_at_once_and_used_after_the_next_step():
    client = connected(positioning="lighthouse")
    helper = LighthouseMemHelper(client.cf)
    assert client.call(helper.write_geos, {1: geometry([1.0, 2.0, 3.0])}) == (True,)
    assert client.call(helper.write_calibs, {0: calibration()}) == (True,)
    (geometries,) = client.call(helper.read_all_geos)
    (calibrations,) = client.call(helper.read_all_calibs)
    assert geometries[1].origin == [1.0, 2.0, 3.0]
    assert calibrations[0].as_file_object() == calibration().as_file_object()

    stations = client.drone.struct.onboard.estimator.stations.list
    assert list(stations[1].origin) != [1.0, 2.0, 3.0]
    client.carry_out()
    assert list(stations[1].origin) == [1.0, 2.0, 3.0]
    assert stations[0].calibration.uid == 0xDEADBEEF
    assert stations[0].calibration.sweep[1].ogeephase == 14 / 128
    assert stations[0].calibration.sweep[0].gibphase == 5 / 128
    assert client.call(helper.read_all_geos)[0][1].origin == [1.0, 2.0, 3.0]


def test_other_base_stations_are_refused():
    client = connected(positioning="lighthouse")
    helper = LighthouseMemHelper(client.cf)
    assert client.call(helper.write_geos, {0: geometry([0.0, 0.0, 2.0]), 2: geometry([0.0, 0.0, 2.0])}) == (False,)
    assert client.call(helper.write_calibs, {15: calibration()}) == (False,)


@pytest.mark.parametrize("number", [float("nan"), float("inf")])
def test_geometry_that_is_no_number_is_refused(number):
    client = connected(positioning="lighthouse")
    helper = LighthouseMemHelper(client.cf)
    before = client.drone.memory.copy()
    assert client.call(helper.write_geos, {0: geometry([number, 0.0, 2.0])}) == (False,)
    client.carry_out()
    assert (client.drone.memory == before).all()


def test_a_drone_flies_by_the_geometry_that_it_is_told():
    """Base stations that are said to be 0.5 m farther make the drone believe that it is 0.5 m farther."""
    client = connected(positioning="lighthouse")
    world, drone = client.world, client.drone
    world.wait_until_ready()
    helper = LighthouseMemHelper(client.cf)
    (geometries,) = client.call(helper.read_all_geos)
    for each in geometries.values():
        each.origin = [each.origin[0] + 0.5, *each.origin[1:]]
    assert client.call(helper.write_geos, geometries) == (True,)
    client.carry_out()
    drone.param["kalman.resetEstimation"] = 1
    world.run(0.1)
    drone.param["kalman.resetEstimation"] = 0
    world.run(2.0)
    assert drone.estimated_position - drone.true_position == pytest.approx([0.5, 0.0, 0.0], abs=0.05)
    assert drone.log["lighthouse.bsGeoVal"] == 3


# ---------------------------------------------------------------------------- loco


@pytest.fixture(scope="module")
def loco():
    client = connected(positioning="loco_tdoa2")
    client.world.run(2.0)
    return client


def anchors(drone):
    return [tuple(anchor) for anchor in drone.struct.onboard.decks.loco.anchors]


def test_anchors_of_the_first_memory(loco):
    memory = loco.memory(MemoryElement.TYPE_LOCO)
    loco.call(memory.update)
    assert memory.valid
    assert memory.nr_of_anchors == 8
    assert [anchor.position for anchor in memory.anchor_data] == anchors(loco.drone)
    assert all(anchor.is_valid for anchor in memory.anchor_data)
    assert len(set(anchors(loco.drone))) == 8


def test_anchors_of_the_second_memory(loco):
    memory = loco.memory(MemoryElement.TYPE_LOCO2)
    loco.call(memory.update_id_list)
    loco.call(memory.update_active_id_list)
    loco.call(memory.update_data)
    assert memory.anchor_ids == memory.active_anchor_ids == list(range(8))
    assert [memory.anchor_data[number].position for number in range(8)] == anchors(loco.drone)


def test_nobody_is_heard_at_first():
    client = connected(positioning="loco_tdoa2")
    memory = client.memory(MemoryElement.TYPE_LOCO2)
    client.call(memory.update_active_id_list)
    assert memory.active_ids_valid
    assert memory.active_anchor_ids == []


@pytest.mark.parametrize("type", [MemoryElement.TYPE_LOCO, MemoryElement.TYPE_LOCO2, MemoryElement.TYPE_DECK_MEMORY])
def test_some_memories_cannot_be_written(loco, type):
    failed = []
    loco.mem.mem_write_failed_cb.add_callback(lambda memory, address: failed.append(memory.type))
    if type == MemoryElement.TYPE_DECK_MEMORY:  # whose class wants a callback of its own
        number = loco.memory(type).id
        (reply,) = loco.station.receive(bytes((0x4E, number, 4, 0x10, 0, 0, 1)))
        assert reply[-1] == 5
    else:
        loco.mem.write(loco.memory(type), 0, b"\0")
        loco.pump()
        assert failed == [type]


@pytest.mark.parametrize(("address", "length"), [(0, 2), (1, 1), (0x1000, 12), (0x1001, 13), (0x1080, 1), (0x1800, 13)])
def test_other_reads_of_the_first_memory_are_refused(loco, address, length):
    number = loco.memory(MemoryElement.TYPE_LOCO).id
    (reply,) = loco.station.receive(bytes((0x4D, number)) + address.to_bytes(4, "little") + bytes((length,)))
    assert reply[6:] == b"\x05"
