"""Life of the filter without measurements: parameters, start, prediction, noise, finalize, output."""

import dataclasses
import math

import numpy as np
import pytest

from crazychoir_fw._core import ffi, lib

F = np.float32
DIAGONAL = np.diag_indices(9)

# docs/reference/estimators.md#3.3
DEFAULTS = {
    "stdDevInitialPosition_xy": 100.0,
    "stdDevInitialPosition_z": 1.0,
    "stdDevInitialVelocity": 0.01,
    "stdDevInitialAttitude_rollpitch": 0.01,
    "stdDevInitialAttitude_yaw": 0.01,
    "procNoiseAcc_xy": 0.5,
    "procNoiseAcc_z": 1.0,
    "procNoiseVel": 0.0,
    "procNoisePos": 0.0,
    "procNoiseAtt": 0.0,
    "measNoiseBaro": 2.0,
    "measNoiseGyro_rollpitch": 0.1,
    "measNoiseGyro_yaw": 0.1,
    "initialX": 0.0,
    "initialY": 0.0,
    "initialZ": 0.0,
    "initialYaw": 0.0,
    "attitudeReversion": 0.001,
    "dragB_x": 0.0,
    "dragB_y": 0.0,
    "dragB_z": 0.0,
    "cop_x": 0.0,
    "cop_y": 0.0,
    "cop_z": 0.0,
}


def test_parameters_have_the_fields_of_the_firmware_in_its_order():
    assert [name for name, _ in ffi.typeof("kalmanCoreParams_t").fields] == list(DEFAULTS)


@pytest.mark.parametrize(("name", "value"), DEFAULTS.items())
def test_default_parameter(params, name, value):
    assert getattr(params, name) == F(value)


def test_init_starts_at_the_initial_pose_with_a_diagonal_covariance(params, helpers):
    params.initialX, params.initialY, params.initialZ, params.initialYaw = 1.5, -2.5, 0.25, math.pi / 2
    core = ffi.new("kalmanCoreData_t *")
    ffi.buffer(core)[:] = b"\xff" * ffi.sizeof("kalmanCoreData_t")
    lib.kalmanCoreInit(core, params, 1234)

    np.testing.assert_array_equal(helpers.array(core.S), np.array([1.5, -2.5, 0.25, 0, 0, 0, 0, 0, 0], np.float32))
    np.testing.assert_allclose(helpers.array(core.q), [math.sqrt(0.5), 0, 0, math.sqrt(0.5)], atol=2e-5)
    np.testing.assert_array_equal(helpers.array(core.initialQuaternion), helpers.array(core.q))
    np.testing.assert_array_equal(helpers.array(core.R), np.eye(3, dtype=np.float32))
    std_dev = np.array([100, 100, 1, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01], np.float32)
    np.testing.assert_array_equal(helpers.array(core.P), np.diag(std_dev * std_dev))
    assert (core.lastPredictionMs, core.lastProcessNoiseUpdateMs, core.isUpdated) == (1234, 1234, False)


# docs/reference/estimators.md#17: S, q (w, x, y, z) and the diagonal of P after the step
CHECK_VECTORS = {
    "A": (
        [0, 0, 0, 0, 0, 0, 0, 0, 0],
        [0.999999046, 0, 0, 0],
        [100, 100, 1, 1.25962353e-4, 1.25962353e-4, 1.99999995e-4, 1.00999998e-4, 1.00999998e-4, 1.00999998e-4],
    ),
    "C": (
        [0.999998987, 1.99999797, 2.99972463, 1.60594e-8, 2.29697e-8, 0.00490318798, 0, 0, 0],
        [0.999997258, 0.000499991933, -0.000999983866, 0.00149997568],
        [
            *(1.00014993e-4, 1.00014993e-4, 1.00019999e-4),
            *(1.53860994e-4, 1.53860397e-4, 3.00000625e-4),
            *(1.02000005e-4, 1.01999998e-4, 1.02000005e-4),
        ],
    ),
}


