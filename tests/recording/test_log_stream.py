"""A log on its way to the disk: what is written while it flies is the log that is made at the end."""

import errno
import os

import numpy as np
import pytest

from crazychoir_fw.common.errors import StateError
from crazychoir_fw.recording.flight_log import FlightLog
from crazychoir_fw.recording.log_stream import LogStream, StreamFile
from crazychoir_fw.simulation import DroneConfig, FlightRecorder, World, replay
from crazychoir_fw.simulation.replay import load_flight


def assert_same(one: FlightLog, other: FlightLog) -> None:
    assert one.time.tobytes() == other.time.tobytes()
    assert one.drone_ids == other.drone_ids
    assert list(one.signals) == list(other.signals)
    for name, samples in one.signals.items():
        assert samples.dtype == other.signals[name].dtype
        assert samples.tobytes() == other.signals[name].tobytes()
    mine, theirs = one.journal.to_arrays(), other.journal.to_arrays()
    assert {name: values.tobytes() for name, values in mine.items()} == {
        name: values.tobytes() for name, values in theirs.items()
    }


def fly(recorder: FlightRecorder, seconds: float, setpoint: float) -> None:
    """Fly some time with requests of several kinds."""
    for drone in recorder._world.drones:
        if drone.can_arm:
            drone.arm()
        drone.commander.send_hover_setpoint(0.0, 0.0, 0.0, setpoint)
    recorder.run(seconds)


@pytest.fixture
def world():
    world = World([DroneConfig(id=f"d{i}", position=(i, 0.0, 0.0)) for i in range(2)], seed=3)
    world.wait_until_ready()
    return world


@pytest.fixture
def flown(world, tmp_path):
    """A recorder without a stream and one with it, of the same flight, and the stream."""
    stream = LogStream(tmp_path / "log.stream")
    plain, streamed = FlightRecorder(world), FlightRecorder(world)
    streamed.write_to(stream, {"mission": "m"})
    journal = None
    for k in range(4):
        for drone in world.drones:
            if drone.can_arm:
                drone.arm()
            drone.commander.send_hover_setpoint(0.0, 0.0, 0.0, 0.1 * k)
        for _ in range(5):
            world.step(10)
            plain.sample({"layers.x": np.array([k, 2.0])})
            streamed.sample({"layers.x": np.array([k, 2.0])})
        if k == 2:
            journal = world.journal.copy()
            streamed.flush()
    yield plain, streamed, stream, journal
    stream.close()


def test_a_log_through_the_disk_is_that_through_memory_bit_by_bit(flown):
    plain, streamed, _, before = flown
    through_disk = streamed.finish()
    assert len(before) > 0 and streamed._world.journal.forgotten == len(before)
    journal = before.copy()
    journal.extend(streamed._world.journal)
    through_memory = plain.finish()
    journal.samples = through_memory.journal.samples
    through_memory.journal = journal
    assert_same(through_memory, through_disk)
    assert through_disk.journal.gap is None


def test_a_flight_that_is_cut_reads_back_to_its_last_flush_and_replays(flown, tmp_path):
    _, streamed, _, _ = flown
    log = load_flight(tmp_path)
    assert len(log.time) == 15 and "cut off" in log.metadata["cut"] and log.metadata["mission"] == "m"
    whole = streamed.finish()
    for name, samples in log.signals.items():
        assert samples.tobytes() == whole.signals[name][:15].tobytes()
    said: list[str] = []
    assert replay(log, warn=said.append).deviation is None
    assert any("was cut off at" in sentence for sentence in said)


