"""One iteration after the other: which step does what, and in which order.

docs/reference/control-pid.md#3, #4 and #14, docs/reference/planner-commander.md#8.5 and #14.6.
"""

import numpy as np
import pytest
from supervisor_states import BOOT, FREE_FALL, LOCKED, NOT_PASSED, PASSED, READY
from test_onboard import Bench, choosing

from crazychoir_fw._core import ffi, lib

FIRST_TICK = 1513  # of step 1: 1000 ms of start-up, then 512 samples of the gyro, then the loop
MANUAL_THRUST = 30000


def brushless(config) -> None:
    default = ffi.new("cf_config_t *")
    assert lib.cf_config_default(default, lib.CF_PLATFORM_CF21BL) == lib.CF_OK
    config[0] = default[0]


class Loop(Bench):
    """A drone on the floor that is run to the end of a step."""

    @property
    def step(self) -> int:
        """The step that ran last; the loop already counts the next one."""
        return self.cf.onboard.step - 1

    @property
    def motors(self) -> list[int]:
        return list(self.cf.onboard.motors.list)

    @property
    def state(self) -> int:
        return self.cf.onboard.supervisor.state

    def run_to(self, step: int):
        self.rest(FIRST_TICK + step - 1 - self.cf.onboard.tick)
        assert self.step == step
        return self.cf.onboard

    def push(self, thrust: int = MANUAL_THRUST) -> None:
        """Ask for thrust as a client does."""
        assert lib.cf_send_manual(self.cf, 0.0, 0.0, 0.0, thrust, False) == lib.CF_OK

    def arm(self) -> None:
        assert lib.cf_arm(self.cf, True) == lib.CF_OK


# ---------------------------------------------------------------- boot


def test_step_one_runs_at_tick_1513():
    """docs/reference/control-pid.md#4, "Start": the step is not the tick."""
    loop = Loop()
    loop.rest(FIRST_TICK - 1)
    assert loop.cf.onboard.step == 0  # calibrated by now
    loop.rest(1)
    assert loop.cf.onboard.step == 2  # counted at the end of the iteration
    loop.rest(100)
    assert loop.cf.onboard.step == 102
    assert loop.cf.onboard.tick == FIRST_TICK + 100


def test_filter_has_fallen_for_one_and_a_half_seconds_and_restarts_once():
    """docs/reference/estimators.md#18.1, whose number is that of a first loop at tick 1513."""
    loop = Loop(choosing(lib.CF_POSITIONING_NONE, lib.StateEstimatorTypeKalman))
    loop.run_to(1)
    assert loop.log("kalman.stateZ") == pytest.approx(-11.23, abs=0.005)
    assert loop.log("kalman.statePZ") == pytest.approx(-14.84, abs=0.005)
    loop.run_to(2)
    assert abs(loop.log("kalman.stateZ")) < 0.1


def test_auto_arming_is_ready_at_step_120_and_motors_turn_from_121():
    """Motors follow what was decided an iteration before.

    docs/reference/planner-commander.md#14.6, docs/reference/control-pid.md#4.
    """
    loop = Loop()
    loop.run_to(1)
    states = {}
    for step in range(2, 131):
        before = loop.state
        loop.push()
        loop.run_to(step)
        if loop.state != before:
            states[step] = (before, loop.state)
        assert (max(loop.motors) > 0) == (step >= 121)
    assert states == {40: (BOOT, NOT_PASSED), 80: (NOT_PASSED, PASSED), 120: (PASSED, READY)}


def test_high_level_commands_are_let_in_from_step_121():
    """docs/reference/planner-commander.md#14.6."""
    loop = Loop()
    takeoff = lambda: lib.cf_takeoff(loop.cf, 1.0, 2.0, 0.0, True)
    loop.run_to(120)
    assert takeoff() == lib.CF_ERR_BLOCKED
    loop.run_to(121)
    assert takeoff() == lib.CF_OK


def test_required_arming_takes_effect_at_the_next_multiple_of_40():
    """docs/reference/planner-commander.md#14.6."""
    loop = Loop(brushless)
    loop.run_to(201)
    assert loop.state == PASSED
    loop.arm()
    loop.run_to(239)
    assert loop.state == PASSED
    loop.run_to(240)
    assert loop.state == READY
    loop.run_to(241)
    assert loop.motors == [7000] * 4  # the idle floor of an armed brushless (docs/reference/control-pid.md#13)


# ---------------------------------------------------------------- rates


def test_planner_speaks_at_multiples_of_ten_also_when_idle():
    """Null setpoints keep the commander fresh.

    docs/reference/control-pid.md#3, docs/reference/planner-commander.md#7.4.
    """
    loop = Loop()
    onboard = loop.run_to(9)
    assert onboard.commander.priority == lib.COMMANDER_PRIORITY_DISABLE
    for step in range(10, 61):
        loop.run_to(step)
        assert onboard.commander.priority == lib.COMMANDER_PRIORITY_HIGHLEVEL
        assert onboard.commander.setpoint.timestamp == FIRST_TICK - 1 + step // 10 * 10


def test_attitude_runs_at_even_steps_and_outputs_are_held_between():
    """docs/reference/control-pid.md#3 and #4: the control is kept from one iteration to the next."""
    loop = Loop()
    loop.run_to(130)
    outputs = []
    for step in range(131, 151):
        loop.push(MANUAL_THRUST)
        loop.motion.rates = [0.01 * step, 0.0, 0.0]
        loop.run_to(step)
        outputs.append(loop.cf.onboard.control.roll)
    even, odd = outputs[1::2], outputs[2::2]
    assert odd == even[:-1]
    assert len(set(even)) > 5


