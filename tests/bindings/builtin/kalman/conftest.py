"""Shared by the tests of the filter: the flight of the check vectors, and a dense twin in numpy.

The twin follows docs/reference/estimators.md#4 and #5, with nothing left out: full 9 x 9 products, accumulated
from k = 0 upward in float32. The C code leaves out terms that are zero by structure and must get the same numbers.
"""

import dataclasses
import math
from collections.abc import Callable, Iterator

import numpy as np
import pytest
from numpy.typing import NDArray

from crazychoir_fw._core import ffi, lib

F = np.float32
Matrix = NDArray[np.float32]

GRAVITY = F(9.81)
EPS = F(1e-6)
HALF = F(0.5)
TWO = F(2.0)

SINE = np.array([round(math.sin(2 * math.pi * k / 512), 8) for k in range(513)], dtype=np.float32)


def table_sine(turns: F) -> F:
    """Return the sine of a number of turns as the firmware's table gives it (docs/reference/estimators.md#2)."""
    whole = np.trunc(turns) - F(1.0 if turns < 0 else 0.0)
    position = F(512.0) * (turns - whole)
    segment = int(position)
    if segment >= 512:
        segment, position = 0, position - F(512.0)
    part = position - F(segment)
    return (F(1.0) - part) * SINE[segment] + part * SINE[segment + 1]


def product(a: Matrix, b: Matrix) -> Matrix:
    """Return the matrix product, accumulated in order in float32."""
    total = np.zeros((a.shape[0], b.shape[1]), dtype=np.float32)
    for k in range(a.shape[1]):
        total = total + a[:, k : k + 1] * b[k : k + 1, :]
    return total


def bounded(p: Matrix, extra: Matrix | None = None) -> Matrix:
    """Return the covariance made symmetric and bounded, pair by pair (docs/reference/estimators.md#4.3)."""
    p = p.copy()
    for i in range(9):
        for j in range(i, 9):
            value = HALF * p[i, j] + HALF * p[j, i]
            if extra is not None:
                value = value + extra[i, j]
            if np.isnan(value) or value > F(100.0):
                value = F(100.0)
            elif i == j and value < F(1e-6):
                value = F(1e-6)
            p[i, j] = p[j, i] = value
    return p


def turned(q: Matrix, v: Matrix) -> Matrix:
    """Return q turned by the rotation vector v, not normalized."""
    angle = np.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]) + EPS
    turns = angle / TWO * F(0.159154943092)
    w, s = table_sine(turns + F(0.25)), table_sine(turns)
    x, y, z = (s * v[k] / angle for k in range(3))
    return np.array(
        [
            w * q[0] - x * q[1] - y * q[2] - z * q[3],
            x * q[0] + w * q[1] + z * q[2] - y * q[3],
            y * q[0] - z * q[1] + w * q[2] + x * q[3],
            z * q[0] + y * q[1] - x * q[2] + w * q[3],
        ],
        dtype=np.float32,
    )


def normalized(q: Matrix) -> Matrix:
    return q / (np.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]) + EPS)


def attitude_block(half: Matrix) -> Matrix:
    a, b, c = half
    one = F(1.0)
    return np.array(
        [
            [one - b * b / TWO - c * c / TWO, c + a * b / TWO, -b + a * c / TWO],
            [-c + a * b / TWO, one - a * a / TWO - c * c / TWO, a + b * c / TWO],
            [b + a * c / TWO, -a + b * c / TWO, one - a * a / TWO - b * b / TWO],
        ],
        dtype=np.float32,
    )


def rotation(q: Matrix) -> Matrix:
    a, b, c, d = q
    return np.array(
        [
            [a * a + b * b - c * c - d * d, TWO * b * c - TWO * a * d, TWO * b * d + TWO * a * c],
            [TWO * b * c + TWO * a * d, a * a - b * b + c * c - d * d, TWO * c * d - TWO * a * b],
            [TWO * b * d - TWO * a * c, TWO * c * d + TWO * a * b, a * a - b * b - c * c + d * d],
        ],
        dtype=np.float32,
    )


