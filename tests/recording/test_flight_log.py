import pickle
import zipfile

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from crazychoir_fw.recording.flight_log import FlightLog
from crazychoir_fw.recording.journal import Journal


def assert_equal(one: FlightLog, other: FlightLog) -> None:
    np.testing.assert_array_equal(one.time, other.time)
    assert one.drone_ids == other.drone_ids
    assert one.metadata == other.metadata
    assert list(one.signals) == list(other.signals)
    for name, samples in one.signals.items():
        np.testing.assert_array_equal(samples, other.signals[name])
        assert samples.dtype == other.signals[name].dtype


def test_a_saved_log_reads_back_the_same(tmp_path, make_log):
    log = make_log(3)
    log.save(tmp_path / "new" / "flight.npz")
    assert_equal(FlightLog.load(tmp_path / "new" / "flight.npz"), log)


@settings(deadline=None)
@given(
    samples=arrays.arrays(
        st.sampled_from([np.float32, np.float64, np.uint8, np.int16, np.uint16]),
        st.tuples(st.integers(0, 5), st.integers(0, 4)),
    ),
    name=st.from_regex(r"[A-Za-z][A-Za-z0-9_]{0,10}\.[a-z][A-Za-z0-9]{0,10}", fullmatch=True),
    metadata=st.dictionaries(st.text(), st.one_of(st.none(), st.booleans(), st.integers(), st.text())),
    drone=st.text(st.characters(exclude_characters="\0", exclude_categories=["Cs"]), max_size=8),
)
def test_any_log_reads_back_the_same(tmp_path_factory, samples, name, metadata, drone):
    time = np.arange(samples.shape[0], dtype=float)
    log = FlightLog(time, [f"{drone}{k}" for k in range(samples.shape[1])], {name: samples}, metadata)
    path = tmp_path_factory.getbasetemp() / "any.npz"
    log.save(path)
    assert_equal(FlightLog.load(path), log)


def test_the_file_holds_no_pickle(tmp_path, make_log):
    make_log(2).save(tmp_path / "flight.npz")
    with np.load(tmp_path / "flight.npz", allow_pickle=False) as file:
        assert all(file[name].dtype.kind in "iufU" for name in file.files)


def test_nothing_in_a_file_is_executed(tmp_path):
    class Trap:
        def __reduce__(self):
            return (tmp_path.joinpath("sprung").touch, ())

    path = tmp_path / "trap.npz"
    time, ids, metadata = np.zeros(1), np.array(["cf0"]), np.array("{}")
    trap = np.array([[Trap()]], dtype=object)
    np.savez(path, time=time, drone_ids=ids, metadata=metadata, **{"signal/a.b": trap})
    with pytest.raises(ValueError, match="not a flight log"):
        FlightLog.load(path)
    assert not (tmp_path / "sprung").exists()


@pytest.mark.parametrize("content", [b"", b"hello", b"PK\x03\x04broken", b"PK\x05\x06" + bytes(18), pickle.dumps({})])
def test_a_file_that_is_no_log_is_refused(tmp_path, content):
    (tmp_path / "x.npz").write_bytes(content)
    with pytest.raises(ValueError, match=r"x\.npz is not a flight log") as refused:
        FlightLog.load(tmp_path / "x.npz")
    assert "pickle" not in str(refused.value)  # NumPy would advise to load it unsafely


