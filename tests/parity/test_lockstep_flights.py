"""Flights of two worlds, tick by tick."""

import pytest

from crazychoir_fw.parity.deviation import Verdict
from crazychoir_fw.parity.fleet import FLEET
from crazychoir_fw.parity.flights import compare_flights
from crazychoir_fw.parity.side import Side

TICK = 2501


def test_the_whole_fleet_is_identical_to_itself():
    results = compare_flights(Side(), Side(), 0.3)
    assert {result.verdict for result in results} == {Verdict.IDENTICAL}
    assert [result.name for result in results] == [member.name for member in FLEET]
    signals = {deviation.signal for deviation in results[0].deviations}
    assert {"true.x", "motor.m1", "stateEstimate.vx", "kalman.varX", "pm.vbat", "refused commands"} <= signals


def test_a_parameter_that_changes_in_flight_is_found_at_that_tick(members):
    def disturb(drone, tick):
        if drone.id == "pid" and tick == TICK:
            drone.param["pid_rate.yaw_kp"] = 60.0

    results = {
        result.name: result
        for result in compare_flights(Side(), Side(), 1.5, fleet=members("pid", "mellinger"), disturb=disturb)
    }
    assert results["mellinger"].verdict is Verdict.IDENTICAL
    result = results["pid"]
    # rates are controlled in every second tick
    assert result.first_tick in (TICK + 1, TICK + 2)
    assert "pid_rate.yaw_outP" in result.first_signals
    assert "true.yaw" not in result.first_signals
    assert result.verdict is Verdict.EQUAL


def test_another_flight_is_different_and_drawn(members):
    def disturb(drone, tick):
        if tick == TICK:
            drone.param["posCtlPid.thrustBase"] = 30000

    (result,) = compare_flights(Side(), Side(), 1.5, fleet=members("pid"), disturb=disturb)
    assert result.verdict is Verdict.DIFFERENT
    true_height = next(deviation for deviation in result.deviations if deviation.signal == "true.z")
    assert true_height.first_beyond_tick > true_height.first_tick > TICK
    assert true_height.max_absolute > 0.01
    trace = result.traces["true.z"]
    assert trace.deviation.max() == pytest.approx(true_height.max_absolute, rel=1e-12)


def test_a_command_that_one_drone_refuses_is_told(members):
    def disturb(drone, tick):
        if tick == TICK - 800:
            drone.emergency_stop()

    (result,) = compare_flights(Side(), Side(), 2.0, fleet=members("position"), disturb=disturb)
    assert result.verdict is Verdict.DIFFERENT


def test_the_others_fly_when_one_drone_fails(members):
    def disturb(drone, tick):
        if drone.id == "mellinger" and tick == 1000:
            drone.emergency_stop()

    results = {
        result.name: result
        for result in compare_flights(Side(), Side(), 0.5, fleet=members("pid", "mellinger"), disturb=disturb)
    }
    # contacts with the floor are solved together, which may cost the last bit of a double
    height = next(deviation for deviation in results["pid"].deviations if deviation.signal == "true.z")
    assert height.max_absolute < 1e-9
    assert results["mellinger"].verdict is Verdict.DIFFERENT


def test_drones_whose_controller_one_side_lacks_stay_at_home(members):
    class WithoutLee(Side):
        def has_controller(self, word):
            return word != "lee" and super().has_controller(word)

    results = {
        result.name: result for result in compare_flights(Side(), WithoutLee(), 0.1, fleet=members("pid", "lee"))
    }
    assert results["lee"].verdict is Verdict.MISSING
    assert results["lee"].missing_in == ("builtin",)
    assert results["pid"].verdict is Verdict.IDENTICAL