@dataclasses.dataclass
class DenseFilter:
    """The filter in numpy: state S (9,), attitude q (4,) as w x y z, R (3, 3), covariance P (9, 9), all float32."""

    S: Matrix
    q: Matrix
    R: Matrix
    P: Matrix
    initial_quaternion: Matrix

    @classmethod
    def of(cls, core: ffi.CData) -> "DenseFilter":
        """Return a twin with the state of a kalmanCoreData_t."""
        return cls(array(core.S), array(core.q), array(core.R), array(core.P), array(core.initialQuaternion))

    def predict(self, acc: Matrix, gyro: Matrix, dt: F, is_flying: bool) -> None:
        (px, py, pz), R, (wx, wy, wz) = self.S[3:6].copy(), self.R, gyro
        A = np.eye(9, dtype=np.float32)
        A[0:3, 3:6] = R * dt
        A[0:3, 6] = (py * R[:, 2] - pz * R[:, 1]) * dt
        A[0:3, 7] = (-px * R[:, 2] + pz * R[:, 0]) * dt
        A[0:3, 8] = (px * R[:, 1] - py * R[:, 0]) * dt
        A[3, 4], A[3, 5] = wz * dt, -wy * dt
        A[4, 3], A[4, 5] = -wz * dt, wx * dt
        A[5, 3], A[5, 4] = wy * dt, -wx * dt
        A[3, 7], A[3, 8] = GRAVITY * R[2, 2] * dt, -GRAVITY * R[2, 1] * dt
        A[4, 6], A[4, 8] = -GRAVITY * R[2, 2] * dt, GRAVITY * R[2, 0] * dt
        A[5, 6], A[5, 7] = GRAVITY * R[2, 1] * dt, -GRAVITY * R[2, 0] * dt
        A[6:9, 6:9] = attitude_block(gyro * dt / TWO)
        self.P = product(product(A, self.P), A.T)

        ax, ay, az = (F(0.0), F(0.0), acc[2]) if is_flying else acc
        dt2 = dt * dt
        dx, dy, dz = px * dt, py * dt, pz * dt + az * dt2 / TWO
        if not is_flying:
            dx, dy = dx + ax * dt2 / TWO, dy + ay * dt2 / TWO
        self.S[0] += R[0, 0] * dx + R[0, 1] * dy + R[0, 2] * dz
        self.S[1] += R[1, 0] * dx + R[1, 1] * dy + R[1, 2] * dz
        self.S[2] += R[2, 0] * dx + R[2, 1] * dy + R[2, 2] * dz - GRAVITY * dt2 / TWO
        if is_flying:
            self.S[3] += dt * (wz * py - wy * pz - GRAVITY * R[2, 0])
            self.S[4] += dt * (-wz * px + wx * pz - GRAVITY * R[2, 1])
        else:
            self.S[3] += dt * (ax + wz * py - wy * pz - GRAVITY * R[2, 0])
            self.S[4] += dt * (ay - wz * px + wx * pz - GRAVITY * R[2, 1])
        self.S[5] += dt * (az + wy * px - wx * py - GRAVITY * R[2, 2])

        q = turned(self.q, dt * gyro)
        if not is_flying:
            q = (F(1.0) - F(0.001)) * q + F(0.001) * self.initial_quaternion
        self.q = normalized(q)

    def add_process_noise(self, dt: F) -> None:
        xy, z, w = F(0.5), F(1.0), F(0.1)  # the default parameters
        noise = [xy * dt * dt, xy * dt * dt, z * dt * dt, xy * dt, xy * dt, z * dt, w * dt, w * dt, w * dt]
        for i, n in enumerate(noise):
            self.P[i, i] += n * n
        self.P = bounded(self.P)

    def scalar_update(self, H: Matrix, error: F, std_dev: F) -> None:
        H = H.reshape(1, 9)
        y = product(self.P, H.T)[:, 0]
        r = std_dev * std_dev
        s = r
        for i in range(9):
            s = s + H[0, i] * y[i]
        K = y / s
        self.S = self.S + K * error
        M = product(K.reshape(9, 1), H)
        M[np.diag_indices(9)] -= F(1.0)
        joseph = product(product(M, self.P), M.T)
        self.P = bounded(joseph, K.reshape(9, 1) * r * K.reshape(1, 9))

    def finalize(self) -> None:
        v = self.S[6:9].copy()
        if np.any(np.abs(v) > F(1e-4)) and np.all(np.abs(v) < F(10.0)):
            self.q = normalized(turned(self.q, v))
            A = np.eye(9, dtype=np.float32)
            A[6:9, 6:9] = attitude_block(v / TWO)
            self.P = product(product(A, self.P), A.T)
        self.R = rotation(self.q)
        self.S[6:9] = F(0.0)
        self.P = bounded(self.P)

    def assert_same_as(self, core: ffi.CData) -> None:
        """Demand equal numbers, to the last bit (0.0 and -0.0 being equal)."""
        for name in ("S", "q", "R", "P"):
            np.testing.assert_array_equal(array(getattr(core, name)), getattr(self, name), err_msg=name)


