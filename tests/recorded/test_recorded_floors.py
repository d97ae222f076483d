"""Floors on recorded flights of real drones, where a folder with them is given: ``CRAZYCHOIR_FLIGHTS=FOLDER``.

Flights that are saturated are left out: there the pack decides. docs/real_flights.md has the figures of each flight.
"""

import os

import numpy as np
import pytest

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.comparison.motor_replay import replay_motors
from crazychoir_fw.comparison.nanobench import flight_files, read_flight
from crazychoir_fw.comparison.phases import find_phases
from crazychoir_fw.comparison.prediction import predict
from crazychoir_fw.comparison.tuning import tune
from crazychoir_fw.comparison.whole_chain import fly_again
from crazychoir_fw.onboard import vehicles

FOLDER = os.environ.get("CRAZYCHOIR_FLIGHTS", "")
SATURATED = 0.5  # share of the compared part in which a motor is at its top

pytestmark = pytest.mark.skipif(not FOLDER, reason="no folder with recorded flights")


def thrust_max_of(flight, phases):
    try:
        return replay_motors(flight, phases).thrust_max
    except RangeError:
        return None


@pytest.fixture(scope="module")
def results():
    """Of each flight: name, prediction, chain, lowest error of the height (m)."""
    vehicle = vehicles.overrides("nanobench")
    drone = {"positioning": "mocap_position", "mocap_latency_ms": 30}
    found = []
    for path in flight_files(FOLDER):
        flight = read_flight(path)
        phases = find_phases(flight)
        compared = (flight.time >= phases.compared[0]) & (flight.time < phases.compared[1])
        if np.mean(flight.motors[compared].max(axis=1) > 65000) > SATURATED:
            continue
        tuning = tune(flight, phases, vehicle)
        chain = fly_again(flight, phases, vehicle, tuning, drone, thrust_max_of(flight, phases))
        low = float((chain.simulated["position"] - chain.real["position"])[chain.rows, 2].min())
        found.append((flight.name, predict(flight, phases, vehicle, tuning), chain, low))
    return found


def test_no_flight_sinks(results):
    assert {name: low for name, _, _, low in results if low < -0.15} == {}


@pytest.mark.parametrize(("fast", "limit", "share"), [(False, 0.045, 0.9), (True, 0.085, 0.75)])
def test_paths_are_as_close_as_the_floor(results, fast, limit, share):
    paths = [chain.path_rms_m for name, _, chain, _ in results if ("fast" in name) == fast]
    assert np.mean(np.array(paths) <= limit) >= share


def test_thrust_is_right_within_two_percent(results):
    assert np.mean([abs(chain.thrust_percent) <= 2.0 for _, _, chain, _ in results]) >= 0.85


def test_plant_predicts_as_well_as_the_floor(results):
    """Mean over flights, with the trim of the hover and with that of the flight."""
    position = np.mean([ahead.position_cm for _, ahead, _, _ in results], axis=0)
    tilt = np.mean([ahead.tilt_deg for _, ahead, _, _ in results], axis=0)
    assert np.all(position <= [0.2, 0.9, 15.0])
    assert np.all(tilt <= [2.6, 7.5, 26.0])
    assert np.mean([ahead.mean_position_cm[2] for _, ahead, _, _ in results]) <= 10.0
    assert np.mean([ahead.mean_tilt_deg[2] for _, ahead, _, _ in results]) <= 18.0
