"""Position measurements (docs/reference/estimators.md#5.2 and #17.B)."""

import numpy as np
import pytest

from crazychoir_fw._core import ffi, lib

F = np.float32


def test_check_vector_b(flight, helpers):
    core = flight.after("B")
    state = [0.999998987, 1.99999797, 2.99970007, 9.99999e-9, 1.999998e-8, 2.99969997e-6, 0, 0, 0]
    variances = [
        *(9.99998956e-5, 9.99998956e-5, 9.99900003e-5),
        *(1.25962353e-4, 1.25962353e-4, 1.99999995e-4),
        *(1.00999998e-4, 1.00999998e-4, 1.00999998e-4),
    ]
    np.testing.assert_allclose(helpers.array(core.S), state, rtol=1e-6)
    np.testing.assert_allclose(helpers.array(core.P).diagonal(), variances, rtol=1e-6)


@pytest.mark.parametrize("seed", range(10))
def test_position_is_three_updates_each_seeing_the_one_before(helpers, seed):
    rng = np.random.default_rng(seed)
    core = helpers.random_core(seed)
    twin = helpers.DenseFilter.of(core)
    position = rng.normal(size=3).astype(F)

    measurement = ffi.new("positionMeasurement_t *", {"pos": position.tolist(), "stdDev": 0.03})
    lib.kalmanCoreUpdateWithPosition(core, measurement)
    for i in range(3):
        H = np.zeros(9, F)
        H[i] = 1.0
        twin.scalar_update(H, position[i] - twin.S[i], F(0.03))
    twin.assert_same_as(core)
