"""The health tests, step by step.

docs/reference/planner-commander.md#15; times of docs/reference/control-pid.md#12.
"""

import math

import pytest

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.onboard.variables import parameter_table

CF2, CF21BL = lib.CF_PLATFORM_CF2, lib.CF_PLATFORM_CF21BL


class Bench:
    """A health test with an accelerometer that shakes while motor 3 turns."""

    def __init__(self, platform=CF2):
        self.health = ffi.new("cf_health_t *")
        lib.cf_health_init(self.health, platform)
        self.trace = []

    def run(self, volts_per_count=1e-6):
        motors = ffi.new("motors_thrust_pwm_t *")
        acc = ffi.new("Axis3f *")
        while lib.cf_health_is_running(self.health, False):
            n = len(self.trace)
            acc.x = 0.1 + 0.05 * math.sin(n) * (motors.list[2] > 0)
            acc.y = -0.2
            lib.cf_health_run(self.health, acc, 4.0 - volts_per_count * sum(motors.list), motors)
            self.trace.append(tuple(motors.list))
            assert n < 20_000
        return self.trace


def test_nothing_runs_unasked():
    bench = Bench()
    assert bench.run() == []
    assert bench.health.motor_pass == 0


@pytest.mark.parametrize(("platform", "on", "off", "ratio"), [(CF2, 50, 950, 65535), (CF21BL, 2000, 1000, 10000)])
def test_propellers_are_spun_one_after_the_other(platform, on, off, ratio):
    bench = Bench(platform)
    bench.health.start_propeller_test = 1
    trace = bench.run()
    assert len(trace) == 4 * (on + off)
    for motor in range(4):
        own = [motors[motor] for motors in trace]
        start = motor * (on + off)
        assert own == [0] * start + [ratio] * on + [0] * (len(trace) - start - on)
    assert bench.health.start_propeller_test == 0
    assert bench.health.motor_pass == 0b1111
    assert bench.health.motor_tests == 1


def test_the_shaking_motor_is_found():
    bench = Bench()
    bench.health.start_propeller_test = 1
    bench.run()
    assert bench.health.variance_x[2] == pytest.approx(0.05**2 / 2, rel=0.1)
    assert [bench.health.variance_x[i] for i in (0, 1, 3)] == pytest.approx([0, 0, 0], abs=1e-6)
    assert list(bench.health.variance_y) == pytest.approx([0, 0, 0, 0], abs=1e-6)


@pytest.mark.parametrize(("volts_per_count", "passes"), [(1e-6, 1), (5.9e-6, 1), (6e-6, 0)])
def test_the_battery_sags_under_four_motors(volts_per_count, passes):
    bench = Bench()
    bench.health.start_battery_test = 1
    trace = bench.run(volts_per_count)
    assert trace == [(40000,) * 4] * 50 + [(0,) * 4] * 950
    assert bench.health.battery_sag == pytest.approx(160000 * volts_per_count, abs=1e-5)
    assert bench.health.battery_pass == passes


def test_a_request_in_flight_is_dropped():
    bench = Bench()
    bench.health.start_propeller_test = bench.health.start_battery_test = 1
    assert not lib.cf_health_is_running(bench.health, True)
    assert bench.run() == []


@pytest.mark.parametrize(("parameter", "is_heard"), [("startPropTest", True), ("startBatTest", False)])
def test_the_accelerometer_is_heard_unfiltered_while_propellers_are_tested(parameter, is_heard):
    """docs/reference/estimators.md#12.7: a low-pass at 500 Hz, and back to 30 Hz with empty delays afterwards."""
    config, drone, motion = (ffi.new(f"cf_{kind} *") for kind in ("config_t", "t", "motion_t"))
    assert lib.cf_config_default(config, CF2) == lib.CF_OK
    config.vehicle.airframe.imu.noise_scale = config.vehicle.airframe.imu.bias_scale = 0.0
    assert lib.cf_init(drone, config) == lib.CF_OK
    motion.quat_wxyz, motion.rotation, motion.specific_force = [1, 0, 0, 0], [1, 0, 0, 0, 1, 0, 0, 0, 1], [0, 0, 9.81]
    row = parameter_table()[f"health.{parameter}"]
    acc, slow, fast = drone.onboard.sensors.acc_filter[2], *(ffi.new("lpf2pData *") for _ in range(2))
    lib.lpf2pInit(slow, 1000.0, 30.0)
    lib.lpf2pInit(fast, 1000.0, 500.0)

    def run(ticks):
        for _ in range(ticks):
            lib.cf_tick(drone, motion)

    run(1700)
    assert acc.b0 == slow.b0
    ffi.buffer(drone)[row.offset : row.offset + 1] = b"\x01"
    run(1)
    assert drone.onboard.health.test != 0
    assert acc.b0 == (fast if is_heard else slow).b0
    motion.specific_force = [0, 0, 11.81]
    run(2)
    change = drone.onboard.sensors.data.acc.z - 1.0
    assert change == pytest.approx(2 / 9.81 if is_heard else 0.006, abs=0.005)
    while drone.onboard.health.test != 0:
        run(1)
    assert acc.b0 == slow.b0
    assert (acc.delay_element_1 == 0.0) == is_heard