def array(data: ffi.CData) -> Matrix:
    """Return a copy of a float array of C, with its shape."""
    return np.array(
        ffi.unpack(data, len(data))
        if ffi.typeof(data).item.kind == "primitive"
        else [ffi.unpack(row, len(row)) for row in data],
        dtype=np.float32,
    )


def assign(data: ffi.CData, values: NDArray[np.floating]) -> None:
    """Write a float array of C."""
    ffi.buffer(data)[:] = np.ascontiguousarray(values, dtype=np.float32).tobytes()


def random_core(seed: int) -> ffi.CData:
    """Return a kalmanCoreData_t in the middle of some flight, with a full covariance."""
    rng = np.random.default_rng(seed)
    core = ffi.new("kalmanCoreData_t *")
    root = rng.normal(size=(9, 9)) * 10.0 ** rng.uniform(-3, 0, size=(9, 1))
    covariance = bounded((root @ root.T).astype(np.float32))
    q = rng.normal(size=4)
    q = (q / np.linalg.norm(q)).astype(np.float32)
    assign(core.S, np.concatenate([rng.normal(size=6), rng.normal(size=3) * 0.05]))
    assign(core.q, q)
    assign(core.R, rotation(q))
    assign(core.P, covariance)
    assign(core.initialQuaternion, np.array([1.0, 0.0, 0.0, 0.0]))
    core.lastPredictionMs = core.lastProcessNoiseUpdateMs = 1000
    core.isUpdated = True
    return core


def single_update_core() -> ffi.CData:
    """Return the filter that every single update of docs/reference/estimators.md#17.H starts from."""
    core = ffi.new("kalmanCoreData_t *", {"S": [0.5, -0.3, 1.2], "q": [1.0]})
    assign(core.R, np.eye(3))
    assign(core.P, np.diag([0.04, 0.03, 0.02, 1e-3, 1e-3, 1e-3, 1e-4, 1e-4, 1e-4]))
    core.P[0][3] = core.P[3][0] = 0.002
    return core


@dataclasses.dataclass
class SingleUpdate:
    """A row of docs/reference/estimators.md#17.H: what one measurement makes of S and P; None where it says nothing."""

    state: tuple[float | None, float | None, float | None, float | None]  # X, Y, Z, PX
    variance: tuple[float | None, float | None, float | None, float | None]  # of the same
    covariance: tuple[float, float] | None = None  # X with Y, X with PX
    tolerance: float = 1e-6

    def assert_same_as(self, core: ffi.CData) -> None:
        found = [core.S[i] for i in (0, 1, 2, 3)] + [core.P[i][i] for i in (0, 1, 2, 3)]
        expected = [*self.state, *self.variance]
        if self.covariance is not None:
            found += [core.P[0][1], core.P[0][3]]
            expected += [*self.covariance]
        told = [i for i, value in enumerate(expected) if value is not None]
        np.testing.assert_allclose(
            [found[i] for i in told], [expected[i] for i in told], rtol=self.tolerance, atol=0.1 * self.tolerance
        )


Derivative = Callable[[NDArray[np.float64]], float]