def test_position_runs_at_multiples_of_ten():
    """docs/reference/control-pid.md#3 and #11: a height that is asked for after step 120 is flown from step 130 on."""
    loop = Loop()
    loop.run_to(121)
    thrusts = {}
    for step in range(122, 141):
        assert lib.cf_send_hover(loop.cf, 0.0, 0.0, 0.0, 1.0) == lib.CF_OK
        loop.run_to(step)
        thrusts[step] = loop.cf.onboard.control.thrust
    assert {step for step, thrust in thrusts.items() if thrust == 0} == set(range(122, 130))
    assert thrusts[130] == thrusts[139] != thrusts[140]


def test_supervisor_looks_at_multiples_of_40():
    """docs/reference/control-pid.md#3."""
    loop = Loop()
    loop.run_to(121)
    lib.cf_emergency_stop(loop.cf)
    loop.run_to(159)
    assert loop.state == READY
    loop.run_to(160)
    assert loop.state == FREE_FALL
    loop.run_to(200)
    assert loop.state == LOCKED


# ---------------------------------------------------------------- order


def test_stop_nulls_the_setpoint_at_once_and_the_motors_one_step_later():
    """docs/reference/control-pid.md#4: an armed brushless idles for one more iteration."""
    loop = Loop(brushless)
    loop.run_to(201)
    loop.arm()
    for step in range(202, 280):
        loop.push()
        loop.run_to(step)
    assert min(loop.motors) > 7000
    lib.cf_emergency_stop(loop.cf)
    loop.push()
    loop.run_to(279)
    assert min(loop.motors) > 7000
    loop.push()
    onboard = loop.run_to(280)
    assert loop.state == FREE_FALL
    assert onboard.setpoint.thrust == 0.0
    assert loop.motors == [7000] * 4
    loop.run_to(281)
    assert loop.motors == [0] * 4


def test_estimate_of_the_filter_is_handed_out_one_step_later():
    """docs/reference/control-pid.md#4, step 5: the estimator's task runs behind the loop."""
    loop = Loop()
    loop.run_to(200)
    for _ in range(30):
        loop.motion.position = [loop.motion.position[0] + 0.001, 0.0, 0.0]
        finished = bytes(ffi.buffer(ffi.addressof(loop.cf.onboard.estimator, "estimate")))
        loop.rest(1)
        handed_out = bytes(ffi.buffer(ffi.addressof(loop.cf.onboard, "estimate")))
        assert handed_out == finished
    assert loop.cf.onboard.estimate.position.x > 0.001


def test_setpoint_of_the_step_is_what_the_supervisor_judges():
    """docs/reference/control-pid.md#4, steps 9 and 10: a setpoint that is sent just before the update counts in it."""
    loop = Loop()
    loop.run_to(121)
    loop.push()
    loop.run_to(199)
    loop.push()
    onboard = loop.run_to(719)  # at step 720 it would be 521 ms old
    assert onboard.supervisor.conditions & lib.SUPERVISOR_CB_COMMANDER_WDT_WARNING == 0
    loop.push()
    loop.run_to(720)
    assert onboard.supervisor.conditions & lib.SUPERVISOR_CB_COMMANDER_WDT_WARNING == 0
    loop.run_to(1240)
    assert onboard.supervisor.conditions & lib.SUPERVISOR_CB_COMMANDER_WDT_WARNING


def test_health_test_stands_in_for_the_iteration_and_stops_the_count_of_steps():
    """docs/reference/control-pid.md#4, step 3."""
    loop = Loop()
    onboard = loop.run_to(130)
    loop.set("health.startPropTest", 1)
    loop.rest(4 * 1000)
    assert loop.step == 130
    loop.rest(1)
    assert (loop.step, onboard.health.motor_pass) == (131, 0b1111)


def test_motor_commands_are_compensated_then_capped():
    """docs/reference/control-pid.md#4, "control motors", and #14: the cap works on duties."""
    loop = Loop()
    loop.run_to(121)
    loop.push(60000)
    onboard = loop.run_to(124)
    uncapped, compensated = onboard.uncapped.list[0], onboard.compensated.list[0]
    curve = ffi.addressof(lib.cf_platform_facts(lib.CF_PLATFORM_CF2).thrust)
    assert compensated == int(lib.cf_battery_compensate(curve, uncapped, onboard.supply_voltage)) != uncapped
    assert [loop.log(f"motor.m{i + 1}req") for i in range(4)] == list(onboard.compensated.list)
    assert loop.motors == [min(65535, max(0, value)) for value in onboard.compensated.list]


def test_supply_voltage_is_filtered_while_motors_are_controlled():
    """docs/reference/control-pid.md#14: it starts at 4.2 V and takes a hundredth of the difference each time."""
    loop = Loop()
    loop.cf.vehicle.battery.voltage = 3.7
    onboard = loop.run_to(120)
    assert onboard.supply_voltage == np.float32(4.2)
    expected = np.float32(4.2)
    for step in range(121, 641):
        onboard = loop.run_to(step)
        expected += np.float32(0.01) * (np.float32(onboard.power.voltage) - expected)
        assert onboard.supply_voltage == expected
    # a start at 4.2 V means half a second of a wrong voltage
    assert onboard.supply_voltage == pytest.approx(onboard.power.voltage, abs=0.01)
