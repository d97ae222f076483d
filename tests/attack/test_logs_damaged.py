"""Damaged and altered logs: what reads them refuses them with one sentence that names the file, or reads them.

A part of some dozens runs with the tests; `ATTACK_LOGS=10000` tries so many.
"""

import io
import json
import os
import warnings
import zipfile
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from crazychoir_fw.common.errors import CrazychoirError
from crazychoir_fw.recording.flight_log import FlightLog
from crazychoir_fw.recording.log_stream import LogStream
from crazychoir_fw.simulation import DroneConfig, FlightRecorder, World
from crazychoir_fw.simulation.replay import build, check_before, load_flight

Random = np.random.Generator
COUNT = int(os.environ.get("ATTACK_LOGS", "60"))


def record(folder: Path) -> None:
    """Write log.npz and log.stream of a short flight."""
    world = World([DroneConfig(id="a"), DroneConfig(id="b", position=(1.0, 0.0, 0.0))], seed=1)
    recorder, stream = FlightRecorder(world, rate_hz=50), LogStream(folder / "log.stream")
    for _ in range(3):
        world.drones[0].commander.send_hover_setpoint(0.0, 0.0, 0.0, 0.3)
        recorder.run(0.1)
        world.note("mark", "a")
    recorder.finish({"mission": "m"}).save(folder / "log.npz")
    recorder.write_to(stream, {"mission": "m"})
    recorder.flush()
    stream.close()


def flipped(data: bytes, random: Random) -> bytes:
    mutant = bytearray(data)
    for at in random.integers(0, len(data), random.integers(1, 9)):
        mutant[at] ^= 1 << int(random.integers(8))
    return bytes(mutant)


def cut(data: bytes, random: Random) -> bytes:
    return data[: random.integers(len(data))]


def overwritten(data: bytes, random: Random) -> bytes:
    begin, size = int(random.integers(len(data))), int(random.integers(1, 200))
    return data[:begin] + random.bytes(size) + data[begin + size :]


def moved(data: bytes, random: Random) -> bytes:
    a, b = sorted(random.integers(0, len(data), 2))
    return data[:a] + data[b:] + data[a:b]


_ODD: list[Any] = [None, -1, 2**70, 1e308, float("nan"), "", "x" * 300, [], {}, [[]], True, {"a": []}, "../../x"]


def altered_json(value: Any, random: Random) -> Any:
    """Return plain data with one value changed, somewhere in it."""
    if random.random() < 0.15 or not isinstance(value, dict | list) or not value:
        return _ODD[random.integers(len(_ODD))]
    chosen: Any = dict(value) if isinstance(value, dict) else list(value)
    keys = list(value) if isinstance(value, dict) else range(len(value))
    key = keys[int(random.integers(len(keys)))]
    if random.random() < 0.1:
        del chosen[key]
    else:
        chosen[key] = altered_json(value[key], random)
    return chosen


def altered(data: bytes, random: Random) -> bytes:
    """Return a log with a member of another shape, type or value; a sound file around wrong content."""
    with np.load(io.BytesIO(data)) as file:
        members = {name: file[name] for name in file.files}
    names = ["about", "ticks", "drones", "kinds", "numbers", "blob", "samples"]
    chosen = ["time", "drone_ids", "metadata", "events", *(f"journal/{name}" for name in names)]
    signal = next(name for name in members if name.startswith("signal/"))
    name = [*chosen, signal, "journal/about", "journal/about"][random.integers(len(chosen) + 3)]
    values = members[name]
    if values.dtype.kind == "U" and values.ndim == 0:
        members[name] = np.array(json.dumps(altered_json(json.loads(str(values)), random)))
    else:
        odd = [values[:-1], values[::-1], values.astype("U8"), values.reshape(-1)[:0], np.array(1), values[None]]
        members[name] = odd[random.integers(len(odd))]
        if values.dtype.kind in "if" and random.random() < 0.5:
            members[name] = values.copy()
            members[name].flat[random.integers(values.size)] = [2**31 - 1, -1, 7, 255][random.integers(4)]
    if random.random() < 0.1:
        del members[name]
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **members)
    return buffer.getvalue()


def mutants(folder: Path, count: int) -> Iterator[tuple[str, bytes]]:
    """Return names and content of damaged files."""
    random = np.random.default_rng(22)
    sources = {name: (folder / name).read_bytes() for name in ("log.npz", "log.stream")}
    kinds: list[Callable[[bytes, Random], bytes]] = [flipped, cut, overwritten, moved, altered]
    for k in range(count):
        kind = kinds[k % len(kinds)]
        name = "log.npz" if kind is altered or k // len(kinds) % 2 else "log.stream"
        yield f"mutant.{name.partition('.')[2]}", kind(sources[name], random)


def outcome(path: Path) -> str:
    """Read a log as replay does, up to the flight. Returns how it ended."""
    try:
        log = load_flight(path)
    except CrazychoirError as error:
        assert str(path) in str(error), error
        assert "\n" not in str(error) and "Traceback" not in str(error), error
        return "refused"
    assert isinstance(log, FlightLog)
    try:
        check_before(log)
        build(log.journal)
    except CrazychoirError as error:
        assert "\n" not in str(error), error
        return "not to be flown again"
    return "read"


def attack(folder: Path, count: int) -> Counter[str]:
    """Read so many damaged logs. Returns how often it ended how."""
    record(folder)
    ends: Counter[str] = Counter()
    for name, content in mutants(folder, count):
        path = folder / name
        path.write_bytes(content)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            try:
                ends[outcome(path)] += 1
            except Exception:
                (folder / f"found.{name}").write_bytes(content)
                raise
    return ends


@pytest.mark.timeout(120 + COUNT)
def test_damaged_logs_are_refused_in_a_sentence_or_read(tmp_path):
    ends = attack(tmp_path, COUNT)
    print(f"{COUNT} damaged logs: {dict(ends)}")
    assert ends["refused"] > COUNT // 6 and ends["read"] > 0


def test_a_bomb_is_not_unpacked(tmp_path):
    """Zeros that would take more than the memory of any machine, in a file of some kilobytes: a header that lies."""
    path = tmp_path / "bomb.npz"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("time.npy", b"\x93NUMPY\x01\x00")
    data = bytearray(path.read_bytes())
    at = data.index(b"PK\x01\x02") + 24  # size of the member once unpacked, in the central directory
    data[at : at + 4] = (2**32 - 2).to_bytes(4, "little")
    path.write_bytes(data)
    many = tmp_path / "many.npz"
    with zipfile.ZipFile(many, "w") as archive:
        for k in range(20_001):
            archive.writestr(f"{k}.npy", b"")
    with pytest.raises(ValueError, match="20001 members, allowed"):
        FlightLog.load(many)
    with pytest.raises(ValueError, match=r"bomb\.npz is not a flight log"):
        FlightLog.load(path)


def test_a_log_larger_than_the_memory_is_refused(tmp_path, monkeypatch):
    record(tmp_path)
    monkeypatch.setattr("os.sysconf", lambda name: 100)
    with pytest.raises(ValueError, match="of memory, allowed: 0.0 GB"):
        FlightLog.load(tmp_path / "log.npz")
