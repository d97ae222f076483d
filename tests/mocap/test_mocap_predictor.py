"""The Kalman predictor of docs/reference/crazychoir.md#10."""

import numpy as np
import pytest

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.mocap import SingleStagePredictor


def test_steady_gain_of_the_reference():
    predictor = SingleStagePredictor()
    for _ in range(200):
        predictor.step((0.0, 0.0))
    np.testing.assert_allclose(predictor.gain[:2, 0], [1.96256, 97.20096], atol=1e-5)
    np.testing.assert_allclose(predictor.gain[2:, 1], predictor.gain[:2, 0], atol=1e-12)
    np.testing.assert_array_equal(predictor.gain[2:, 0], 0.0)


def test_it_predicts_the_next_sample_of_a_straight_flight():
    predictor = SingleStagePredictor()
    for k in range(100):
        predicted = predictor.step((0.01 * k, -0.02 * k))
    np.testing.assert_allclose(predicted, [1.0, 1.0, -2.0, -2.0], atol=1e-9)


def test_state_and_covariance_may_be_given():
    predictor = SingleStagePredictor(x0=(1.0, 2.0, 3.0, 4.0), PP0=np.zeros((4, 4)))
    # sure of its state: the sample changes nothing yet
    np.testing.assert_allclose(predictor.step((9.0, 9.0)), [1.02, 2.0, 3.04, 4.0])


@pytest.mark.parametrize(
    ("wrong", "word"),
    [
        ({"dt": 0.0}, "dt is 0.0"),
        ({"sigma_m": -1.0}, "sigma_m"),
        ({"x0": (1.0, 2.0)}, "x0"),
        ({"PP0": np.full((4, 4), np.nan)}, "PP0"),
    ],
)
def test_what_is_no_model_is_refused(wrong, word):
    with pytest.raises(RangeError, match=word):
        SingleStagePredictor(**wrong)
    with pytest.raises(RangeError, match="measured"):
        SingleStagePredictor().step((np.nan, 0.0))
