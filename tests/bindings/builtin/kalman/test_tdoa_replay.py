"""A flight on TDoA alone through the loop of the firmware's Python tests.

docs/reference/cffirmware-api.md#10.13 and #13.
"""

from collections import deque
from collections.abc import Callable

import numpy as np
import pytest

from crazychoir_fw._core import ffi, lib

# the corners of the room, around the floor and then around the ceiling; the reference does not tell the order
ANCHORS = [np.array([x, y, z]) for z in (0.0, 3.0) for x, y in ((0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0))]
TAG = np.array([2.0, 2.0, 1.0])
DURATION_MS = 5000

Update = Callable[[ffi.CData, ffi.CData, int], None]


def point(position: np.ndarray) -> dict[str, float]:
    return dict(zip("xyz", position, strict=True))


def samples() -> deque:
    """Return (time in ms, kind, data), by time: rest at 1 kHz, and a pair of neighboring anchors every 10 ms.

    The first pair comes after the first process noise, which bounds the covariance: before, the variance of x and y
    is 10000, and what an update leaves of that is no longer positive definite once it is cut to 100.
    """
    acc, gyro = ffi.new("Axis3f *", {"x": 0, "y": 0, "z": 1}), ffi.new("Axis3f *", {"x": 0, "y": 0, "z": 0})
    found: deque = deque()
    for now_ms in range(DURATION_MS):
        found.append((now_ms, "acc", acc))
        found.append((now_ms, "gyro", gyro))
        if now_ms % 10 == 9:
            a, b = (ANCHORS[(now_ms // 10 + k) % 8] for k in (0, 1))
            data = {
                "anchorPositions": [point(a), point(b)],
                "distanceDiff": np.linalg.norm(TAG - b) - np.linalg.norm(TAG - a),
                "stdDev": 0.15,
            }
            found.append((now_ms, "tdoa", ffi.new("tdoaMeasurement_t *", data)))
    return found


def replay(params: ffi.CData, core: ffi.CData, update: Update) -> np.ndarray:
    """Return time (ms) and position (m) after each millisecond; *core* belongs to the filter that *update* feeds."""
    waiting = samples()
    now_ms = waiting[0][0]
    next_prediction = now_ms + 10
    acc, gyro = ffi.new("Axis3fSubSampler_t *"), ffi.new("Axis3fSubSampler_t *")
    lib.axis3fSubSamplerInit(acc, 9.81)
    lib.axis3fSubSamplerInit(gyro, np.pi / 180.0)
    lib.kalmanCoreInit(core, params, now_ms)
    state, zero = ffi.new("state_t *"), ffi.new("Axis3f *")

    track = []
    while waiting:
        if now_ms > next_prediction:
            means = lib.axis3fSubSamplerFinalize(acc), lib.axis3fSubSamplerFinalize(gyro)
            lib.kalmanCorePredict(core, params, *means, now_ms, True)
            next_prediction += 10
        lib.kalmanCoreAddProcessNoise(core, params, now_ms)
        while waiting:
            time_ms, kind, data = waiting.popleft()
            if time_ms > now_ms:
                break  # and this sample is lost, as in the original loop
            if kind == "tdoa":
                update(core, data, now_ms)
            else:
                lib.axis3fSubSamplerAccumulate({"acc": acc, "gyro": gyro}[kind], data)
        lib.kalmanCoreFinalize(core)
        now_ms += 1
        lib.kalmanCoreExternalizeState(core, state, zero)
        track.append((now_ms, state.position.x, state.position.y, state.position.z))
    return np.array(track)


@pytest.fixture
def standard(params):
    outlier_filter = ffi.new("OutlierFilterTdoaState_t *")
    lib.outlierFilterTdoaReset(outlier_filter)
    core = ffi.new("kalmanCoreData_t *")
    return replay(params, core, lambda c, tdoa, ms: lib.kalmanCoreUpdateWithTdoa(c, tdoa, ms, outlier_filter))


@pytest.fixture
def robust(params):
    x_err, unused = ffi.new("float[9]"), ffi.new("OutlierFilterTdoaState_t *")
    core = ffi.new("kalmanCoreData_t *")
    return replay(params, core, lambda c, tdoa, ms: lib.kalmanCoreRobustUpdateWithTdoa(c, tdoa, unused, x_err))


@pytest.fixture
def default(params):
    """Return the track of the provider's filter as it boots."""
    kalman = ffi.new("cf_kalman_t *")
    lib.cf_kalman_boot(kalman, 0)
    item, gyro = ffi.new("measurement_t *", {"type": lib.MeasurementTypeTDOA}), ffi.new("Axis3f *")

    def update(core: ffi.CData, tdoa: ffi.CData, now_ms: int) -> None:
        item.data.tdoa = tdoa[0]
        lib.cf_kalman_update(kalman, item, gyro, now_ms)

    return replay(params, ffi.addressof(kalman, "core"), update)


@pytest.mark.parametrize("model", ["standard", "robust"])
def test_the_estimate_finds_the_tag(model, request):
    track = request.getfixturevalue(model)
    assert len(track) > 4000
    assert np.all(np.diff(track[:, 0]) > 0)
    assert np.linalg.norm(track[-1, 1:] - TAG) < 0.5


def test_the_models_differ_and_the_default_is_the_standard_one(standard, robust, default):
    assert not np.array_equal(standard, robust)
    np.testing.assert_array_equal(default, standard)
