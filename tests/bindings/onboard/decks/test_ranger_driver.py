"""The driver of ranging chips against docs/reference/estimators.md#13.1."""

from typing import Any

import numpy as np
import pytest
from queued import take

from crazychoir_fw._core import ffi, lib

SIDEWAYS = [lib.CF_RANGE_FRONT, lib.CF_RANGE_BACK, lib.CF_RANGE_UP, lib.CF_RANGE_LEFT, lib.CF_RANGE_RIGHT]


class Driver:
    """A driver with the queue of its estimator."""

    def __init__(self) -> None:
        self.driver = ffi.new("cf_ranger_driver_t *")
        self.estimator = ffi.new("cf_estimator_t *")

    def read(self, millimeters: int, direction: int = lib.CF_RANGE_DOWN, tick: int = 25) -> list[Any]:
        lib.cf_ranger_driver_read(self.driver, self.estimator, direction, millimeters, tick)
        return take(self.estimator)


@pytest.fixture
def driver() -> Driver:
    return Driver()


@pytest.mark.parametrize("millimeters", [0, 15, 1234, 4999])
def test_range_becomes_meters_with_its_deviation(driver: Driver, millimeters: int) -> None:
    (measurement,) = driver.read(millimeters, tick=77)
    tof = measurement.data.tof
    assert measurement.type == lib.MeasurementTypeTOF
    assert tof.timestamp == 77
    assert tof.distance == np.float32(millimeters) * np.float32(0.001)
    assert tof.stdDev == lib.cf_range_std(tof.distance)
    assert tof.coneHalfAngle == pytest.approx(np.radians(7.5))


@pytest.mark.parametrize("millimeters", [5000, lib.CF_RANGE_NOTHING, 65535])
def test_far_range_is_logged_but_not_used(driver: Driver, millimeters: int) -> None:
    assert driver.read(millimeters) == []
    assert driver.driver.ranges[lib.CF_RANGE_DOWN] == millimeters


@pytest.mark.parametrize("direction", SIDEWAYS)
def test_other_directions_are_logged_and_never_reach_the_estimator(driver: Driver, direction: int) -> None:
    assert driver.read(700, direction) == []
    assert [driver.driver.ranges[i] for i in range(lib.CF_RANGE_COUNT)] == [
        700 if i == direction else 0 for i in range(lib.CF_RANGE_COUNT)
    ]
