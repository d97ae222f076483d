"""Gain sets and gains of one's own."""

import math

import pytest

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.control import (
    ATTITUDE_GAINS,
    POSITION_GAINS,
    VELOCITY_GAINS,
    AttitudeGains,
    FlatnessPositionCtrl,
    GeometryAttitudeCtrl,
    PositionGains,
    VelocityGains,
)


def test_every_law_has_the_same_sets():
    assert list(POSITION_GAINS) == list(ATTITUDE_GAINS) == list(VELOCITY_GAINS) == ["webots", "vicon", "mujoco"]


def test_vicon_is_short_for_its_set_and_a_name_wins():
    assert FlatnessPositionCtrl(vicon=True).gains is POSITION_GAINS["vicon"]
    assert FlatnessPositionCtrl().gains is POSITION_GAINS["webots"]
    assert GeometryAttitudeCtrl(vicon=True, gains="mujoco").gains is ATTITUDE_GAINS["mujoco"]


def test_one_number_stands_for_three():
    assert AttitudeGains(k_r=5, k_w=0.5) == AttitudeGains((5.0, 5.0, 5.0), (0.5, 0.5, 0.5))


@pytest.mark.parametrize(
    ("kind", "arguments", "message"),
    [
        (PositionGains, {"k_p": (1.0, 2.0), "k_v": 1.0}, "PositionGains: k_p is .*three finite numbers, not below 0"),
        (PositionGains, {"k_p": 1.0, "k_v": -1.0}, "k_v is -1.0"),
        (PositionGains, {"k_p": 1.0, "k_v": 1.0, "least_lift": 0.0}, "least_lift is 0.0, allowed: 0.001 to 1"),
        (PositionGains, {"k_p": 1.0, "k_v": 1.0, "max_tilt": math.nan}, "max_tilt is nan, allowed: above 0"),
        (AttitudeGains, {"k_r": "fast", "k_w": 0.0}, "AttitudeGains: k_r is fast"),
        (VelocityGains, {"k_p": 1.0, "k_v": 0.0, "feed_forward": 2.0}, "feed_forward is 2.0, allowed: 0 to 1"),
    ],
)
def test_impossible_gains_are_refused(kind, arguments, message):
    with pytest.raises(RangeError, match=message):
        kind(**arguments)


def test_gains_of_another_law_are_refused():
    with pytest.raises(RangeError, match="gains is AttitudeGains, allowed: webots, vicon, mujoco or PositionGains"):
        FlatnessPositionCtrl(gains=ATTITUDE_GAINS["webots"])
