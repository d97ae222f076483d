"""A flight of our own simulator comes back with almost no error: the comparisons compare what they say they do."""

from dataclasses import replace

import numpy as np
import pytest
from recorded import refinement
from recorded.identification import identify
from recorded.refinement import refine

from crazychoir_fw.common.errors import RangeError, StateError
from crazychoir_fw.comparison.controller_replay import replay_controller
from crazychoir_fw.comparison.motor_replay import replay_motors
from crazychoir_fw.comparison.prediction import predict
from crazychoir_fw.comparison.tuning import stillness, tune
from crazychoir_fw.comparison.whole_chain import fly_again


def test_phases(synthetic):
    _, phases = synthetic
    assert phases.starts_on_floor
    assert phases.motors_on == pytest.approx(1.0, abs=0.05)
    assert phases.rest == pytest.approx(3.0, abs=0.1)
    assert phases.trajectory == pytest.approx(4.0, abs=0.1)
    assert phases.end > 13.5


def test_controller_asks_for_the_same(synthetic):
    replay = replay_controller(*synthetic)
    assert replay.roll_rms_deg < 0.1
    assert replay.pitch_rms_deg < 0.1
    assert replay.thrust_rms_percent < 0.05
    assert replay.thrust_offset_rms_percent < 0.1


def test_motors_turn_the_same(synthetic):
    replay = replay_motors(*synthetic)
    assert replay.worst_mean_percent < 0.005
    assert max(replay.rms_percent) < 0.02
    assert replay.thrust_max == 0.12


def test_hover_tells_what_is_the_drones_own(synthetic, true_vehicle, own_parameters):
    tuning = tune(*synthetic, true_vehicle)
    assert tuning.thrust_scale == pytest.approx(own_parameters["rotors.thrust_scale"], rel=0.003)
    assert tuning.trim_torque == pytest.approx(own_parameters["trim.torque"], abs=4e-5)
    assert abs(tuning.log_lag) < 0.003
    assert tuning.misalignment_deg < 0.1


@pytest.mark.parametrize("rest", [0.4, 0.6, 1.0])
def test_a_short_hover_tells_the_scale_as_well(synthetic, true_vehicle, own_parameters, rest):
    flight, phases = synthetic
    short = replace(phases, hover=phases.rest + rest / 2, trajectory=phases.rest + rest)
    assert tune(flight, short, true_vehicle).thrust_scale == pytest.approx(
        own_parameters["rotors.thrust_scale"], rel=0.004
    )


def test_moments_count_by_how_still_they_are():
    weights = stillness(np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.1], [0.3, 0.0, 0.4]]))
    assert weights == pytest.approx([1.0, 0.5, 1 / 26])


def test_older_builds_fly_with_their_own_largest_thrust(older_flight, true_vehicle):
    flight, phases = older_flight
    found = replay_motors(flight, phases)
    assert found.thrust_max == 0.1125
    tuning = tune(flight, phases, true_vehicle)
    drone = {"positioning": "mocap_position", "mocap_latency_ms": 30, "mocap_std": 0.01}
    assert abs(fly_again(flight, phases, true_vehicle, tuning, drone, found.thrust_max).thrust_percent) < 0.5
    assert fly_again(flight, phases, true_vehicle, tuning, drone).thrust_percent < -5.0


def test_plant_goes_where_it_went(synthetic, true_vehicle):
    tuning = tune(*synthetic, true_vehicle)
    prediction = predict(*synthetic, true_vehicle, tuning)
    assert prediction.followed_position_cm[0] < 0.01
    assert prediction.followed_position_cm[2] < 1.5
    assert prediction.mean_position_cm[2] < 1.5
    assert prediction.followed_tilt_deg[2] < 2.0


def test_plant_without_the_moment_of_flight_does_not(synthetic, true_vehicle):
    tuning = tune(*synthetic, true_vehicle)
    without = {**true_vehicle, "flight_moment.enabled": "off"}
    prediction = predict(*synthetic, without, tuning)
    assert prediction.tilt_deg[2] > 20.0


