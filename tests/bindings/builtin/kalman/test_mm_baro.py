"""Barometer (docs/reference/estimators.md#5.3 and #17.H)."""

import numpy as np
import pytest

from crazychoir_fw._core import lib

Z_VARIANCE = 0.019900497


@pytest.mark.parametrize(
    ("asl", "reference", "z", "new_reference"), [(101.5, 100.0, 1.20149255, 100.0), (0.9, 0.5, 1.19402993, 0.9)]
)
def test_check_vector_h(helpers, params, asl, reference, z, new_reference):
    core = helpers.single_update_core()
    core.baroReferenceHeight = reference
    lib.kalmanCoreUpdateWithBaro(core, params, asl, True)
    helpers.SingleUpdate((0.5, -0.3, z, 0.0), (0.04, 0.03, Z_VARIANCE, 1e-3), (0.0, 0.002)).assert_same_as(core)
    assert core.baroReferenceHeight == np.float32(new_reference)


def test_on_the_ground_here_is_zero(helpers, params):
    core = helpers.single_update_core()
    core.baroReferenceHeight = 100.0
    lib.kalmanCoreUpdateWithBaro(core, params, 300.0, False)
    assert core.baroReferenceHeight == 300.0
    # measured 0, estimated 1.2: the same pull as in the second check vector
    assert core.S[2] == pytest.approx(1.19402993, rel=1e-6)


def test_noise_is_a_parameter(helpers, params):
    core = helpers.single_update_core()
    params.measNoiseBaro = 0.1
    core.baroReferenceHeight = 100.0
    lib.kalmanCoreUpdateWithBaro(core, params, 101.5, True)
    assert core.P[2][2] == pytest.approx(0.02 * 0.01 / 0.03, rel=1e-5)
