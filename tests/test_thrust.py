"""Newtons and counts."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from crazychoir_fw.common.errors import RangeError, UnknownNameError
from crazychoir_fw.onboard.thrust import ThrustCalibration, platform_max_thrust, platform_weight, thrust_counts


@pytest.mark.parametrize(("platform", "newtons"), [("cf2", 0.48), ("cf21bl", 0.8)])
def test_platforms(platform, newtons):
    assert platform_max_thrust(platform) == pytest.approx(newtons)
    calibration = ThrustCalibration(platform)
    assert calibration.max_newtons == pytest.approx(newtons)
    assert calibration.counts(0.5 * newtons) == pytest.approx(32767.5)
    assert calibration.counts(0.1) == pytest.approx(thrust_counts(0.1, newtons))
    assert 0.2 < platform_weight(platform) < 0.5


def test_a_number_is_the_thrust_at_full_command():
    assert ThrustCalibration(0.72).counts(0.36) == pytest.approx(32767.5)


def test_a_curve_of_ones_own():
    curve = ThrustCalibration([(0.0, 5000), (0.1, 20000), (0.3, 40000)])
    assert curve.counts(0.05) == pytest.approx(12500)
    assert curve.counts(0.2) == pytest.approx(30000)
    assert curve.counts(0.4) == pytest.approx(50000)  # on in its last direction
    assert curve.counts(-1.0) == 0
    assert curve.max_newtons == pytest.approx(0.3 + 25535 / 100000)


@pytest.mark.parametrize(
    "word", [0, -1.0, float("nan"), True, None, [(0, 0)], [(0, 0), (1, 0)], [(1, 0), (0, 1)], [1, 2, 3], [(0, "a")]]
)
def test_what_is_no_calibration(word):
    with pytest.raises(RangeError, match="thrust is"):
        ThrustCalibration(word)


def test_an_unknown_platform():
    with pytest.raises(UnknownNameError, match="there is no platform 'cf3', allowed: cf2, cf21bl"):
        ThrustCalibration("cf3")


@given(st.floats(0.0, 0.479))
def test_there_and_back(newtons):
    calibration = ThrustCalibration("cf2")
    assert calibration.newtons(calibration.counts(newtons)) == pytest.approx(newtons, abs=1e-9)
