"""Recorded inputs: complete, kept in a file, and true: a replay of them is the flight."""

import numpy as np
import pytest

from crazychoir_fw._core import lib
from crazychoir_fw.common.errors import CrazychoirError
from crazychoir_fw.parity.cases import CaseRequest
from crazychoir_fw.parity.cases.complementary import complementary_cases
from crazychoir_fw.parity.cases.controllers import controller_cases
from crazychoir_fw.parity.cases.kalman import kalman_cases, measurement_types
from crazychoir_fw.parity.inputs import Inputs, load
from crazychoir_fw.parity.side import Side
from crazychoir_fw.parity.structs import columns


def test_every_type_of_measurement_occurs(short_inputs):
    found = {int(kind) for flight in short_inputs.flights.values() for kind in np.unique(measurement_types(flight))}
    assert found == set(range(lib.MeasurementTypeTDOA, lib.MeasurementTypeBarometer + 1))


def test_every_kind_of_setpoint_occurs(whole_flight):
    mode = whole_flight.tracks["setpoint"]["mode"]
    kinds = set(zip(*(mode[axis].tolist() for axis in ("x", "y", "z", "roll", "yaw", "quat")), strict=True))
    # stop; position and plans; velocity; hover; height with attitude; altitude hold; attitude or rate with thrust;
    # full state
    assert {
        (0, 0, 0, 0, 0, 0),
        (1, 1, 1, 0, 1, 0),
        (2, 2, 2, 0, 2, 0),
        (2, 2, 1, 0, 2, 0),
        (0, 0, 1, 1, 2, 0),
        (0, 0, 2, 1, 2, 0),
        (0, 0, 0, 1, 2, 0),
        (0, 0, 0, 2, 2, 0),
        (1, 1, 1, 0, 0, 1),
    } <= kinds
    assert whole_flight.tracks["is_flying"].mean() > 0.8


@pytest.mark.parametrize("name", ["pid", "position", "sweeps", "beams", "twr_robust", "tdoa2", "planar", "flow"])
def test_replayed_filter_gives_the_estimates_of_the_flight(short_inputs, name):
    case = next(case for case in kalman_cases(short_inputs) if case.name == f"flight {name}")
    outcome = case.run(CaseRequest(Side()))
    flight = short_inputs.flights[name]
    if flight.has_loop:
        # the controllers see the estimate of the tick before
        recorded = columns(flight.tracks["estimate"][1:])
        for signal, values in recorded.items():
            assert np.array_equal(outcome.signals[f"estimate.{signal}"][:-1], values), signal
    # at first the filter may start again: its first prediction covers the whole boot, in free fall
    assert outcome.signals["is_within_bounds"][-500:].all()
    assert np.ptp(outcome.signals["estimate.position.x"]) > 0


@pytest.mark.parametrize("name", ["pid", "mellinger", "indi", "brescianini", "lee"])
def test_replayed_controller_gives_the_commands_of_the_flight(short_inputs, name):
    case = next(case for case in controller_cases(short_inputs) if case.name == f"{name}: flight {name}")
    outcome = case.run(CaseRequest(Side()))
    control = short_inputs.flights[name].tracks["control"]
    raw = np.ascontiguousarray(control["normalizedForces"])
    assert np.array_equal(outcome.signals["control.controlMode"], control["controlMode"])
    legacy = control["controlMode"] == lib.controlModeLegacy
    views = {
        "control.thrust": (legacy, raw[:, 2]),
        "control.roll": (legacy, raw.view(np.int16)[:, 0]),
        "control.thrustSi": (~legacy, raw[:, 0]),
        "control.torqueZ": (~legacy, raw[:, 3]),
    }
    for signal in views.keys() & outcome.signals.keys():
        mask, values = views[signal]
        assert np.array_equal(outcome.signals[signal][mask], values[mask]), signal


def test_replayed_complementary_estimator_gives_the_estimates_of_the_flight(short_inputs):
    case = next(case for case in complementary_cases(short_inputs) if case.name == "flight complementary")
    outcome = case.run(CaseRequest(Side()))
    for signal, values in columns(short_inputs.flights["complementary"].tracks["estimate"]).items():
        assert np.array_equal(outcome.signals[f"estimate.{signal}"], values), signal


def test_inputs_come_back_from_their_file(short_inputs, tmp_path):
    path = tmp_path / "flights.npz"
    short_inputs.save(path)
    again = load(path)
    assert again.digest == short_inputs.digest
    assert again.metadata == short_inputs.metadata
    assert again.flights["twr_robust"].parameters["kalman.robustTwr"] == 1.0


def test_the_digest_tells_other_inputs_apart(short_inputs):
    flight = short_inputs.flights["pid"]
    other = Inputs({"pid": flight})
    before = other.digest
    flight.tracks["supply_voltage"][7] += np.float32(1e-6)
    changed = other.digest
    flight.tracks["supply_voltage"][7] -= np.float32(1e-6)
    assert changed != before
    assert other.digest == before


def test_a_file_that_is_none_is_one_sentence(tmp_path):
    with pytest.raises(CrazychoirError, match="cannot be read: No such file"):
        load(tmp_path / "none.npz")
    (tmp_path / "text.npz").write_text("no inputs")
    with pytest.raises(CrazychoirError, match="holds no inputs for this version"):
        load(tmp_path / "text.npz")
    np.savez(tmp_path / "other.npz", facts=np.array('{"format": "another"}'))
    with pytest.raises(CrazychoirError, match="its format is 'another'"):
        load(tmp_path / "other.npz")


def test_a_file_with_structs_of_another_layout_is_refused(short_inputs, tmp_path):
    flight = short_inputs.flights["pid"]
    tracks = {**flight.tracks, "estimate": flight.tracks["estimate"]["position"].copy()}
    changed = Inputs({"pid": type(flight)(**{**vars(flight), "tracks": tracks})}, {})
    changed.save(tmp_path / "old.npz")
    with pytest.raises(CrazychoirError, match="pid/estimate has another layout"):
        load(tmp_path / "old.npz")
