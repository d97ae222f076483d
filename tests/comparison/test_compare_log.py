"""Logs of every format beside the simulation: what was simulated comes back, and what is no log is a sentence."""

import gzip
import json
import os
from pathlib import Path

import numpy as np
import pytest
import yaml
from typer.testing import CliRunner

from crazychoir_fw.cli import app
from crazychoir_fw.common.errors import CrazychoirError
from crazychoir_fw.comparison.column_map import PRESETS, load_map
from crazychoir_fw.comparison.log_flight import load_flight
from crazychoir_fw.comparison.side_by_side import compare_flight
from crazychoir_fw.mission.loader import load_mission

FLIGHTS = Path(os.environ.get("CRAZYCHOIR_FLIGHTS", "/nowhere"))
ESTIMATE_ONLY = ("csv", "usd")  # no truth in these


@pytest.mark.parametrize("kind", ["csv", "npz", "usd", "mcap", "rosbag2"])
def test_a_simulated_flight_comes_back_from_every_format(kind, file_of, mission_file):
    flight = load_flight(file_of(kind))
    found = compare_flight(flight, load_mission(mission_file), tunes=False, inner=False)
    chain = found.chain
    assert found.commands == "log"
    assert chain.path_rms_m < (0.012 if kind in ESTIMATE_ONLY else 0.006)
    assert abs(chain.lag_s) < 0.015
    assert abs(chain.tracking_percent) < 5.0
    assert abs(chain.thrust_percent) < 0.5
    assert abs(chain.voltage_difference_v) < 0.02
    assert ("no true position" in " ".join(flight.notes)) == (kind in ESTIMATE_ONLY)


def test_another_vehicle_is_seen(file_of, mission_file):
    """The closure is no accident: 10 % of mass more, and thrust and voltage differ."""
    mission = load_mission(mission_file, changes=["drones[0].mass=0.033"])
    chain = compare_flight(load_flight(file_of("npz")), mission, tunes=False, inner=False).chain
    assert chain.thrust_percent > 5.0


def test_controller_motors_and_plant_are_compared_too(file_of, mission_file):
    found = compare_flight(load_flight(file_of("npz")), load_mission(mission_file))
    assert found.figures["controller_roll_rms_deg"] < 0.3
    assert found.figures["motor_worst_mean_percent"] < 0.1
    assert found.figures["hover"]["thrust_scale"] == pytest.approx(1.0, abs=0.02)
    assert found.figures["plant_position_cm"][0] < 0.3


def test_a_log_without_setpoints_flies_the_mission(as_csv, mission_file):
    """The same mission with the same seed gives the same path: to the last bit of a float32."""
    from crazychoir_fw.flight.engine import fly

    mission = load_mission(mission_file)
    result = fly(mission, visuals=False)
    names = ("stateEstimate.x", "sim.x", "sim.y", "sim.z", "sim.roll", "sim.pitch", "sim.yaw", "pm.vbat")
    flown = {name: result.log.signals[name][:, 0].astype(float) for name in names}
    flight = load_flight(as_csv(flown, result.log))
    found = compare_flight(flight, mission)
    assert found.commands == "mission"
    assert found.chain.path_rms_m < 1e-3
    assert abs(found.chain.lag_s) < 0.011
    assert "controller_roll_rms_deg" not in found.figures


