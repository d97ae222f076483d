"""Normalized innovations squared of the built-in filter, from the queue of measurements that its last loop has fused.

A copy of the drone from before that loop is led through prediction and process noise, without measurements. Then each
measurement is compared with what that copy expects. For a scalar measurement with innovation e of variance s the state
moves by P H' e / s and its variances shrink by (P H')² / s, so that e² / s is the square of the one over the other,
whatever the model of the measurement. Poses, positions and flow, which hold several numbers, are compared number by
number with the covariance before the first.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.onboard.variables import log_table
from crazychoir_fw.simulation import Drone

_X, _Z, _PX, _D0 = 0, 2, 3, 6
_PIXELS_PER_RADIAN = 35.0 / 0.71674
_RESOLUTION = 0.1  # of a count of the flow deck
_LEAST = 1e-7  # relative decrease of a variance that float32 still shows

_INERTIAL = (lib.MeasurementTypeGyroscope, lib.MeasurementTypeAcceleration, lib.MeasurementTypeBarometer)
_COVARIANCE_BEFORE = ffi.offsetof("kalmanCoreData_t", "P") + ffi.offsetof("cf_kalman_t", "core")


class Innovations:
    """Looks at one drone of a world that is stepped tick by tick."""

    def __init__(self, drone: Drone) -> None:
        self._drone = drone
        self._bytes = lib.cf_state_bytes(drone.provider_number)
        self._copy = ffi.new("uint64_t[]", self._bytes // 8)
        self._place = log_table(drone.provider_number)["kalman.varX"].offset - _COVARIANCE_BEFORE

    def watch(self) -> None:
        """Call before each step of the world."""
        ffi.memmove(self._copy, self._drone.struct, self._bytes)

    def read(self) -> list[float]:
        """Return the normalized innovations squared of what that step has fused."""
        copy = ffi.cast("cf_t *", self._copy)
        estimator = self._drone.struct.onboard.estimator
        appended = lib.CF_ESTIMATOR_APPENDED
        count = estimator.events[appended] - copy.onboard.estimator.events[appended]  # negative once per second
        fused = [estimator.queue[i] for i in range(count) if estimator.queue[i].type not in _INERTIAL]
        if not fused:
            return []
        now = self._lead(copy)
        found: list[float] = []
        for measurement in fused:
            found += self._compare(copy, measurement, now)
        return found

    def _lead(self, copy: Any) -> int:
        """Let the copy predict to the tick (ms) of the loop; return it."""
        onboard, now = copy.onboard, self._drone.struct.onboard.tick
        is_flying = lib.cf_supervisor_is_flying(ffi.addressof(onboard, "supervisor"))
        provider = lib.cf_provider(copy.config.provider)
        lib.cf_estimator_run(ffi.addressof(onboard, "estimator"), provider, copy.provider_state, now, is_flying)
        return now

    def _compare(self, copy: Any, measurement: Any, now: int) -> list[float]:
        estimator = copy.onboard.estimator
        kalman = ffi.cast("cf_kalman_t *", ffi.cast("char *", copy) + self._place)
        before = _Belief(kalman.core)
        kind, data = measurement.type, measurement.data
        gyro = ffi.addressof(estimator, "gyroLatest")
        resolved = ffi.new("cf_resolved_sweep_t *")
        whole = lib.cf_lighthouse_resolve(resolved, ffi.addressof(measurement), ffi.addressof(estimator, "stations"))
        lib.cf_kalman_update(kalman, whole, gyro, now)
        if kind == lib.MeasurementTypePose:
            return [*before.of_position(data.pose.pos, data.pose.stdDevPos), *before.of_attitude(data.pose)]
        if kind == lib.MeasurementTypePosition:
            return list(before.of_position(data.position.pos, data.position.stdDev))
        if kind == lib.MeasurementTypeFlow:
            return list(before.of_flow(data.flow, gyro))
        return list(before.of_scalar(_Belief(kalman.core)))


class _Belief:
    """State, attitude and covariance of the filter at one moment."""

    def __init__(self, core: Any) -> None:
        self.state = np.array(list(core.S))
        self.quat_wxyz = np.array(list(core.q))
        self.rotation = np.array([list(row) for row in core.R])
        self.covariance = np.array([list(row) for row in core.P])

    def of_position(self, position: Any, deviation: float) -> Iterator[float]:
        for i in range(3):
            yield (position[i] - self.state[_X + i]) ** 2 / (self.covariance[_X + i, _X + i] + deviation**2)

    def of_attitude(self, pose: Any) -> Iterator[float]:
        """docs/reference/estimators.md#5.8: twice the vector of the residual quaternion over its scalar."""
        w, x, y, z = self.quat_wxyz
        b, v = np.array([pose.quat.x, pose.quat.y, pose.quat.z]), np.array([-x, -y, -z])
        residual = w * b + pose.quat.w * v + np.cross(v, b)
        turn = 2.0 * residual / (w * pose.quat.w - v @ b)
        for i in range(3):
            yield turn[i] ** 2 / (self.covariance[_D0 + i, _D0 + i] + pose.stdDevQuat**2)

    def of_flow(self, flow: Any, gyro: Any) -> Iterator[float]:
        """docs/reference/estimators.md#5.7."""
        z = max(self.state[_Z], 0.1)
        k, upright = flow.dt * _PIXELS_PER_RADIAN, self.rotation[2, 2]
        rates = np.radians([-gyro.y, gyro.x])
        for i, (measured, deviation) in enumerate(((flow.dpixelx, flow.stdDevX), (flow.dpixely, flow.stdDevY))):
            speed, row = self.state[_PX + i], np.zeros(9)
            row[_Z], row[_PX + i] = -k * upright * speed / z**2, k * upright / z
            error = measured * _RESOLUTION - k * (speed * upright / z + rates[i])
            yield error**2 / (row @ self.covariance @ row + (deviation * _RESOLUTION) ** 2)

    def of_scalar(self, after: _Belief) -> Iterator[float]:
        variances: NDArray = np.diag(self.covariance)
        shrunk = variances - np.diag(after.covariance)
        clearest = int(np.argmax(shrunk / variances))
        if shrunk[clearest] > _LEAST * variances[clearest]:  # else the filter's gate has refused it
            yield (after.state - self.state)[clearest] ** 2 / shrunk[clearest]
