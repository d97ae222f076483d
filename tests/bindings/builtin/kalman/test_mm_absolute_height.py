"""Height above the floor (docs/reference/estimators.md#5.1, #16.4 and #17.H)."""

from crazychoir_fw._core import ffi, lib


def test_check_vector_h(helpers):
    core = helpers.single_update_core()
    lib.kalmanCoreUpdateWithAbsoluteHeight(core, ffi.new("heightMeasurement_t *", {"height": 1.25, "stdDev": 0.05}))
    expected = helpers.SingleUpdate((0.5, -0.3, 1.24444449, 0.0), (0.04, 0.03, 0.00222222251, 1e-3), (0.0, 0.002))
    expected.assert_same_as(core)


def test_height_is_one_scalar_update_of_z(helpers):
    """H is 1 at z, the innovation measured minus estimated, the deviation that of the measurement.

    docs/reference/estimators.md#16.4.
    """
    core, twin = helpers.random_core(0), helpers.random_core(0)
    core.S[2] = twin.S[2] = 0.5
    lib.kalmanCoreUpdateWithAbsoluteHeight(core, ffi.new("heightMeasurement_t *", {"height": 1.25, "stdDev": 0.25}))
    lib.kalmanCoreScalarUpdate(twin, [0, 0, 1, 0, 0, 0, 0, 0, 0], 0.75, 0.25)
    assert ffi.buffer(core)[:] == ffi.buffer(twin)[:]
