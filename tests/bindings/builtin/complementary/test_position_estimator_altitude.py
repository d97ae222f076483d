"""Height and climb rate without a Kalman filter (docs/reference/estimators.md#10.3, #17.L)."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from crazychoir_fw._core import ffi, lib

DT = 0.01  # s


class Altitude:
    """An estimator of the height, fresh from boot."""

    def __init__(self) -> None:
        self.struct = ffi.new("cf_altitude_t *")
        ffi.buffer(self.struct)[:] = b"\xaa" * ffi.sizeof("cf_altitude_t")
        lib.cf_altitude_init(self.struct)
        self.estimate = ffi.new("state_t *")

    def step(self, now_ms: int, asl: float = 0.0, distance: float = 0.0, seen_ms: int = 0) -> Any:
        """Take one step; seen_ms is the time of the range."""
        baro = ffi.new("baro_t *", {"asl": asl})
        tof = ffi.new("tofMeasurement_t *", {"timestamp": seen_ms, "distance": distance})
        lib.cf_altitude_estimate(self.struct, self.estimate, baro, tof, DT, now_ms)
        return self.estimate


# tick: height (m), vertical velocity (m/s)
VECTOR_L = {
    1010: (21.0100155, 2101.00171),
    1020: (21.0110531, 0.103759766),
    1100: (21.0456276, 0.624465942),
    1500: (21.416708, 1.00498199),
    2000: (21.911211, 0.988769531),
}


def test_climb_on_the_barometer_is_that_of_the_check_vector():
    altitude, found = Altitude(), {}
    for i in range(1001, 2001):
        if i % 4 == 0:
            lib.cf_altitude_update_velocity(altitude.struct, 0.06 if i < 1500 else -0.05, 0.004)
        if i % 10 == 0:
            estimate = altitude.step(i, asl=np.float32(21 + 0.001 * (i - 1000)))
            found[i] = (estimate.position.z, estimate.velocity.z)
        if i == 1500:
            assert altitude.struct.velocityZ == pytest.approx(0.0715402737, rel=1e-7)
    for i, expected in VECTOR_L.items():
        assert found[i] == pytest.approx(expected, rel=1e-7)
    assert altitude.struct.estimatedVZ == pytest.approx(VECTOR_L[2000][1], rel=1e-7)


def test_first_height_is_that_of_the_barometer_then_it_is_smoothed():
    altitude = Altitude()
    assert altitude.step(1000, asl=100.0).position.z == 100.0
    assert altitude.step(1010, asl=110.0).position.z == pytest.approx(101.0)


@pytest.mark.parametrize(("age", "is_useful"), [(0, True), (50, True), (51, False)])
def test_a_range_is_useful_for_50_ms(age, is_useful):
    altitude = Altitude()
    altitude.step(1000, asl=100.0, distance=2.0, seen_ms=1000 - age)
    assert altitude.struct.is_surface_following == is_useful
    assert altitude.struct.estimatedZ == pytest.approx(0.2 if is_useful else 100.0)


def test_the_surface_is_followed_for_ever_and_the_height_waits_for_the_next_range():
    altitude = Altitude()
    altitude.step(1000, asl=100.0, distance=2.0, seen_ms=1000)
    lib.cf_altitude_update_velocity(altitude.struct, 1.0, 0.004)
    estimate = altitude.step(2000, asl=100.0, distance=2.0, seen_ms=1000)
    assert estimate.position.z == pytest.approx(0.2)
    assert estimate.velocity.z == 0.0
    assert altitude.step(2010, asl=100.0, distance=2.0, seen_ms=2005).position.z > 0.37


def test_ages_of_ranges_survive_the_end_of_the_clock():
    altitude = Altitude()
    altitude.step(10, distance=2.0, seen_ms=2**32 - 20)
    assert altitude.struct.is_surface_following


def test_a_tick_below_50_takes_the_empty_range_for_useful():
    """docs/reference/estimators.md#18.8: the onboard loop starts much later, so that this never happens in a drone."""
    altitude = Altitude()
    altitude.step(50, asl=100.0)
    assert altitude.struct.is_surface_following


@pytest.mark.parametrize(("acc", "velocity"), [(0.039, 0.0), (0.05, 0.01), (-0.05, -0.01), (0.54, 0.5)])
def test_small_accelerations_are_not_integrated(acc, velocity):
    altitude = Altitude()
    lib.cf_altitude_update_velocity(altitude.struct, acc, 0.004)
    assert altitude.struct.velocityZ == pytest.approx(velocity * 0.004 * 9.81 * 0.995, rel=1e-4)


def test_only_the_vertical_part_of_the_estimate_is_written():
    altitude = Altitude()
    ffi.buffer(altitude.estimate)[:] = b"\x01" * ffi.sizeof("state_t")
    before = altitude.estimate.velocity.x
    estimate = altitude.step(1000, asl=1.0)
    assert (estimate.position.x, estimate.position.y, estimate.position.z) == (0.0, 0.0, 1.0)
    assert estimate.velocity.x == estimate.velocity.y == estimate.acc.x == before
