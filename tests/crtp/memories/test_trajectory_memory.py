"""Trajectories that the real client uploads, and where the drone flies then."""

import struct

import numpy as np
import pytest
from cflib.crazyflie.mem import CompressedSegment, CompressedStart, MemoryElement, Poly4D
from memory_client import MemoryClient

from crazychoir_fw.simulation import DroneConfig, World
from crazychoir_fw.simulation.recorder import FlightRecorder
from crazychoir_fw.simulation.replay import replay


def connected(**chosen):
    world = World([DroneConfig("cf1", **chosen)], visuals=False)
    world.wait_until_ready()
    return MemoryClient(world, world["cf1"]).connect()


@pytest.fixture
def client():
    return connected()


def upload(client, elements, start_addr=0):
    """Return whether the upload of the client succeeded."""
    memory = client.memory(MemoryElement.TYPE_TRAJ)
    memory.trajectory = elements
    results = []
    memory.write_data(lambda *_: results.append(True), lambda *_: results.append(False), start_addr)
    client.read()
    (is_done,) = results
    return is_done


def content(client):
    """Return all bytes as the client reads them."""
    read = []
    client.mem.mem_read_cb.add_callback(lambda memory, address, data: read.append(bytes(data)))
    client.mem.read(client.memory(MemoryElement.TYPE_TRAJ), 0, 4096)
    client.read()
    (data,) = read
    return data


def poly(*coefficients):
    return Poly4D.Poly([*coefficients, *[0.0] * (8 - len(coefficients))])


def pieces(count):
    return [Poly4D(1.0 + i, x=poly(i, 0.5), y=poly(-i), z=poly(1.0), yaw=poly(0.1 * i)) for i in range(count)]


def test_31_pieces_fit_and_are_answered_while_the_simulation_stands_still(client):
    tick, sent = client.world.tick, len(client.link.sent)
    assert upload(client, pieces(31))
    assert len(client.link.sent) - sent == 171  # chunks
    assert client.world.tick == tick
    expected = b"".join(piece.pack() for piece in pieces(31))
    assert content(client)[: len(expected)] == expected
    client.carry_out()
    assert content(client)[: len(expected)] == expected
    assert bytes(client.drone.struct.onboard.high_level.memory)[: len(expected)] == expected


def test_32_pieces_do_not_fit(client):
    assert not upload(client, pieces(32))


def test_an_upload_may_end_with_the_memory(client):
    assert upload(client, pieces(1), start_addr=4096 - 132)
    assert not upload(client, pieces(1), start_addr=4096 - 131)


def test_captured_bytes_of_a_compressed_trajectory(client):
    start, segment = CompressedStart(0.0, 0.0, 1.0, 0.0), CompressedSegment(2.0, [], [1.0], [1.0, 2.0, 3.0], [0.1] * 7)
    assert upload(client, [start, segment])
    expected = "0000 0000 E803 0000 E4 D007 E803 E803 D007 B80B" + " 3900" * 7
    assert content(client).startswith(bytes.fromhex(expected))


def fly(client, seconds):
    """Return the position setpoint and the position of the drone (m), every 0.05 s."""
    told, path = [], []
    for _ in range(round(seconds * 20)):
        client.world.run(0.05)
        told.append([client.drone.log[f"ctrltarget.{axis}"] for axis in "xyz"])
        path.append(client.drone.true_position)
    return np.array(told), np.array(path)


def start(client, number, offset, count, type):
    client.carry_out()
    client.drone.arm()
    client.cf.high_level_commander.takeoff(1.0, 2.0)
    client.carry_out()
    fly(client, 3.0)
    client.cf.high_level_commander.define_trajectory(number, offset, count, type)
    client.cf.high_level_commander.start_trajectory(number, 1.0)
    client.carry_out()


def smooth(t):
    """From 0 to 1 at rest, as time goes from 0 to 1."""
    return np.polynomial.polynomial.polyval(np.clip(t, 0.0, 1.0), SMOOTH)