@pytest.mark.parametrize("step", CHECK_VECTORS)
def test_prediction_check_vector(flight, helpers, step):
    state, q, variances = CHECK_VECTORS[step]
    core = flight.after(step)
    np.testing.assert_allclose(helpers.array(core.S), state, rtol=1e-6, atol=1e-13)
    np.testing.assert_allclose(helpers.array(core.q), q, rtol=1e-6, atol=0)
    np.testing.assert_allclose(helpers.array(core.P)[DIAGONAL], variances, rtol=1e-6)


def test_rotation_matrix_check_vector(flight, helpers):
    expected = [
        [0.99999148, -0.00300094, -0.00199846],
        [0.00299894, 0.99999303, -0.00100298],
        [0.00200146, 0.00099698, 0.99999553],
    ]
    np.testing.assert_allclose(helpers.array(flight.after("C").R), expected, atol=6e-9)


@pytest.mark.parametrize("is_flying", [False, True])
@pytest.mark.parametrize("seed", range(25))
def test_prediction_equals_dense_products(params, helpers, seed, is_flying):
    rng = np.random.default_rng(1000 + seed)
    core = helpers.random_core(seed)
    twin = helpers.DenseFilter.of(core)
    acc, gyro = rng.normal(size=(2, 3)).astype(np.float32) * np.array([[12.0], [4.0]], np.float32)
    dt_ms = int(rng.integers(0, 30))

    lib.kalmanCorePredict(core, params, helpers.axis3f(*acc), helpers.axis3f(*gyro), 1000 + dt_ms, is_flying)
    twin.predict(acc, gyro, F(dt_ms) / F(1000.0), is_flying)

    twin.assert_same_as(core)
    assert core.isUpdated
    assert core.lastPredictionMs == 1000 + dt_ms


@pytest.mark.parametrize("seed", range(25))
def test_a_flight_equals_its_dense_twin(params, helpers, seed):
    """Everything in turn, so that no shortcut holds only for what the test before prepared."""
    rng = np.random.default_rng(2000 + seed)
    core = helpers.random_core(seed)
    twin = helpers.DenseFilter.of(core)
    zero = np.zeros(9, np.float32)
    now_ms = 1000
    for _ in range(60):
        action = rng.choice(["predict", "noise", "noise", "noise", "single", "several", "finalize"])
        if action == "predict":
            acc, gyro = rng.normal(size=(2, 3)).astype(np.float32)
            dt = F((now_ms - core.lastPredictionMs) % 2**32) / F(1000.0)
            lib.kalmanCorePredict(core, params, helpers.axis3f(*acc), helpers.axis3f(*gyro), now_ms, True)
            twin.predict(acc, gyro, dt, True)
        elif action == "noise":
            now_ms += 1
            lib.kalmanCoreAddProcessNoise(core, params, now_ms)
            twin.add_process_noise(F(0.001))
        elif action == "finalize":
            was_updated = core.isUpdated
            assert lib.kalmanCoreFinalize(core) == was_updated
            if was_updated:
                twin.finalize()
        else:
            H = zero.copy()
            where = rng.choice(9, size=1 if action == "single" else 3, replace=False)
            H[where] = rng.normal(size=len(where))
            error, std_dev = F(rng.normal() * 0.1), F(10.0 ** rng.uniform(-3, 1))
            lib.kalmanCoreScalarUpdate(core, H.tolist(), error, std_dev)
            twin.scalar_update(H, error, std_dev)
        twin.assert_same_as(core)