def test_chain_flies_the_same_path(synthetic, true_vehicle):
    tuning = tune(*synthetic, true_vehicle)
    drone = {"positioning": "mocap_position", "mocap_latency_ms": 30, "mocap_std": 0.01}
    chain = fly_again(*synthetic, true_vehicle, tuning, drone)
    assert chain.path_rms_m < 0.01
    assert abs(chain.lag_s) < 0.006
    assert abs(chain.tracking_percent) < 2.0
    assert abs(chain.tilt_percent) < 3.0
    assert abs(chain.thrust_percent) < 0.5
    assert abs(chain.voltage_difference_v) < 0.03


def test_another_vehicle_flies_another_path(synthetic, true_vehicle):
    tuning = tune(*synthetic, true_vehicle)
    poses = {"positioning": "mocap", "mocap_latency_ms": 8, "mocap_std": 0.01, "mocap_attitude_std": 4.5e-3}
    chain = fly_again(*synthetic, true_vehicle, tuning, poses)
    assert chain.path_rms_m > 0.015


def test_identification_finds_what_was_flown(synthetic, true_vehicle):
    flight, _ = synthetic
    found = identify([flight], time_constants=(0.07,), refines=False)
    assert found.vehicle["drag.rotor_xy"] == pytest.approx(true_vehicle["drag.rotor_xy"], rel=0.03)
    assert found.vehicle["flight_moment.x"] == pytest.approx(true_vehicle["flight_moment.x"], rel=0.03)
    assert found.vehicle["flight_moment.y"] == pytest.approx(true_vehicle["flight_moment.y"], rel=0.03)
    assert found.vehicle["battery.resistance"] == pytest.approx(true_vehicle["battery.resistance"], rel=0.15)
    assert found.vehicle["rotors.heat_loss"] == pytest.approx(true_vehicle["rotors.heat_loss"], rel=0.15)
    # a step of the grid: this fit has two heats that fade into one another, and finds 4 s for 5 s
    assert found.vehicle["rotors.heat_time"] == pytest.approx(true_vehicle["rotors.heat_time"], abs=1.0)
    assert found.vehicle["rotors.heat_own_loss"] == pytest.approx(true_vehicle["rotors.heat_own_loss"], abs=0.05)


def test_desired_attitude_tells_the_time_constant(shaken_flight, true_vehicle):
    """Also between the values that are tried. It reads 6 ms too long, and the inertia a tenth too small."""
    found = identify([shaken_flight], time_constants=(0.04, 0.055, 0.075, 0.11), refines=False)
    assert found.vehicle["rotors.time_constant_up"] == pytest.approx(0.07, abs=0.01)
    assert found.vehicle["inertia"] == pytest.approx(true_vehicle["inertia"], rel=0.15)


def test_predictions_tell_the_moment_of_flight(synthetic, true_vehicle, monkeypatch):
    name = "flight_moment.y"
    monkeypatch.setattr(refinement, "REFINED", (name,))  # with all three it takes a minute
    wrong = {**true_vehicle, name: 0.8 * true_vehicle[name]}
    assert refine([synthetic], wrong) == {name: pytest.approx(true_vehicle[name], rel=0.02)}


def test_without_scipy_a_sentence_comes_first(synthetic, monkeypatch):
    monkeypatch.setattr(refinement, "minimize", None)
    with pytest.raises(StateError, match="pip install scipy; --no-refining"):
        identify([synthetic[0]])


def test_inertia_needs_a_flight_that_shakes(shaken_flight, true_vehicle):
    """In a slow flight the roll hardly accelerates: 0.35 to 1.67 of the truth over four seeds.

    Here seeds differ by 1 %. What is left is the moment in which the motors are logged, every 10 ms as the filter's
    attitude is predicted, which moves up to 12 % of the torque in or out of view: 0.89 to 1.12 of the truth over all
    ten moments, 1.01 on average.
    """
    found = identify([shaken_flight], time_constants=(0.07,), refines=False)
    assert found.vehicle["inertia"] == pytest.approx(true_vehicle["inertia"], rel=0.15)


def test_nothing_to_identify_from():
    with pytest.raises(RangeError, match="no flights"):
        identify([])