SMOOTH = [0.0, 0.0, 0.0, 0.0, 35.0, -84.0, 70.0, -20.0]
LAG = 0.35  # [m]: the position controller trails by half a second of at most 0.6 m/s


def test_an_uploaded_square_is_flown(client):
    side, duration = 0.8, 3.0
    corners = np.array([(0.0, 0.0), (side, 0.0), (side, side), (0.0, side), (0.0, 0.0)])
    square = []
    for corner, way in zip(corners, np.diff(corners, axis=0), strict=False):
        coefficients = np.outer(way, SMOOTH / duration ** np.arange(8))
        coefficients[:, 0] += corner
        x, y = (Poly4D.Poly(axis.tolist()) for axis in coefficients)
        square.append(Poly4D(duration, x=x, y=y, z=poly(1.0)))
    assert upload(client, square, start_addr=132)
    start(client, number=3, offset=132, count=4, type=0)

    told, path = fly(client, 4 * duration + 1.0)
    times = 0.05 * np.arange(1, len(told) + 1)
    wanted = corners[0] + sum(
        way * smooth((times - i * duration) / duration)[:, None] for i, way in enumerate(np.diff(corners, axis=0))
    )
    assert np.abs(told[:, :2] - wanted).max() < 0.02  # 10 ms on the way
    assert np.abs(path[:, :2] - wanted).max() < LAG
    assert path[-1] == pytest.approx([0.0, 0.0, 1.0], abs=0.1)
    assert client.drone.high_level_commander.is_trajectory_finished


def test_an_uploaded_compressed_trajectory_is_flown(client):
    line = [CompressedStart(0.0, 0.0, 1.0, 0.0), CompressedSegment(3.0, [0.0, 0.9, 0.9], [], [1.0, 1.4, 1.4], [])]
    assert upload(client, line)
    start(client, number=1, offset=0, count=1, type=1)

    told, path = fly(client, 4.5)
    s = np.clip(0.05 * np.arange(1, len(told) + 1) / 3.0, 0.0, 1.0)
    ease = 3.0 * s**2 - 2.0 * s**3  # the cubic with these control points
    wanted = np.stack([0.9 * ease, 0.0 * ease, 1.0 + 0.4 * ease], axis=1)
    assert np.abs(told - wanted).max() < 0.02
    assert np.abs(path - wanted).max() < LAG
    assert path[-1] == pytest.approx([0.9, 0.0, 1.4], abs=0.1)


def test_a_flight_by_memories_is_in_the_journal(client):
    """Uploads, geometry and lights reach the replayed drone as they reached the recorded one."""
    client = connected(positioning="lighthouse")
    recorder = FlightRecorder(client.world)
    assert upload(client, pieces(2))
    lighthouse = client.memory(MemoryElement.TYPE_LH)
    (_, geometry) = client.call(lighthouse.read_geo_data, 1)
    geometry.origin[0] += 0.02
    lighthouse.write_geo_data(1, geometry, None)
    ring = client.memory(MemoryElement.TYPE_DRIVER_LED)
    ring.leds[5].set(255, 255, 0)
    client.call(ring.write_data)
    client.mem.write(client.memory(MemoryElement.TYPE_MEMORY_TESTER), 0, b"\x07")
    client.read()
    ready = client.drone
    for _ in range(20):
        client.carry_out()
        client.world.run(0.02)
        recorder.sample()
    assert ready.log["memTst.errCntW"] == 1
    again = replay(recorder.finish({}))
    assert again.deviation is None
    twin = again.world["cf1"].struct.onboard
    mine = ready.struct.onboard
    assert bytes(twin.high_level.memory) == bytes(mine.high_level.memory)
    assert bytes(twin.lights.ring) == bytes(mine.lights.ring) != bytes(24)
    assert struct.pack("3f", *twin.estimator.stations.list[1].origin) == struct.pack("3f", *geometry.origin)
