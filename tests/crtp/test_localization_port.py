"""Port 6: positions from outside and streams of positioning decks (docs/reference/crtp-cflib.md#14 and #21)."""

import struct
from itertools import pairwise

import mujoco
import numpy as np
import pytest
from cflib.localization.lighthouse_bs_vector import LighthouseBsVector
from cflib_client import Client
from hypothesis import given
from hypothesis import strategies as st

from crazychoir_fw._core import lib
from crazychoir_fw.crtp.packet import MAX_PAYLOAD, Packet, parse
from crazychoir_fw.crtp.services.localization import LocalizationService
from crazychoir_fw.crtp.station import Station
from crazychoir_fw.simulation import DroneConfig, World

RANGES, ANGLES, MATCHED = 0, 10, 12


def bench(**options):
    world = World([DroneConfig("cf1", **options)], visuals=False)
    return Station(world, world["cf1"])


def service_of(station):
    return next(service for service in station.services if isinstance(service, LocalizationService))


def send(station, channel, payload):
    assert station.receive(Packet(6, channel, payload).to_bytes()) == []
    station.context.carry_out()
    return [parse(datagram) for datagram, _ in station.context.take_out()]


@pytest.fixture
def station():
    return bench()


# --------------------------------------------------------------------------------- to the drone


def test_external_position_of_cflib(station):
    client = Client(station)
    client.cf.extpos.send_extpos(1, 2, 3)
    client.cf.loc.send_extpos((1, 2, 3))
    assert client.link.sent == [(6, 0, bytes.fromhex("0000803F 00000040 00004040"))] * 2
    station.context.carry_out()
    assert [station.context.drone.log[f"ext_pos.{axis}"] for axis in "XYZ"] == [1, 2, 3]


def test_external_pose_of_cflib(station):
    client = Client(station)
    client.cf.loc.send_extpose((1, 2, 3), (0, 0, 0, 1))
    payload = "08 0000803F 00000040 00004040 00000000 00000000 00000000 0000803F"
    assert client.link.sent == [(6, 1, bytes.fromhex(payload))]
    station.context.world.step(7)
    station.context.carry_out()
    log = station.context.drone.log
    assert [log[f"locSrv.{name}"] for name in ("x", "y", "z", "qx", "qy", "qz", "qw")] == [1, 2, 3, 0, 0, 0, 1]
    assert log["locSrvZ.tick"] == station.context.drone.struct.onboard.tick


def test_packed_positions_name_drones_by_the_low_byte_of_their_address(station):
    own = station.context.drone.struct.onboard.radio_id
    item = struct.pack("<B3h", own + 1, 1, 2, 3) + struct.pack("<B3h", own, 1000, 2000, 3000)
    assert send(station, 2, item) == []
    assert [station.context.drone.log[f"ext_pos.{axis}"] for axis in "XYZ"] == [1, 2, 3]


def test_persistent_lighthouse_data_and_ultra_wideband_packets_are_answered_with_no(station):
    client = Client(station)
    client.cf.loc.send_lh_persist_data_packet([0, 1], [2])
    client.cf.loc.send_short_lpp_packet(5, b"\1\2")
    assert client.link.sent[0] == (6, 1, bytes.fromhex("0B 0300 0400"))
    station.context.carry_out()
    assert [parse(datagram) for datagram, _ in station.context.take_out()] == [(6, 1, b"\x0b\0"), (6, 1, b"\x02\5\0")]


@pytest.mark.parametrize(
    ("channel", "payload"),
    [(0, b""), (0, bytes(11)), (0, b"\xff" * 12), (1, b""), (1, b"\x08"), (1, b"\x55"), (2, b"\1"), (3, b"\0")],
)
def test_bad_packets_are_swallowed_and_counted(station, channel, payload):
    before = station.context.drone.memory.copy()
    assert send(station, channel, payload) == []
    service = service_of(station)
    assert service.positions.refused + service.packets.refused == 1
    assert (station.context.drone.memory == before).all()


def test_the_newest_of_many_positions_stays(station):
    for x in range(2000):
        station.receive(Packet(6, 0, struct.pack("<3f", x, 0, 0)).to_bytes())
    station.context.carry_out()
    assert station.context.drone.log["ext_pos.X"] == 1999
    assert service_of(station).positions.lost == 1900


SHARED = bench()


@given(st.integers(0, 3), st.binary(max_size=MAX_PAYLOAD))
def test_any_payload_is_survived(channel, payload):
    for port, back, answer in send(SHARED, channel, payload):
        assert (port, back) == (6, 1)
        assert answer[0] == payload[0]


# -------------------------------------------------------------------------------------- streams


class Listener:
    """A client that collects what a drone streams."""

    def __init__(self, station, **parameters):
        self.station = station
        self.client = Client(station)
        self.taken = []
        self.client.cf.loc.receivedLocationPacket.add_callback(self.taken.append)
        for name, value in parameters.items():
            station.context.drone.param[f"locSrv.{name}"] = value
        station.context.world.run(0.1)
        station.context.take_out()

    def packets(self, seconds):
        """Return what came meanwhile, as cflib decodes it."""
        self.taken.clear()
        self.station.context.world.run(seconds)
        self.client.read()
        return list(self.taken)


def ready(**options):
    station = bench(**options)
    station.context.world.wait_until_ready()
    return station


@pytest.fixture(scope="module")
def lighthouse():
    return ready(positioning="lighthouse")


@pytest.fixture(scope="module")
def loco():
    return ready(positioning="loco_twr")


@pytest.mark.parametrize("options", [{}, {"positioning": "lighthouse"}, {"positioning": "loco_twr"}])
def test_nothing_is_streamed_unasked(options):
    assert Listener(ready(**options)).packets(0.5) == []


