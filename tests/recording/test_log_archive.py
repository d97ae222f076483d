"""The log of a long flight is made of its stream: the same log, in memory that does not grow with the flight."""

import json
import subprocess
import sys

import numpy as np
import pytest

from crazychoir_fw.recording.flight_log import FlightLog
from crazychoir_fw.recording.log_stream import LogStream
from crazychoir_fw.simulation import DroneConfig, FlightRecorder, World, replay

MADE_UP = """
import json, resource, sys
from pathlib import Path
import numpy as np
from crazychoir_fw.recording.journal import Journal
from crazychoir_fw.recording.log_archive import archive
from crazychoir_fw.recording.log_stream import LogStream
from crazychoir_fw.recording.record_output import RecordOutput
from crazychoir_fw.recording.samples import Samples

folder, seconds = Path(sys.argv[1]), int(sys.argv[2])
drones, names = 10, [f"made.up{k}" for k in range(100)]
fields = {"time": ((), float), "requests": ((), np.int64)}
fields |= {f"truth/{part}": ((drones, size), float) for part, size in (("position", 3), ("velocity", 3))}
fields |= {"truth/orientation": ((drones, 4), float), **{f"extra/{name}": ((drones,), np.float32) for name in names}}
samples, journal, stream = Samples(fields), Journal({}), LogStream(folder / "log.stream")
output = RecordOutput(stream, {})
output.begin({"poses": ["truth"], "extra": names}, samples, [f"d{i}" for i in range(drones)], {})
for second in range(seconds):
    for tick in range(0, 1000, 10):
        row = samples.add()
        for name, values in row.items():
            values[...] = 0.0
        row["truth/orientation"][:, 3] = 1.0
        row["time"][...] = second + tick / 1000
        for drone in range(drones):
            journal.add(1000 * second + tick, drone, "made_up", (0.5, 1.5, 2.5))
        row["requests"][...] = len(journal)
    output.write(samples, journal)
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
log = archive(stream.path, folder / "log.npz", {}, [])
after = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
size = stream.path.stat().st_size // 1024
print(json.dumps({"before": before, "after": after, "stream": size, "kept": len(log.time)}))
"""


@pytest.fixture(scope="module")
def flown(tmp_path_factory):
    folder = tmp_path_factory.mktemp("archive")
    world = World([DroneConfig(id="a"), DroneConfig(id="b", position=(1.0, 0.0), platform="cf21bl")], seed=3)
    recorder, stream = FlightRecorder(world), LogStream(folder / "log.stream")
    recorder.write_to(stream, {"mission": "m"})
    for k in range(30):
        for drone in world.drones:
            drone.commander.send_hover_setpoint(0.0, 0.0, 0.0, 0.01 * k)
        world.drones[0].param["pid_rate.roll_kp"] = 250.0 + k
        recorder.run(0.05)
        world.note("mark", "a", number=k)
        recorder.flush()
    thin = recorder.save(folder / "log.npz", {"server": {"sent": 3}})
    yield folder, recorder, thin
    stream.close()


def test_it_is_the_log_that_would_be_made_in_memory_bit_by_bit(flown):
    folder, recorder, _ = flown
    recorder.finish({"server": {"sent": 3}}).save(folder / "whole.npz")
    with np.load(folder / "whole.npz") as whole, np.load(folder / "log.npz") as streamed:
        assert set(streamed.files) == set(whole.files)
        for name in whole.files:
            assert streamed[name].dtype == whole[name].dtype, name
            assert streamed[name].tobytes() == whole[name].tobytes(), name


def test_it_loads_and_replays(flown):
    folder, _, thin = flown
    log = FlightLog.load(folder / "log.npz")
    assert replay(log).deviation is None
    assert log.events[-1]["details"] == {"number": 29}
    np.testing.assert_array_equal(thin.signals["sim.z"], log.signals["sim.z"])


def test_nothing_is_left_beside_it(flown):
    assert sorted(path.name for path in flown[0].iterdir() if path.name != "whole.npz") == ["log.npz", "log.stream"]


def test_without_a_stream_it_is_made_in_memory(tmp_path):
    world = World([DroneConfig(id="a")], seed=3)
    recorder = FlightRecorder(world)
    recorder.run(0.1)
    assert len(recorder.save(tmp_path / "log.npz").time) == 10
    assert FlightLog.load(tmp_path / "log.npz").drone_ids == ["a"]


def test_memory_does_not_grow_with_the_flight(tmp_path):
    peaks = {}
    for seconds in (100, 400):
        (tmp_path / str(seconds)).mkdir()
        command = [sys.executable, "-c", MADE_UP, str(tmp_path / str(seconds)), str(seconds)]
        peaks[seconds] = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    long = peaks[400]
    assert long["stream"] > 200_000  # [KiB]
    assert long["after"] - peaks[100]["after"] < 20_000
    assert long["after"] - long["before"] < 120_000
    assert 1000 < long["kept"] <= 3000