def test_a_torn_frame_is_dropped_wherever_it_is_torn(flown, tmp_path):
    _, streamed, stream, _ = flown
    streamed.flush()
    data, rows = stream.path.read_bytes(), StreamFile(stream.path).of(b"R", 0)
    assert len(rows) == 2
    rng = np.random.default_rng(1)
    for end in (*rng.integers(rows[0].offset + rows[0].size, len(data) - 1, 12), len(data) - 1):
        (tmp_path / "cut.stream").write_bytes(data[:end])
        log = FlightLog.load(tmp_path / "cut.stream")
        assert len(log.time) == 15 and log.journal.samples[-1] <= len(log.journal)
    flipped = bytearray(data)
    flipped[rows[1].offset + 7] ^= 4
    (tmp_path / "cut.stream").write_bytes(flipped)
    log = FlightLog.load(tmp_path / "cut.stream")
    assert len(log.time) == 15 and log.metadata["cut"].endswith("its last record was torn and is dropped")


def test_memory_does_not_grow_with_a_streamed_flight(world, tmp_path):
    stream = LogStream(tmp_path / "log.stream")
    recorder = FlightRecorder(world)
    recorder.write_to(stream, {})
    for _ in range(50):
        fly(recorder, 0.05, 0.2)
        recorder.flush()
        assert len(world.journal) - world.journal.forgotten == 0
        assert all(len(block) == 0 for block in recorder._samples._blocks.values())
    assert len(recorder.times) == 250
    stream.close()


@pytest.mark.parametrize("fails_at", range(0, 40, 2))
def test_a_disk_that_is_full_costs_no_sample(world, tmp_path, monkeypatch, fails_at):
    """The disk takes so many writes; what it does not take stays in memory, and what it took is read back."""
    calls, write = 0, os.pwrite

    def full(file, data, offset):
        nonlocal calls
        calls += 1
        if calls == fails_at:
            return write(file, data[: len(data) // 2], offset)
        if calls > fails_at:
            raise OSError(errno.ENOSPC, "No space left on device")
        return write(file, data, offset)

    stream = LogStream(tmp_path / "log.stream")
    monkeypatch.setattr(os, "pwrite", full)
    plain, streamed = FlightRecorder(world), FlightRecorder(world)
    streamed.write_to(stream, {})
    for k in range(3):
        world.drones[0].commander.send_hover_setpoint(0.0, 0.0, 0.0, 0.1 * k)
        world.step(10)
        plain.sample()
        streamed.sample()
        streamed.flush()
    mine, theirs = plain.finish(), streamed.finish()
    theirs_journal = theirs.journal
    assert len(theirs_journal) == theirs_journal.samples[-1] == mine.journal.samples[-1]
    mine.journal = theirs_journal
    assert_same(mine, theirs)
    assert (stream.failure is not None) == (calls > fails_at)
    if stream.failure is not None:
        assert stream.failure.endswith("log.stream cannot be written: No space left on device")
    stream.close()


def test_two_flights_do_not_write_into_one_stream(tmp_path):
    stream = LogStream(tmp_path / "log.stream")
    with pytest.raises(StateError, match="is being written by another flight"):
        LogStream(tmp_path / "log.stream")
    stream.close(remove=True)
    assert not list(tmp_path.iterdir())


def test_a_journal_that_forgot_requests_says_so_in_its_copies(world, tmp_path):
    stream = LogStream(tmp_path / "log.stream")
    recorder = FlightRecorder(world)
    recorder.write_to(stream, {})
    fly(recorder, 0.02, 0.1)
    recorder.flush()
    assert "stream" in world.snapshot().journal.gap
    assert recorder.finish().journal.gap is None
    stream.close()


def test_rows_are_flushed_when_they_take_much_memory(world, tmp_path, monkeypatch):
    monkeypatch.setattr("crazychoir_fw.simulation.recorder._FLUSH_BYTES", 25_000)
    stream = LogStream(tmp_path / "log.stream")
    recorder = FlightRecorder(world)
    recorder.write_to(stream, {})
    recorder.run(0.2)
    assert len(StreamFile(stream.path).of(b"R", 0)) > 1
    assert recorder._samples.bytes_in_memory <= 25_000
    stream.close()