def test_own_columns_and_units(tmp_path, as_csv, columns):
    own = {
        **{f"vicon {axis} (mm)": 1000 * columns[f"stateEstimate.{axis}"] for axis in "xyz"},
        **{f"angle {name}": np.radians(columns[f"stateEstimate.{name}"]) for name in ("roll", "pitch", "yaw")},
        **{f"goal_{axis}": 100 * columns[f"ctrltarget.{axis}"] for axis in "xyz"},
        "battery": 1000 * columns["pm.vbat"],
    }
    path = as_csv(own, name="own.csv")
    table = tmp_path / "own.yaml"
    given = {
        "time": {"columns": ["timestamp"], "unit": "ms"},
        "position": {"columns": [f"vicon {axis} (mm)" for axis in "xyz"], "unit": "mm"},
        "attitude": {"columns": ["angle roll", "angle pitch", "angle yaw"], "unit": "rad"},
        "setpoint": {"columns": ["goal_x", "goal_y", "goal_z"], "unit": "cm"},
        "voltage": {"columns": ["battery"], "unit": "mV"},
    }
    table.write_text(yaml.safe_dump(given))
    flight, same = load_flight(path, table), load_flight(as_csv(columns))
    np.testing.assert_allclose(flight.position, same.position, atol=1e-6)
    np.testing.assert_allclose(np.abs(np.sum(flight.quat_xyzw * same.quat_xyzw, axis=1)), 1.0, atol=1e-9)
    np.testing.assert_allclose(flight.setpoint, same.setpoint, atol=1e-6)
    np.testing.assert_allclose(flight.voltage, same.voltage, atol=1e-6)


def test_streams_of_different_rates_meet_on_one_clock(as_csv, columns):
    """Log blocks of cflib at 100 and 10 Hz in one file: cells of the slow one are empty in between."""
    holes = columns["pm.vbat"].copy()
    holes[np.arange(len(holes)) % 100 != 0] = np.nan
    flight = load_flight(as_csv({**columns, "pm.vbat": holes}))
    assert flight.time[-1] > 11.0
    assert np.abs(flight.voltage - columns["pm.vbat"][: len(flight.voltage)]).max() < 0.2