def test_ranges_are_distances_to_anchors(loco):
    listener = Listener(loco, enRangeStreamFP32=1)
    drone = loco.context.drone
    before = drone.struct.onboard.decks.loco.streamed.written
    packets = listener.packets(0.5)
    assert len(packets) == pytest.approx((drone.struct.onboard.decks.loco.streamed.written - before) / 5, abs=1)
    assert len(packets) > 10
    anchors = np.array([list(anchor) for anchor in drone.struct.onboard.decks.loco.anchors])
    true = np.linalg.norm(anchors - drone.true_position, axis=1)
    for packet in packets:
        assert (packet.type, len(packet.raw_data)) == (RANGES, 25)
        for anchor, distance in packet.data.items():
            assert distance == pytest.approx(true[anchor], abs=1.0)  # with the errors that such ranges have
    drone.param["locSrv.enRangeStreamFP32"] = 0
    listener.packets(0.02)
    assert listener.packets(0.5) == []


def test_ranges_that_are_streamed_are_those_on_board(loco):
    listener = Listener(loco, enRangeStreamFP32=1)
    packets = listener.packets(0.3)
    latest = {anchor: distance for packet in packets for anchor, distance in packet.data.items()}
    logged = [loco.context.drone.log[f"ranging.distance{anchor}"] for anchor in range(8)]
    assert sum(latest.get(anchor) == distance for anchor, distance in enumerate(logged)) >= 3  # some came later
    loco.context.drone.param["locSrv.enRangeStreamFP32"] = 0


def test_ranges_survive_a_return_to_an_earlier_time(loco):
    world = loco.context.world
    before = world.snapshot()
    listener = Listener(loco, enRangeStreamFP32=1)
    first = [packet.raw_data for packet in listener.packets(0.3)]
    world.restore(before)
    loco.context.drone.param["locSrv.enRangeStreamFP32"] = 1
    world.run(0.1)
    listener.client.read()
    again = [packet.raw_data for packet in listener.packets(0.3)]
    assert len(again) == pytest.approx(len(first), abs=1)
    loco.context.drone.param["locSrv.enRangeStreamFP32"] = 0


def directions(drone, station, packet):
    """Return unit vectors from a base station to the sensors, as measured and as they are, each (4, 3)."""
    known = drone.struct.onboard.estimator.stations.list[station]
    rotation = np.array([list(row) for row in known.rotation])
    pairs = zip(packet.data["x"], packet.data["y"], strict=True)
    measured = np.array([rotation @ LighthouseBsVector(*pair).cart for pair in pairs])
    body = np.zeros(9)
    mujoco.mju_quat2Mat(body, drone.true_quat_wxyz)
    arms = np.array([list(lib.cf_lighthouse_sensor_position(i)[0]) for i in range(4)])
    true = drone.true_position + arms @ body.reshape(3, 3).T - np.array(list(known.origin))
    return measured, true / np.linalg.norm(true, axis=1, keepdims=True)


def test_angles_point_at_the_sensors(lighthouse):
    listener = Listener(lighthouse, enLhAngleStream=1)
    packets = listener.packets(0.5)
    assert {packet.type for packet in packets} == {ANGLES}
    assert {packet.data["basestation"] for packet in packets} == {0, 1}
    assert {len(packet.raw_data) for packet in packets} == {21}
    for packet in packets:
        measured, true = directions(lighthouse.context.drone, packet.data["basestation"], packet)
        assert measured == pytest.approx(true, abs=0.01)  # calibration and geometry have errors
        # differences between sensors do not
        assert np.diff(measured, axis=0) == pytest.approx(np.diff(true, axis=0), abs=1e-3)
    lighthouse.context.drone.param["locSrv.enLhAngleStream"] = 0
    assert Listener(lighthouse).packets(0.2) == []


def test_matched_angles_come_in_groups(lighthouse):
    packets = Listener(lighthouse, enLhMtchStm=1).packets(0.5)
    assert len(packets) > 10
    for first, second in zip(packets[::2], packets[1::2], strict=True):
        assert (first.type, len(first.raw_data)) == (MATCHED, 22)
        assert {first.data["basestation"], second.data["basestation"]} == {0, 1}
        assert first.data["group_id"] == second.data["group_id"]
        assert first.data["bs_count"] == second.data["bs_count"] == 2
    groups = [packet.data["group_id"] for packet in packets[::2]]
    assert all((later - earlier) % 16 == 1 for earlier, later in pairwise(groups))
    lighthouse.context.drone.param["locSrv.enLhMtchStm"] = 0


@pytest.mark.parametrize(("parameters", "count"), [({"minBsLhMtchStm": 3}, 0), ({"minBsLhMtchStm": 1}, 1)])
def test_a_group_has_as_many_base_stations_as_were_asked_for(lighthouse, parameters, count):
    packets = Listener(lighthouse, enLhMtchStm=1, **parameters).packets(0.3)
    assert (len(packets) > 0) == (count > 0)
    assert all(packet.data["bs_count"] >= count for packet in packets)
    lighthouse.context.drone.param["locSrv.enLhMtchStm"] = 0
    lighthouse.context.drone.param["locSrv.minBsLhMtchStm"] = 2


def test_turns_that_are_too_far_apart_make_no_group(lighthouse):
    """The rotors turn at different speeds, so that the ends of their turns are rarely the same millisecond."""
    together = len(Listener(lighthouse, enLhMtchStm=1, maxTimeLhMtchStm=25).packets(0.5))
    apart = len(Listener(lighthouse, enLhMtchStm=1, maxTimeLhMtchStm=0).packets(0.5))
    assert apart < together / 2
    lighthouse.context.drone.param["locSrv.enLhMtchStm"] = 0
    lighthouse.context.drone.param["locSrv.maxTimeLhMtchStm"] = 25
