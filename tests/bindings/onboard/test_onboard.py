"""What the loop adds around its modules: selection, barometer, log variables.

docs/reference/control-pid.md#4, #16 and #17.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.onboard.variables import log_table, parameter_table

AUTO, COMPLEMENTARY, KALMAN = 0, 1, 2
NONE, MOCAP, FLOW = lib.CF_POSITIONING_NONE, lib.CF_POSITIONING_MOCAP, lib.CF_POSITIONING_FLOW


class Bench:
    """A drone that lies level and still."""

    def __init__(self, change: Callable[[Any], None] | None = None) -> None:
        config = ffi.new("cf_config_t *")
        assert lib.cf_config_default(config, lib.CF_PLATFORM_CF2) == lib.CF_OK
        if change is not None:
            change(config)
        self.cf = ffi.new("cf_t *")
        assert lib.cf_init(self.cf, config) == lib.CF_OK
        self.motion = ffi.new("cf_motion_t *")
        self.motion.quat_wxyz = [1, 0, 0, 0]
        self.motion.rotation = [1, 0, 0, 0, 1, 0, 0, 0, 1]
        self.motion.specific_force = [0, 0, 9.81]

    def rest(self, ticks: int) -> Any:
        for _ in range(ticks):
            lib.cf_tick(self.cf, self.motion)
        return self.cf.onboard

    def cell(self, table: Any, name: str) -> np.ndarray:
        variable = table[name]
        return np.frombuffer(ffi.buffer(self.cf), variable.dtype, count=1, offset=variable.offset)

    def log(self, name: str) -> float:
        return self.cell(log_table(), name)[0].item()

    def set(self, name: str, value: float) -> None:
        self.cell(parameter_table(), name)[0] = value

    def get(self, name: str) -> float:
        return self.cell(parameter_table(), name)[0].item()


def choosing(positioning: int, estimator: int) -> Callable[[Any], None]:
    def change(config: Any) -> None:
        config.vehicle.positioning, config.estimator = positioning, estimator

    return change


@pytest.mark.parametrize(
    ("positioning", "asked", "active"),
    [
        (NONE, AUTO, COMPLEMENTARY),
        (MOCAP, AUTO, KALMAN),
        (FLOW, AUTO, KALMAN),
        (NONE, KALMAN, KALMAN),
        (MOCAP, COMPLEMENTARY, COMPLEMENTARY),
    ],
)
def test_estimator_at_boot_is_what_the_positioning_asks_for_unless_chosen(positioning, asked, active):
    bench = Bench(choosing(positioning, asked))
    assert bench.get("stabilizer.estimator") == active
    bench.rest(1600)
    assert bench.get("stabilizer.estimator") == active


@pytest.mark.parametrize(("written", "active"), [(1, 1), (2, 2), (0, 1), (3, 2), (255, 2)])
def test_parameter_selects_and_reads_back_what_became_active(written, active):
    bench = Bench()
    bench.rest(1600)
    bench.set("stabilizer.estimator", written)
    bench.rest(1)
    assert bench.get("stabilizer.estimator") == active
    assert bench.cf.onboard.estimator.type == active


def test_complementary_estimate_is_that_of_this_very_tick():
    bench = Bench(choosing(NONE, AUTO))
    onboard = bench.rest(1600)
    assert bench.log("sensfusion6.isInit") == 1
    assert bench.log("sensfusion6.isCalibrated") == 1
    bench.rest(4 - onboard.step % 4)  # what the loop takes next is a step that fuses
    bench.motion.rates = [0, 0, 8.0]
    step, before = onboard.step, onboard.estimate.attitude.yaw
    bench.rest(1)
    assert step % 4 == 0
    assert onboard.estimate.attitude.yaw - before > 0.004 * onboard.sensors.data.gyro.z / 2


def test_kalman_filter_selected_in_flight_forgets_what_it_knew():
    bench = Bench()
    bench.rest(1600)
    bench.motion.position = [1.0, 0, 0]
    bench.rest(4000)
    assert bench.log("kalman.stateX") == pytest.approx(1.0, abs=0.01)
    bench.set("stabilizer.estimator", COMPLEMENTARY)
    bench.rest(500)
    assert bench.log("kalman.stateX") == pytest.approx(1.0, abs=0.01)  # it stands still
    assert bench.log("stateEstimate.x") == 0.0
    bench.cf.vehicle.mocap.is_lost = True
    bench.rest(50)
    bench.set("stabilizer.estimator", KALMAN)
    bench.rest(5)
    assert bench.log("kalman.stateX") == 0.0
    bench.cf.vehicle.mocap.is_lost = False
    bench.rest(30)
    assert bench.log("stateEstimate.x") == pytest.approx(1.0, abs=0.02)


def test_barometer_reaches_queue_and_log_at_50_hz():
    bench = Bench(choosing(NONE, AUTO))
    bench.motion.position = [0, 0, 2.0]
    bench.cf.vehicle.barometer.config.noise_scale = 0.0
    pressures = []
    for _ in range(1200):
        bench.rest(1)
        pressures.append(bench.log("baro.pressure"))
    # the 20th sample after the start-up delay (docs/reference/estimators.md#12.1)
    assert next(tick for tick, value in enumerate(pressures, 1) if value > 0) == 1020
    assert bench.log("baro.asl") == pytest.approx(2.0, abs=0.006)
    assert bench.log("baro.temp") == 25.0

    bench.rest(1900)  # complete seconds with the loop running
    assert bench.log("estimator.rtApnd") == 2050.0
    assert bench.log("estimator.rtRej") == 0.0
    assert bench.log("stateEstimate.z") == pytest.approx(2.0, abs=0.006)
    assert [bench.log(f"mag.{axis}") for axis in "xyz"] == [0.0, 0.0, 0.0]


def test_measurements_of_a_tick_are_queued_as_gyro_acc_baro():
    bench = Bench(choosing(NONE, AUTO))
    onboard = bench.rest(1019)  # the loop has not started: the oldest wait
    gyro, acc = lib.MeasurementTypeGyroscope, lib.MeasurementTypeAcceleration
    assert [item.type for item in onboard.estimator.queue] == [gyro, acc] * 10
    assert onboard.estimator.queue_count == 20
    onboard.estimator.queue_count = 0
    bench.rest(1)
    assert [item.type for item in onboard.estimator.queue[0:3]] == [gyro, acc, lib.MeasurementTypeBarometer]
    assert onboard.estimator.queue_count == 3


def test_rate_of_the_loop_is_counted_over_half_a_second():
    bench = Bench()
    bench.rest(1400)
    assert bench.log("stabilizer.rtStab") == 0.0  # the sensors are not ready
    bench.rest(600)
    assert 0.0 < bench.log("stabilizer.rtStab") < 1000.0
    bench.rest(500)
    assert bench.log("stabilizer.rtStab") == 1000.0
    assert bench.log("stabilizer.intToOut") == 0
    lib.cf_onboard_fail(ffi.addressof(bench.cf.onboard), lib.CF_FAULT_MOTION)
    bench.rest(1000)
    assert bench.log("stabilizer.rtStab") == 0.0


def test_trim_of_the_configuration_block_counts_from_the_next_boot():
    def ideal(config: Any) -> None:
        config.vehicle.airframe.imu.noise_scale = config.vehicle.airframe.imu.bias_scale = 0.0

    bench = Bench(ideal)
    bench.motion.specific_force = [0, 9.81 * np.sin(np.radians(5)), 9.81 * np.cos(np.radians(5))]
    bench.cf.config.acc_trim_roll = 5.0
    bench.rest(1900)
    assert bench.log("acc.y") == pytest.approx(np.sin(np.radians(5)), abs=0.002)
    lib.cf_reboot(bench.cf)
    bench.rest(1900)
    assert [bench.log(f"acc.{axis}") for axis in "xyz"] == pytest.approx([0, 0, 1], abs=0.002)


COMPRESSED = [
    *((f"stateEstimateZ.{name}", "i2") for name in ("x", "y", "z", "vx", "vy", "vz", "ax", "ay", "az")),
    ("stateEstimateZ.quat", "u4"),
    *((f"stateEstimateZ.{name}", "i2") for name in ("rateRoll", "ratePitch", "rateYaw")),
]
TARGET = [(f"ctrltargetZ.{name}", "i2") for name in ("x", "y", "z", "vx", "vy", "vz", "ax", "ay", "az")]


@pytest.mark.parametrize("group", [COMPRESSED, TARGET])
def test_compressed_groups_have_names_types_and_order_of_the_firmware(group):
    prefix = group[0][0].split(".")[0] + "."
    found = [(name, variable.dtype.str[1:]) for name, variable in log_table().items() if name.startswith(prefix)]
    assert found == group


def test_compressed_groups_are_as_new_as_the_latest_refresh():
    bench = Bench()
    bench.motion.position = [0.5, 0, 0]
    bench.rest(1800)
    assert bench.log("stateEstimateZ.x") == 0
    lib.cf_refresh_logs(bench.cf, 1, 0)
    assert bench.log("stateEstimateZ.x") == int(1000 * bench.log("stateEstimate.x")) > 490
    assert bench.log("stateEstimateZ.az") == pytest.approx(9810, abs=300)


def test_refresh_walks_through_a_swarm():
    drones = ffi.new("cf_t[2]")
    for cf, x in zip((drones[0], drones[1]), (1.0, 2.0), strict=True):
        cf.onboard.setpoint.position.x = x
    lib.cf_refresh_logs(drones, 2, ffi.sizeof("cf_t"))
    assert [drones[i].onboard.compressed_setpoint.x for i in range(2)] == [1000, 2000]
