"""Pose measurements (docs/reference/estimators.md#5.8, #16.8 and #17.F and #17.G)."""

import math

import numpy as np
import pytest

from crazychoir_fw._core import ffi, lib

F = np.float32
HALF_TURN_SINE = math.sqrt(0.5)


def pose_measurement(position, quat_wxyz, std_position: float, std_attitude: float) -> ffi.CData:
    pose = ffi.new(
        "poseMeasurement_t *",
        {"pos": [float(x) for x in position], "stdDevPos": std_position, "stdDevQuat": std_attitude},
    )
    pose.quat.w, pose.quat.x, pose.quat.y, pose.quat.z = (float(x) for x in quat_wxyz)
    return pose


def test_check_vector_f(flight, helpers):
    core = flight.after("F")
    state = [1.00499833, 1.99499571, 3.0106504, -7.15687522e-4, -1.0864319e-3, 0.00512304669, 0, 0, 0]
    variances = [
        *(5.00037313e-5, 5.00037313e-5, 4.90244056e-5),
        *(1.50657739e-4, 1.50657143e-4, 2.99980224e-4),
        *(1.68956922e-5, 1.6895694e-5, 1.68957049e-5),
    ]
    np.testing.assert_allclose(helpers.array(core.S), state, rtol=1e-6)
    np.testing.assert_allclose(
        helpers.array(core.q), [0.999961317, 0.00258839433, -0.00350068044, 0.00750751887], rtol=1e-6
    )
    np.testing.assert_allclose(helpers.array(core.P).diagonal(), variances, rtol=1e-6)


@pytest.fixture
def facing_left(params, helpers):
    """Return a filter that starts with a yaw of 90 deg."""
    core = ffi.new("kalmanCoreData_t *")
    lib.kalmanCoreInit(core, params, 0)
    helpers.assign(core.q, np.array([HALF_TURN_SINE, 0, 0, HALF_TURN_SINE]))
    core.isUpdated = True
    assert lib.kalmanCoreFinalize(core)
    return core


def test_check_vector_g_the_residual_lives_in_the_body_frame(facing_left, helpers):
    core = facing_left
    quat = HALF_TURN_SINE * np.array([math.cos(0.05), math.sin(0.05), math.sin(0.05), math.cos(0.05)])
    lib.kalmanCoreUpdateWithPose(core, pose_measurement([0, 0, 0], quat, 0.01, 0.01))
    np.testing.assert_allclose(list(core.S)[6:9], [0.05004171, 0, 0], rtol=1e-6, atol=1e-7)

    lib.kalmanCoreFinalize(core)
    np.testing.assert_allclose(helpers.array(core.q), [0.706884742, 0.0176905468, 0.0176905468, 0.706884742], rtol=1e-6)
    variances = [core.P[i][i] for i in (6, 7, 8)]
    np.testing.assert_allclose(variances, [4.99999987e-5, 5.00000024e-5, 5.00000024e-5], rtol=1e-6)


# docs/reference/estimators.md#17.F and #17.G: the innovations of the attitude; #16.8: a quarter turn about body x seen
# after one about z
@pytest.mark.parametrize(
    ("q", "quat", "error"),
    [
        (
            (HALF_TURN_SINE, 0, 0, HALF_TURN_SINE),
            tuple(HALF_TURN_SINE * x for x in (math.cos(0.05), math.sin(0.05), math.sin(0.05), math.cos(0.05))),
            (0.10008342, 0, 0),
        ),
        (
            (0.999997258, 0.000499991933, -0.000999983866, 0.00149997568),
            (0.99995, 0.003, -0.004, 0.0087),
            (0.005005622, -0.006000616, 0.014398643),
        ),
        ((HALF_TURN_SINE, 0, 0, HALF_TURN_SINE), (0.5, 0.5, 0.5, 0.5), (2.0, 0, 0)),
    ],
)
def test_attitude_innovation(helpers, q, quat, error):
    core = ffi.new("kalmanCoreData_t *")
    helpers.assign(core.q, np.array(q))
    helpers.assign(core.P, np.eye(9))
    lib.kalmanCoreUpdateWithPose(core, pose_measurement([0, 0, 0], quat, 1.0, 1.0))
    # prior and measurement weigh the same: half of the innovation is applied
    np.testing.assert_allclose(2.0 * np.array(list(core.S)[6:9]), error, rtol=2e-5, atol=2e-7)


@pytest.mark.parametrize("seed", range(10))
def test_pose_is_six_updates(helpers, seed):
    rng = np.random.default_rng(seed)
    core = helpers.random_core(seed)
    twin = helpers.DenseFilter.of(core)
    position, quat = rng.normal(size=3).astype(F), rng.normal(size=4).astype(F)
    lib.kalmanCoreUpdateWithPose(core, pose_measurement(position, quat, 0.02, 0.005))

    aw, ax, ay, az = twin.q * np.array([1, -1, -1, -1], F)
    bw, bx, by, bz = quat
    x = aw * bx + ax * bw + ay * bz - az * by
    y = aw * by - ax * bz + ay * bw + az * bx
    z = aw * bz + ax * by - ay * bx + az * bw
    w = aw * bw - ax * bx - ay * by - az * bz
    scale = F(2.0) / w
    for i in range(3):
        twin.scalar_update(np.eye(9, dtype=F)[i], position[i] - twin.S[i], F(0.02))
    for i, component in enumerate((x, y, z)):
        twin.scalar_update(np.eye(9, dtype=F)[6 + i], scale * component, F(0.005))
    twin.assert_same_as(core)


def test_the_sign_of_the_measured_quaternion_does_not_matter(helpers):
    first, second = helpers.random_core(3), helpers.random_core(3)
    quat = np.array([0.9, 0.1, -0.2, 0.3], F)
    lib.kalmanCoreUpdateWithPose(first, pose_measurement([1, 2, 3], quat, 0.02, 0.005))
    lib.kalmanCoreUpdateWithPose(second, pose_measurement([1, 2, 3], -quat, 0.02, 0.005))
    assert ffi.buffer(first)[:] == ffi.buffer(second)[:]


def test_half_a_turn_away_the_innovation_is_infinite(helpers):
    """A residual without scalar part is divided by zero, and the estimate shows it.

    docs/reference/estimators.md#5.8.
    """
    core = ffi.new("kalmanCoreData_t *", {"q": [1.0]})
    helpers.assign(core.P, np.eye(9))
    lib.kalmanCoreUpdateWithPose(core, pose_measurement([0, 0, 0], (0, 1, 0, 0), 1.0, 1.0))
    assert not np.isfinite(list(core.S)[6:9]).any()
    assert np.isfinite(helpers.array(core.P)).all()