@pytest.mark.parametrize("seed", range(10))
def test_remembering_that_the_covariance_is_settled_changes_no_bit(params, helpers, seed):
    """One filter forgets before each call that P was bounded; entries near the smallest floats are the hard case."""
    rng = np.random.default_rng(3000 + seed)
    core = helpers.random_core(seed)
    P = helpers.array(core.P)
    tiny = rng.integers(1, 2**25, size=(9, 9)) * 2.0**-149
    off_diagonal = ~np.eye(9, dtype=bool)
    P[off_diagonal] = np.where(rng.random((9, 9)) < 0.5, tiny, P)[off_diagonal]
    helpers.assign(core.P, P)
    forgetful = ffi.new("kalmanCoreData_t *", core[0])

    H = [0.0] * 9
    for now_ms in range(1001, 1066):
        for each in (core, forgetful):
            forgetful.settled = 0
            lib.kalmanCoreAddProcessNoise(each, params, now_ms)
            if now_ms % 10 == 0:
                forgetful.settled = 0
                H[now_ms // 10 % 9] = 1.0
                lib.kalmanCoreScalarUpdate(each, H, 0.01, 0.1)
            forgetful.settled = 0
            lib.kalmanCoreFinalize(each)
        assert ffi.buffer(core.P)[:] == ffi.buffer(forgetful.P)[:]
    assert core.settled == 2


def test_prediction_leaves_the_rotation_matrix_alone(params, helpers):
    core = helpers.random_core(0)
    before = helpers.array(core.R)
    lib.kalmanCorePredict(core, params, helpers.axis3f(0, 0, 9.81), helpers.axis3f(3, 2, 1), 1010, True)
    np.testing.assert_array_equal(helpers.array(core.R), before)


def test_on_the_ground_the_attitude_returns_to_where_it_started(params, helpers):
    core = ffi.new("kalmanCoreData_t *")
    lib.kalmanCoreInit(core, params, 0)
    helpers.assign(core.q, np.array([math.cos(0.15), 0, 0, math.sin(0.15)]))
    for now_ms in range(10, 10001, 10):
        lib.kalmanCorePredict(core, params, helpers.axis3f(0, 0, 9.81), helpers.axis3f(0, 0, 0), now_ms, False)
    # the time constant is 10 s
    assert 2.0 * math.asin(core.q[3]) == pytest.approx(0.3 * math.exp(-1.0), rel=0.01)


def test_in_flight_the_attitude_stays(params, helpers):
    core = ffi.new("kalmanCoreData_t *")
    lib.kalmanCoreInit(core, params, 0)
    helpers.assign(core.q, np.array([math.cos(0.15), 0, 0, math.sin(0.15)]))
    for now_ms in range(10, 10001, 10):
        lib.kalmanCorePredict(core, params, helpers.axis3f(0, 0, 9.81), helpers.axis3f(0, 0, 0), now_ms, True)
    assert 2.0 * math.asin(core.q[3]) == pytest.approx(0.3, rel=1e-4)


def test_drag_slows_the_velocity_and_its_variance(params, helpers):
    still = helpers.random_core(0)
    dragged = ffi.new("kalmanCoreData_t *", still[0])
    lib.kalmanCorePredict(still, params, helpers.axis3f(0, 0, 9.81), helpers.axis3f(0, 0, 0), 1010, True)
    params.dragB_x = 2.0
    lib.kalmanCorePredict(dragged, params, helpers.axis3f(0, 0, 9.81), helpers.axis3f(0, 0, 0), 1010, True)
    before = helpers.random_core(0).S[3]
    assert dragged.S[3] - still.S[3] == pytest.approx(-0.01 * 2.0 * before, rel=1e-4)
    assert dragged.P[3][3] < still.P[3][3]


@pytest.mark.parametrize("is_flying", [False, True])
def test_drag_of_a_place_beside_the_center_brakes_the_turn_as_well(params, helpers, is_flying):
    """-B p - B (w x c), in flight alone; the transition has the drag in any case.

    docs/reference/estimators.md#4.4.6.
    """
    dt, drag, place, gyro = 0.01, np.array([1.0, 2.0, 3.0]), np.array([0.1, -0.2, 0.3]), np.array([0.5, -1.0, 2.0])
    acc = helpers.axis3f(0, 0, 9.81)
    plain, braked = (ffi.new("kalmanCoreData_t *", helpers.random_core(7)[0]) for _ in range(2))
    lib.kalmanCorePredict(plain, params, acc, helpers.axis3f(*gyro), 1010, is_flying)
    params.dragB_x, params.dragB_y, params.dragB_z = drag
    params.cop_x, params.cop_y, params.cop_z = place
    lib.kalmanCorePredict(braked, params, acc, helpers.axis3f(*gyro), 1010, is_flying)

    velocity = helpers.array(helpers.random_core(7).S)[3:6].astype(float)
    expected = -dt * drag * (velocity + np.cross(gyro, place)) if is_flying else np.zeros(3)
    change = helpers.array(braked.S) - helpers.array(plain.S)
    np.testing.assert_allclose(change, [0, 0, 0, *expected, 0, 0, 0], atol=1e-6)
    assert not np.array_equal(helpers.array(braked.P), helpers.array(plain.P))


def test_noise_of_velocity_position_and_attitude_adds_before_squaring(params, helpers):
    """docs/reference/estimators.md#4.5, with the parameters that are zero by default."""
    params.procNoiseVel, params.procNoisePos, params.procNoiseAtt = 0.25, 0.125, 0.5
    params.measNoiseGyro_yaw = 0.75
    core = ffi.new("kalmanCoreData_t *")
    helpers.assign(core.P, np.eye(9))
    lib.kalmanCoreAddProcessNoise(core, params, 500)
    dt, xy, z = 0.5, 0.5, 1.0
    plane, height = xy * dt * dt + 0.25 * dt + 0.125, z * dt * dt + 0.25 * dt + 0.125
    added = [plane, plane, height, xy * dt + 0.25, xy * dt + 0.25, z * dt + 0.25]
    added += [0.1 * dt + 0.5, 0.1 * dt + 0.5, 0.75 * dt + 0.5]
    np.testing.assert_allclose(helpers.array(core.P), np.eye(9) + np.diag(np.square(added)), rtol=1e-6)


def test_ten_short_steps_add_a_tenth_of_the_noise_of_a_long_one(params, helpers):
    """docs/reference/estimators.md#4.5: the rate of the calls is part of the tuning."""
    many, one = ffi.new("kalmanCoreData_t *"), ffi.new("kalmanCoreData_t *")
    for core in (many, one):
        helpers.assign(core.P, 1e-3 * np.eye(9))
    for now_ms in range(1, 11):
        lib.kalmanCoreAddProcessNoise(many, params, now_ms)
    lib.kalmanCoreAddProcessNoise(one, params, 10)
    added = [helpers.array(core.P)[DIAGONAL][3:] - F(1e-3) for core in (many, one)]
    np.testing.assert_allclose(10.0 * added[0], added[1], rtol=0.01)


def test_noise_without_time_does_nothing(params, helpers):
    core = helpers.random_core(1)
    core.P[2][2] = 1e6
    before = ffi.buffer(core)[:]
    lib.kalmanCoreAddProcessNoise(core, params, 1000)
    assert ffi.buffer(core)[:] == before


def test_noise_does_not_ask_for_finalize(params, helpers):
    core = helpers.random_core(1)
    core.isUpdated = False
    lib.kalmanCoreAddProcessNoise(core, params, 1001)
    assert not core.isUpdated
    assert core.lastProcessNoiseUpdateMs == 1001


@dataclasses.dataclass
class Entry:
    """A covariance entry and its mirror before bounding, and both after."""

    row: int
    column: int
    value: float
    mirror: float
    bounded: float


@pytest.mark.parametrize(
    "entry",
    [
        Entry(0, 5, math.nan, 0.5, 100.0),
        Entry(8, 3, 0.5, math.nan, 100.0),
        Entry(1, 2, 250.0, 0.0, 100.0),
        Entry(1, 2, 150.0, 0.0, 75.0),
        Entry(4, 8, -1e9, -1e9, -1e9),
        Entry(4, 7, math.inf, 0.0, 100.0),
        Entry(4, 7, -math.inf, 0.0, -math.inf),
        Entry(4, 4, math.nan, math.nan, 100.0),
        Entry(0, 0, 10000.0, 10000.0, 100.0),
        Entry(8, 8, -3.0, -3.0, 1e-6),
        Entry(3, 3, 0.0, 0.0, 1e-6),
        Entry(2, 6, 1e-9, 3e-9, 2e-9),
    ],
)
def test_covariance_is_made_symmetric_and_bounded(helpers, entry):
    core = helpers.random_core(2)
    helpers.assign(core.S, np.zeros(9))
    core.P[entry.row][entry.column] = entry.value
    core.P[entry.column][entry.row] = entry.mirror
    assert lib.kalmanCoreFinalize(core)
    assert core.P[entry.row][entry.column] == F(entry.bounded)
    assert core.P[entry.column][entry.row] == F(entry.bounded)


def test_finalize_without_news_does_nothing(helpers):
    core = helpers.random_core(4)
    core.isUpdated = False
    before = ffi.buffer(core)[:]
    assert not lib.kalmanCoreFinalize(core)
    assert ffi.buffer(core)[:] == before


@pytest.mark.parametrize(
    "error",
    [(1e-4, -1e-4, 1e-4), (0.0, 0.0, 0.0), (10.0, 0.0, 0.0), (0.1, 0.1, -11.0), (math.nan, 0.0, 0.0)],
)
def test_attitude_errors_too_small_or_too_large_are_thrown_away(helpers, error):
    core = helpers.random_core(5)
    helpers.assign(core.S, np.array([0, 0, 0, 0, 0, 0, *error]))
    q, P = helpers.array(core.q), helpers.array(core.P)
    assert lib.kalmanCoreFinalize(core)
    np.testing.assert_array_equal(helpers.array(core.q), q)
    np.testing.assert_array_equal(helpers.array(core.P), P)
    assert list(core.S)[6:9] == [0.0, 0.0, 0.0]


def test_finalize_turns_the_attitude_by_the_error_in_the_body_frame(helpers):
    core = helpers.random_core(0)
    half = math.sqrt(0.5)
    helpers.assign(core.q, np.array([half, 0, 0, half]))
    helpers.assign(core.S, np.array([0, 0, 0, 0, 0, 0, 0.1, 0, 0]))
    assert lib.kalmanCoreFinalize(core)
    expected = half * np.array([math.cos(0.05), math.sin(0.05), math.sin(0.05), math.cos(0.05)])
    np.testing.assert_allclose(helpers.array(core.q), expected, atol=2e-6)


@pytest.mark.parametrize("seed", range(10))
def test_externalized_state_matches_the_conventions(helpers, seed):
    core = helpers.random_core(seed)
    state = ffi.new("state_t *")
    acc = np.array([0.1, -0.2, 1.05], np.float32)
    lib.kalmanCoreExternalizeState(core, state, helpers.axis3f(*acc))

    S, q, R = (helpers.array(x).astype(float) for x in (core.S, core.q, core.R))
    np.testing.assert_array_equal([state.position.x, state.position.y, state.position.z], S[:3])
    np.testing.assert_allclose([state.velocity.x, state.velocity.y, state.velocity.z], R @ S[3:6], atol=1e-6)
    np.testing.assert_allclose([state.acc.x, state.acc.y, state.acc.z], R @ acc - [0, 0, 1], atol=1e-6)
    quaternion = state.attitudeQuaternion
    np.testing.assert_array_equal([quaternion.w, quaternion.x, quaternion.y, quaternion.z], q)

    roll, pitch, yaw = (math.radians(x) for x in (state.attitude.roll, -state.attitude.pitch, state.attitude.yaw))
    # R = Rz(yaw) Ry(pitch) Rx(roll): its last row and first column
    expected = [-math.sin(pitch), math.cos(pitch) * math.sin(roll), math.cos(pitch) * math.cos(roll)]
    np.testing.assert_allclose(R[2], expected, atol=1e-5)
    np.testing.assert_allclose(R[:2, 0], math.cos(pitch) * np.array([math.cos(yaw), math.sin(yaw)]), atol=1e-5)
    timestamps = (state.position.timestamp, state.velocity.timestamp, state.acc.timestamp, state.attitude.timestamp)
    assert timestamps == (0, 0, 0, 0)


def test_decoupling_forgets_x_y_and_their_velocities(helpers):
    core = helpers.random_core(6)
    before, state = helpers.array(core.P), helpers.array(core.S)
    lib.kalmanCoreDecoupleXY(core)
    P, kept = helpers.array(core.P), [2, 5, 6, 7, 8]
    np.testing.assert_array_equal(P[np.ix_(kept, kept)], before[np.ix_(kept, kept)])
    np.testing.assert_array_equal(helpers.array(core.S)[kept], state[kept])
    for i in (0, 1, 3, 4):
        expected = np.zeros(9)
        expected[i] = 100.0
        np.testing.assert_array_equal(P[i], expected)
        np.testing.assert_array_equal(P[:, i], expected)
        assert core.S[i] == 0.0