def updated_in_double(core: ffi.CData, predict: Derivative, measured: float, std_dev: float) -> tuple:
    """Return S and P after an update in float64, with the numerical derivative of *predict* by the state."""
    S, P = array(core.S).astype(np.float64), array(core.P).astype(np.float64)
    steps = 1e-6 * np.eye(9)
    H = np.array([(predict(S + step) - predict(S - step)) / 2e-6 for step in steps])
    K = P @ H / (H @ P @ H + std_dev**2)
    M = np.eye(9) - np.outer(K, H)
    return S + K * (measured - predict(S)), M @ P @ M.T + np.outer(K, K) * std_dev**2


@pytest.fixture
def params() -> ffi.CData:
    """Return the default parameters of the filter."""
    params = ffi.new("kalmanCoreParams_t *")
    lib.kalmanCoreDefaultParams(params)
    return params


def axis3f(x: float, y: float, z: float) -> ffi.CData:
    return ffi.new("Axis3f *", {"x": x, "y": y, "z": z})


class Flight:
    """The one filter of docs/reference/estimators.md#17: `after("C")` is its core once steps A, B and C are done."""

    def __init__(self, params: ffi.CData) -> None:
        self.core = ffi.new("kalmanCoreData_t *")
        self.params = params
        self.flow_log = ffi.new("cf_flow_log_t *")
        lib.kalmanCoreInit(self.core, params, 0)

    def _predict(self, acc: ffi.CData, gyro: ffi.CData, now_ms: int, is_flying: bool) -> None:
        lib.kalmanCorePredict(self.core, self.params, acc, gyro, now_ms, is_flying)
        lib.kalmanCoreAddProcessNoise(self.core, self.params, now_ms)

    def _steps(self) -> Iterator[tuple[str, Callable[[], None]]]:
        core = self.core
        position = ffi.new("positionMeasurement_t *", {"pos": [1.0, 2.0, 3.0], "stdDev": 0.01})
        tof = ffi.new("tofMeasurement_t *", {"distance": 3.05, "stdDev": 0.05, "coneHalfAngle": math.radians(7.5)})
        flow = ffi.new(
            "flowMeasurement_t *", {"dpixelx": 4.0, "dpixely": -3.0, "stdDevX": 2.0, "stdDevY": 2.0, "dt": 0.01}
        )
        pose = ffi.new("poseMeasurement_t *", {"pos": [1.01, 1.99, 3.02], "stdDevPos": 0.01, "stdDevQuat": 4.5e-3})
        pose.quat.w, pose.quat.x, pose.quat.y, pose.quat.z = 0.99995, 0.003, -0.004, 0.0087
        zero = axis3f(0.0, 0.0, 0.0)

        yield "A", lambda: self._predict(axis3f(0.0, 0.0, 9.81), zero, 10, False)
        yield "B", lambda: lib.kalmanCoreUpdateWithPosition(core, position)
        yield "C", lambda: self._predict(axis3f(0.3, -0.2, 10.3), axis3f(0.1, -0.2, 0.3), 20, True)
        yield "D", lambda: lib.kalmanCoreUpdateWithTof(core, tof)
        yield "E", lambda: lib.cf_mm_flow_update(core, flow, axis3f(5.7, -11.4, 0.0), zero, self.flow_log)
        yield "F", lambda: lib.kalmanCoreUpdateWithPose(core, pose)

    def after(self, last: str) -> ffi.CData:
        for name, step in self._steps():
            step()
            assert lib.kalmanCoreFinalize(self.core)
            if name == last:
                break
        return self.core


@pytest.fixture
def flight(params: ffi.CData) -> Flight:
    """Return the flight of docs/reference/estimators.md#17.A to #17.F."""
    return Flight(params)


@pytest.fixture(scope="session")
def helpers() -> type:
    """Return what several test files need, as one namespace."""

    class Helpers:
        DenseFilter = DenseFilter
        array = staticmethod(array)
        assign = staticmethod(assign)
        axis3f = staticmethod(axis3f)
        random_core = staticmethod(random_core)
        single_update_core = staticmethod(single_update_core)
        product = staticmethod(product)
        bounded = staticmethod(bounded)
        SingleUpdate = SingleUpdate
        updated_in_double = staticmethod(updated_in_double)

    return Helpers
