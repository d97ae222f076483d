"""The driver of the flow deck against docs/reference/estimators.md#13.1, #13.2, #14.3 and #14.4."""

from typing import Any

import pytest
from queued import take

from crazychoir_fw._core import ffi, lib


class Driver:
    """A driver that booted at tick 0, with the queue of its estimator."""

    def __init__(self) -> None:
        self.driver = ffi.new("cf_flow_driver_t *")
        self.estimator = ffi.new("cf_estimator_t *")
        lib.cf_flow_driver_init(self.driver, 0)

    def read(self, tick: int = 10, **registers: int) -> list[Any]:
        registers = {"motion": lib.CF_FLOW_MOTION, **registers}
        reading = ffi.new("cf_flow_reading_t *", registers)
        lib.cf_flow_driver_read(self.driver, self.estimator, reading, tick)
        return take(self.estimator)

    def flow(self, x: int = 0, y: int = 0, tick: int = 10, **registers: int) -> list[Any]:
        """Read counts along x and y of the body."""
        return self.read(tick, delta_x=-y, delta_y=-x, **registers)


@pytest.fixture
def driver() -> Driver:
    return Driver()


def test_flow_is_turned_into_the_body_frame(driver: Driver) -> None:
    (measurement,) = driver.flow(7, -3, tick=10)
    flow = measurement.data.flow
    assert measurement.type == lib.MeasurementTypeFlow
    assert (flow.dpixelx, flow.dpixely) == (7.0, -3.0)
    assert flow.timestamp == 10
    assert (driver.driver.reading.delta_x, driver.driver.reading.delta_y) == (3, -7)


def test_flow_spans_the_time_since_the_last_reading(driver: Driver) -> None:
    ages = [driver.flow(tick=tick)[0].data.flow.dt for tick in (10, 20, 35)]
    assert ages == pytest.approx([0.01, 0.01, 0.015])


@pytest.mark.parametrize(("x", "y", "is_used"), [(99, -99, True), (100, 0, False), (0, -100, False), (32768, 1, False)])
def test_a_hundred_counts_are_an_outlier(driver: Driver, x: int, y: int, is_used: bool) -> None:
    assert len(driver.flow(x, y)) == is_used
    assert driver.driver.outliers == (not is_used)


def test_outlier_is_dropped_and_the_next_reading_spans_its_time(driver: Driver) -> None:
    assert driver.flow(tick=10) != []
    assert driver.flow(x=300, tick=20) == []
    (measurement,) = driver.flow(tick=30)
    assert measurement.data.flow.dt == pytest.approx(0.02)


def test_outlier_count_wraps_around(driver: Driver) -> None:
    for _ in range(257):
        driver.flow(x=300)
    assert driver.driver.outliers == 1


def test_flow_without_motion_is_not_used_but_takes_its_time(driver: Driver) -> None:
    assert driver.flow(tick=10, motion=lib.CF_FLOW_NO_MOTION) == []
    assert driver.flow(tick=20)[0].data.flow.dt == pytest.approx(0.01)


def test_disabled_flow_does_not_reach_the_estimator(driver: Driver) -> None:
    driver.driver.disable = 1
    assert driver.flow() == []
    driver.driver.disable = 0
    assert len(driver.flow(tick=20)) == 1


@pytest.mark.parametrize(("shutter", "std"), [(0, 0.4335), (710, 1.000364), (2000, 2.0303), (65535, 52.7566)], ids=str)
def test_adaptive_deviation_follows_the_shutter(driver: Driver, shutter: int, std: float) -> None:
    driver.driver.adaptive = 1
    flow = driver.flow(shutter=shutter)[0].data.flow
    assert (flow.stdDevX, flow.stdDevY) == (flow.stdDevX, flow.stdDevX)
    assert flow.stdDevX == pytest.approx(std, rel=1e-5)
    assert driver.driver.std == flow.stdDevX


def test_deviation_is_fixed_at_two_counts(driver: Driver) -> None:
    flow = driver.flow(shutter=2000)[0].data.flow
    assert (flow.stdDevX, flow.stdDevY) == (2.0, 2.0)
    driver.driver.fixed_std = 5.0
    assert driver.flow(tick=20)[0].data.flow.stdDevX == 5.0