def test_a_card_that_was_pulled_out_is_read_as_far_as_it_goes(tmp_path, file_of):
    whole = file_of("usd")
    cut = tmp_path / "cut"
    cut.write_bytes(whole.read_bytes()[: -len(whole.read_bytes()) // 3])
    flight = load_flight(cut)
    assert 6.0 < flight.time[-1] < 8.0
    assert "check sum" in " ".join(flight.notes) and "cut off" in " ".join(flight.notes)


def change(columns, **changed):
    return {**columns, **changed}


WRONG = {
    "no position": (
        lambda c: {name: c[name] for name in c if not name.startswith("stateEstimate.x")},
        r"f: no position by any known names; its columns are timestamp, stateEstimate\.y",
    ),
    "millimeters": (
        lambda c: change(c, **{"stateEstimate.x": 1e5 + c["stateEstimate.x"]}),
        r"unusable from its start: stateEstimate\.x leaves -30 to 30",
    ),
    "nothing but NaN": (
        lambda c: change(c, **{"stateEstimate.z": np.full(len(c["pm.vbat"]), np.nan)}),
        r"column stateEstimate\.z holds no numbers",
    ),
    "seconds that are called milliseconds": (lambda c: c, r"a flight has 2 s; is the unit of timestamp right\?"),
}


@pytest.mark.parametrize("what", WRONG)
def test_columns_that_make_no_sense_are_one_sentence(what, as_csv, columns):
    wrong, sentence = WRONG[what]
    path = as_csv(wrong(columns))
    if "seconds" in what:
        lines = path.read_text().splitlines()
        table = [line.split(",", 1) for line in lines[1:]]
        path.write_text("\n".join([lines[0], *(f"{int(time) / 1000},{rest}" for time, rest in table)]))
    with pytest.raises(CrazychoirError, match=sentence) as told:
        load_flight(path)
    assert "\n" not in str(told.value)


@pytest.mark.parametrize(
    ("name", "content", "sentence"),
    [
        ("f.csv", b"", "names no columns"),
        ("f.csv", b"1,2\n3,4\n", "names no columns"),
        ("f.csv", b"time,x\n", "no rows"),
        ("f.csv.gz", gzip.compress(b"time,x\n1,2\n", mtime=0)[:-9], "cannot be read"),
        ("f.npz", b"PK\x03\x04 no archive", "is no NumPy archive"),
        ("f.mcap", b"\x89MCAP0\r\n damaged", "cannot be read"),
        ("log00", b"\xbc\x09\x00\x01\x00", "is of version 9, allowed: 1, 2"),
        ("log00", b"\xbc\x02\x00\x01\x00ab", "its header is damaged"),
        ("f.xlsx", b"PK", "format not known, allowed: CSV"),
    ],
)
def test_files_that_are_no_logs_are_one_sentence(tmp_path, name, content, sentence):
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.raises(CrazychoirError, match=sentence) as told:
        load_flight(path)
    assert name in str(told.value) and "\n" not in str(told.value)


def test_a_truncated_mcap_is_read_as_far_as_it_goes(tmp_path, file_of):
    data = file_of("mcap").read_bytes()
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(data[: len(data) // 2])
    try:
        flight = load_flight(cut)
    except CrazychoirError as error:
        assert "cut.mcap" in str(error) and "\n" not in str(error)
    else:
        assert "unreadable" in " ".join(flight.notes)


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        ("positon: [x, y, z]", "positon is no quantity, allowed: time, position"),
        ("position: {columns: [x, y]}", r"position\.columns must be 3 names"),
        ("position: {columns: [x, y, z], unit: inch}", r"position\.unit is 'inch', allowed: m, cm, mm"),
        ("position: {columns: [x, y, z], scale: 2}", r"position\.scale is not known"),
        ("extends: vicon", "extends is 'vicon', allowed: crazyflie, nanobench, ros"),
        ("- 1", "must be a mapping"),
    ],
)
def test_maps_that_make_no_sense_are_one_sentence(tmp_path, given, sentence):
    path = tmp_path / "map.yaml"
    path.write_text(given)
    with pytest.raises(CrazychoirError, match=sentence):
        load_map(path)


def test_presets_are_read():
    assert PRESETS == ("crazyflie", "nanobench", "ros")
    for name in PRESETS:
        assert {"time", "position", "attitude", "setpoint"} <= set(load_map(name))


def test_the_command_writes_table_picture_and_page(file_of, mission_file, tmp_path):
    out = tmp_path / "out"
    words = ["compare", str(file_of("npz")), "--mission", str(mission_file), "--out", str(out), "--no-tune"]
    result = CliRunner().invoke(app, words)
    assert result.exit_code == 0, result.output
    assert "distance to the setpoint" in result.output
    summary = json.loads((out / "summary.json").read_text())
    assert summary["figures"]["path_rms_m"] < 0.006
    assert "data:image/png;base64," in (out / "report.html").read_text()
    assert (out / "comparison.png").stat().st_size > 10_000


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["--drone", "cf9"], "--drone is 'cf9', but"),
        (["--commands", "joystick"], "--commands is 'joystick', allowed: log, mission"),
        (["--columns", "vicon"], "--columns is 'vicon', allowed: a YAML file or crazyflie"),
    ],
)
def test_wrong_options_are_one_sentence(words, sentence, mission_file, tmp_path):
    (tmp_path / "f.csv").write_text("time,x\n1,2\n")
    result = CliRunner().invoke(app, ["compare", str(tmp_path / "f.csv"), "--mission", str(mission_file), *words])
    assert result.exit_code == 2 and sentence in result.output


@pytest.mark.skipif(not FLIGHTS.is_dir(), reason="no folder with recorded flights (CRAZYCHOIR_FLIGHTS)")
@pytest.mark.parametrize("name", ["B2_circle_slow_rep1", "B9_trefoil_slow_mellinger_rep1"])
def test_real_flights(name, tmp_path):
    mission = tmp_path / "real.yaml"
    controller = "mellinger" if "mellinger" in name else "pid"
    text = {
        "drones": [{"id": "cf1", "position": [0.0, 0.0], "vehicle": "nanobench", "controller": controller}],
        "defaults": {"positioning": "mocap_position"},
        "flight": [{"takeoff": {"height": 1.0, "duration": 2.0}}, {"land": {"duration": 2.0}}],
    }
    mission.write_text(yaml.safe_dump(text))
    flight = load_flight(FLIGHTS / f"{name}.csv.gz")
    found = compare_flight(flight, load_mission(mission), inner=False)
    assert found.chain.path_rms_m < 0.08
    assert abs(found.chain.tracking_percent) < 12.0
