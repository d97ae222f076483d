"""Functions on the same inputs: builtin against itself, and against sides that are wrong by a known amount."""

import numpy as np
import pytest

from crazychoir_fw._core import ffi
from crazychoir_fw.parity.cases import all_cases
from crazychoir_fw.parity.deviation import Verdict
from crazychoir_fw.parity.functions import compare_case, compare_functions
from crazychoir_fw.parity.side import Side

NOT_REPLAYED = {
    "init", "begin", "end", "controller_name", "parameters", "logs", "parameter_written", "refresh_logs",
    "out_of_tree_estimator", "out_of_tree_estimator_init",
}  # fmt: skip


@pytest.fixture(scope="module")
def cases(short_inputs):
    return all_cases(short_inputs)


def find(cases, group, name):
    return next(case for case in cases if (case.group, case.name) == (group, name))


def next_float(value):
    return float(np.nextafter(np.float32(value), np.float32(np.inf)))


def test_cases_need_every_function_of_the_table(cases):
    needed = {name for case in cases for name in case.needs}
    functions = {name for name, _ in ffi.typeof("cf_provider_t").fields} - {"name", "platform", "state_bytes", "system"}
    assert needed == functions - NOT_REPLAYED


def test_names_of_cases_are_unique(cases):
    assert len({(case.group, case.name) for case in cases}) == len(cases)


def test_builtin_is_identical_to_itself_in_everything(cases):
    results = compare_functions(Side(), Side(), cases)
    assert {result.verdict for result in results} == {Verdict.IDENTICAL}
    assert all(result.first_tick is None and not result.traces for result in results)
    assert sum(len(result.deviations) for result in results) > 2000


@pytest.mark.parametrize("platform", ["cf2", "cf21bl"])
def test_made_up_inputs_move_what_they_are_to_move(cases, platform):
    for group, name, signal in (
        ("power", "mixer: normalized forces", "uncapped.list.1"),
        ("power", "battery compensation", "compensated.list.0"),
        ("power", "cap", "was_capped"),
        ("power", "motor override", "pwm.list.3"),
        ("kalman", "out of bounds", "is_within_bounds"),
        ("planner", "compressed", "goal.yaw"),
        ("planner", "spirals", "goal.omega.z"),
        ("collision avoidance", "made up: on", "setpoint.position.x"),
    ):
        result = compare_case(Side(), Side(platform=platform), find(cases, group, name))
        assert signal in {deviation.signal for deviation in result.deviations}
    from crazychoir_fw.parity.cases import CaseRequest

    for group, name, signal in (("kalman", "out of bounds", "is_within_bounds"), ("power", "cap", "was_capped")):
        values = find(cases, group, name).run(CaseRequest(Side(platform=platform))).signals[signal]
        assert values.any()
        assert not values.all()


def test_one_ulp_in_one_output_is_found_with_signal_tick_and_size(cases, perturbed, short_inputs):
    def change(call, arguments, result):
        if call == 200:
            control = ffi.cast("control_t *", arguments[1])
            control.thrustSi = next_float(control.thrustSi)
        return result

    case = find(cases, "controller", "lee: flight lee")
    result = compare_case(Side(), perturbed("controller", change), case)
    tick = int(short_inputs.flights["lee"].tracks["tick"][200])
    assert result.first_tick == tick
    assert result.first_signals == ["control.thrustSi"]
    worst = result.worst
    # the controller writes its output in every second step, or keeps what is there
    assert (worst.signal, worst.max_ulps, worst.first_tick) == ("control.thrustSi", 1, tick)
    assert worst.deviating in (1, 2)
    assert worst.verdict is result.verdict is Verdict.EQUAL
    assert list(result.traces) == ["control.thrustSi"]


def test_estimate_that_is_no_number_is_different_whatever_the_tolerance(cases, perturbed, short_inputs):
    def change(call, arguments, result):
        if call == 300:
            ffi.cast("state_t *", arguments[1]).velocity.y = float("nan")
        return result

    result = compare_case(Side(), perturbed("kalman_externalize", change), find(cases, "kalman", "flight pid"))
    worst = result.worst
    tick = int(short_inputs.flights["pid"].tracks["tick"][300])
    assert (worst.signal, worst.unmatched, worst.first_tick) == ("estimate.velocity.y", 1, tick)
    assert result.verdict is Verdict.DIFFERENT


def test_one_count_of_a_motor_is_within_tolerance_and_two_are_not(cases, perturbed):
    for counts, verdict in ((1, Verdict.EQUAL), (2, Verdict.DIFFERENT)):

        def change(call, arguments, result, counts=counts):
            if call == 40:
                ffi.cast("motors_thrust_uncapped_t *", arguments[2]).list[2] += counts
            return result

        result = compare_case(Side(), perturbed("power_distribution", change), find(cases, "power", "mixer: legacy"))
        assert (result.worst.signal, result.worst.first_tick) == ("uncapped.list.2", 40)
        assert result.worst.max_absolute == counts
        assert result.verdict is verdict


def test_a_refusal_on_one_side_alone_is_different(cases, perturbed):
    def change(call, arguments, result):
        return 0 if call == 1 else result

    result = compare_case(Side(), perturbed("plan_takeoff", change), find(cases, "planner", "take-off and landing"))
    assert [deviation.signal for deviation in result.deviations if deviation.deviating] == ["status"]
    assert result.verdict is Verdict.DIFFERENT


def test_a_parameter_shows_in_the_log_variables_that_depend_on_it(cases):
    result = compare_case(
        Side(), Side(parameters={"pid_rate.yaw_kp": 121.0}), find(cases, "controller", "pid: flight pid")
    )
    assert "log.pid_rate.yaw_outP" in result.first_signals
    assert result.verdict is Verdict.DIFFERENT


def test_rounding_of_every_parameter_stays_within_the_tolerances(cases):
    """What another compiler may do must not be called different; one unit in every parameter is more than that."""
    reference = Side()
    parameters = {
        name: float(np.nextafter(np.float32(value), np.float32(0)))
        for name, value in reference.factory_values().items()
        # at exactly 1 the whole attitude is controlled, below it a blend that is another law
        if reference.parameter_table[name].dtype.kind == "f" and value and name != "ctrlAtt.mixing_factor"
    }
    assert len(parameters) > 100
    results = compare_functions(reference, Side(parameters=parameters), cases)
    assert [(result.name, result.worst) for result in results if result.verdict is Verdict.DIFFERENT] == []
    assert sum(result.verdict is Verdict.EQUAL for result in results) > 30


def test_a_function_that_one_side_lacks_is_missing_there(cases):
    poor = Side()
    del poor.functions["kalman_predict"]
    result = compare_case(Side(), poor, find(cases, "kalman", "flight pid"))
    assert result.verdict is Verdict.MISSING
    assert result.missing_in == ("builtin",)
    assert not result.deviations


def test_a_provider_that_gives_up_is_different_and_says_why(cases, perturbed):
    def change(call, arguments, result):
        return 4711  # no status that the core knows

    case = find(cases, "controller", "pid: golden")
    result = compare_case(Side(), perturbed("controller_init", change), case)
    assert result.verdict is Verdict.DIFFERENT
    assert result.failures["candidate"].startswith("builtin: controller pid")