def test_a_cut_off_file_is_refused(tmp_path, make_log):
    make_log(3).save(tmp_path / "x.npz")
    content = (tmp_path / "x.npz").read_bytes()
    (tmp_path / "x.npz").write_bytes(content[: len(content) // 2])
    with pytest.raises(ValueError, match="not a flight log"):
        FlightLog.load(tmp_path / "x.npz")


def test_a_damaged_member_is_refused(tmp_path, make_log):
    make_log(1).save(tmp_path / "x.npz")
    with zipfile.ZipFile(tmp_path / "x.npz", "a") as file:
        file.writestr("signal/bad.one.npy", b"\x93NUMPY\x01\x00garbage")
    with pytest.raises(ValueError, match="not a flight log"):
        FlightLog.load(tmp_path / "x.npz")


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"none\.npz"):
        FlightLog.load(tmp_path / "none.npz")


def test_a_failed_save_leaves_the_old_file(tmp_path, make_log):
    path = tmp_path / "flight.npz"
    make_log(1).save(path)
    before = path.read_bytes()
    log = make_log(2)
    log.metadata["mission"] = object()
    with pytest.raises(TypeError):
        log.save(path)
    assert path.read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["flight.npz"]


@pytest.mark.parametrize(
    ("time", "samples", "message"),
    [
        (np.zeros((2, 2)), np.zeros((2, 1)), r"time has shape \(2, 2\)"),
        ([0.0, -1.0], np.zeros((2, 1)), "must not decrease"),
        ([0.0, np.nan], np.zeros((2, 1)), "must not decrease"),
        ([0.0, 1.0], np.zeros(2), r"a\.b has shape \(2,\), expected \(T, N\) = \(2, 1\)"),
        ([0.0, 1.0], np.zeros((1, 2)), "expected"),
        ([0.0, 1.0], np.array([["x"], ["y"]]), "expected numbers"),
        ([0.0, 1.0], np.array([[None], [1]]), "expected numbers"),
    ],
)
def test_shapes_that_do_not_fit_are_refused(time, samples, message):
    with pytest.raises(ValueError, match=message):
        FlightLog(time, ["cf0"], {"a.b": samples})


def test_signals_stand_side_by_side(make_log):
    log = make_log(4, samples=7)
    stacked = log.stack("motor.m1", "motor.m2", "motor.m3")
    assert stacked.shape == (7, 4, 3)
    np.testing.assert_array_equal(stacked[0, 0], [31000, 32000, 33000])
    assert log.stack("motor.m1", "pm.vbat") is None


def test_a_log_says_what_it_holds(make_log):
    assert repr(make_log(4)) == "FlightLog(4 drones, 10 s, 10 signals)"


def test_events_and_journal_come_back(tmp_path, make_log):
    log = make_log(2, samples=3)
    log.events = [{"time": 0.5, "kind": "collision", "drone": "cf0", "details": {"with": "floor"}}]
    log.journal = Journal({"seed": 1})
    log.journal.add(120, 1, "param", ("pid_rate.roll_kp", 200.0))
    log.journal.samples = [0, 0, 1]
    log.save(tmp_path / "log.npz")
    loaded = FlightLog.load(tmp_path / "log.npz")
    assert loaded.events == log.events
    assert list(loaded.journal) == [(120, 1, "param", ("pid_rate.roll_kp", 200.0))]
    assert loaded.journal.recipe == {"seed": 1}
    assert loaded.journal.samples == [0, 0, 1]


def test_files_without_events_and_journal_still_load(tmp_path, make_log):
    """As version 0.1.0 wrote them."""
    log = make_log(2, samples=3)
    members = {f"signal/{name}": samples for name, samples in log.signals.items()}
    path = tmp_path / "old.npz"
    np.savez_compressed(path, time=log.time, drone_ids=np.array(log.drone_ids), metadata=np.array("{}"), **members)
    loaded = FlightLog.load(path)
    assert loaded.events == []
    assert loaded.journal is None
    assert loaded.signals.keys() == log.signals.keys()


def test_a_broken_journal_is_no_flight_log(tmp_path, make_log):
    log = make_log(1, samples=3)
    log.journal = Journal()
    log.save(tmp_path / "log.npz")
    with np.load(tmp_path / "log.npz") as file:
        members = {name: file[name] for name in file.files if name != "journal/ticks"}
    np.savez_compressed(tmp_path / "broken.npz", **members)
    with pytest.raises(ValueError, match="is not a flight log"):
        FlightLog.load(tmp_path / "broken.npz")
