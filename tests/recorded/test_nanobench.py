"""Reading recorded flights: the known defects, and files that are none."""

import csv
import gzip
import os

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crazychoir_fw.common.errors import CrazychoirError, RangeError, UnknownNameError
from crazychoir_fw.comparison.nanobench import flight_files, interpolated_rows, read_flight
from crazychoir_fw.comparison.phases import find_phases


def table(path):
    with gzip.open(path, "rt", newline="") as file:
        return list(csv.DictReader(file))


def write(path, rows):
    with path.open("w", newline="") as file:
        writer = csv.DictWriter(file, rows[0].keys())
        writer.writeheader()
        writer.writerows(rows)
    return path


@pytest.fixture
def rows(synthetic_path):
    return table(synthetic_path)[:600]


def test_regular_clock_from_zero(synthetic):
    flight, _ = synthetic
    assert flight.time[0] == 0.0
    assert np.diff(flight.time) == pytest.approx(0.01)
    assert flight.controller == "pid"
    assert flight.notes == ()


def test_columns_that_run_away_end_the_flight(rows, tmp_path):
    for row in rows[400:]:
        row["motor_motor_m2"] = "70000"
    flight = read_flight(write(tmp_path / "a.csv", rows))
    assert flight.time[-1] == pytest.approx(3.9, abs=0.02)
    assert any("unusable from 4.00 s" in note for note in flight.notes)


def test_zero_desired_attitude_is_another_controller(rows, tmp_path):
    for row in rows:
        row |= {f"pid_controller_{name}": "0" for name in ("roll", "pitch", "cmd_thrust")}
    assert read_flight(write(tmp_path / "a.csv", rows)).controller == "mellinger"


def test_short_holes_are_bridged_and_long_ones_end_the_flight(rows, tmp_path):
    for row in rows[100:105]:
        row["px"] = ""
    for row in rows[450:520]:
        row["pz"] = "nan"
    flight = read_flight(write(tmp_path / "a.csv", rows))
    assert flight.time[-1] < 4.5
    assert np.isfinite(flight.position).all()
    assert any("empty cells of px" in note for note in flight.notes)


def test_time_that_stands_still(rows, tmp_path):
    rows[200]["t"] = rows[199]["t"]
    flight = read_flight(write(tmp_path / "a.csv", rows))
    assert any("1 rows without an ascending time" in note for note in flight.notes)


def test_absent_group_is_none(rows, tmp_path):
    thin = [{name: value for name, value in row.items() if not name.startswith("imu_gyro")} for row in rows]
    flight = read_flight(write(tmp_path / "a.csv", thin))
    assert flight.gyro is None
    assert flight.missing("gyro", "motors") == "a: gyro not recorded"


def test_quaternions_do_not_flip(rows, tmp_path):
    for row in rows[300:]:
        row |= {name: str(-float(row[name])) for name in ("qx", "qy", "qz", "qw")}
    flight = read_flight(write(tmp_path / "a.csv", rows))
    assert np.all(np.sum(flight.quat_xyzw[1:] * flight.quat_xyzw[:-1], axis=1) > 0.9)


def test_absent_truth_is_named(rows, tmp_path):
    thin = [{name: value for name, value in row.items() if name != "qw"} for row in rows]
    with pytest.raises(RangeError, match="columns qw are missing"):
        read_flight(write(tmp_path / "a.csv", thin))


def test_drone_that_stays_on_the_floor(rows, tmp_path):
    flight = read_flight(
        write(tmp_path / "a.csv", [{**row, "pz": "0.02", "est_stateEstimate_z": "0.02"} for row in rows])
    )
    with pytest.raises(RangeError, match="never leaves the floor"):
        find_phases(flight)


def test_folders(tmp_path, synthetic_path):
    with pytest.raises(UnknownNameError, match="no flights"):
        flight_files(tmp_path)
    with pytest.raises(UnknownNameError, match="no folder"):
        flight_files(tmp_path / "absent")
    with pytest.raises(UnknownNameError, match="there are: synthetic"):
        flight_files(synthetic_path.parent, ["other"])


def test_interpolated_rows_are_found():
    values = np.cumsum(np.random.default_rng(1).normal(size=100))
    values[40:46] = np.linspace(values[40], values[45], 6)
    found = interpolated_rows(values[:, None])
    assert found[41:45].all()
    assert found.sum() == 4


@given(st.binary(max_size=400))
def test_any_bytes_are_refused_with_a_sentence(tmp_path_factory, content):
    path = tmp_path_factory.mktemp("fuzz") / "a.csv"
    path.write_bytes(content)
    with pytest.raises(CrazychoirError):
        read_flight(path)


@settings(max_examples=40)
@given(st.data())
def test_damaged_cells_end_in_a_flight_or_a_sentence(tmp_path_factory, synthetic_path, data):
    rows = table(synthetic_path)[100:450:3]
    names = list(rows[0])
    for _ in range(data.draw(st.integers(1, 8))):
        row = data.draw(st.integers(0, len(rows) - 1))
        rows[row][data.draw(st.sampled_from(names))] = data.draw(
            st.sampled_from(["", "inf", "-1e300", "x", "NaN", "1e9"])
        )
    path = write(tmp_path_factory.mktemp("fuzz") / "a.csv", rows)
    try:
        flight = read_flight(path)
    except CrazychoirError:
        return
    assert np.isfinite(flight.position).all()
    assert np.isfinite(flight.time).all()


@pytest.mark.skipif("CRAZYCHOIR_FLIGHTS" not in os.environ, reason="no folder with recorded flights")
def test_recorded_flights_can_be_read():
    for path in flight_files(os.environ["CRAZYCHOIR_FLIGHTS"]):
        flight = read_flight(path)
        assert find_phases(flight).end <= flight.time[-1] + 0.01
