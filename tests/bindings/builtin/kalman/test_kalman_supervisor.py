"""Limits of position and velocity (docs/reference/estimators.md#7 and #16.6)."""

import math

import pytest

from crazychoir_fw._core import ffi, lib


@pytest.fixture
def limits():
    return ffi.new("cf_kalman_limits_t *", lib.cf_kalman_default_limits())


def with_state(index: int, value: float) -> ffi.CData:
    core = ffi.new("kalmanCoreData_t *")
    core.S[index] = value
    return core


@pytest.mark.parametrize(
    ("index", "value", "is_within"),
    [
        *((lib.KC_STATE_X, 0.0, True), (lib.KC_STATE_X, 200.0, False), (lib.KC_STATE_Z, -200.0, False)),
        *((lib.KC_STATE_PX, 20.0, False), (lib.KC_STATE_PZ, -20.0, False)),
        *((lib.KC_STATE_Y, 100.0, True), (lib.KC_STATE_PY, -10.0, True)),
        *((lib.KC_STATE_Y, 100.00001, False), (lib.KC_STATE_PY, -10.000001, False)),
        *((lib.KC_STATE_D0, 1e6, True), (lib.KC_STATE_X, math.nan, True), (lib.KC_STATE_X, math.inf, False)),
    ],
)
def test_state_against_the_default_limits(limits, index, value, is_within):
    assert lib.cf_kalman_state_is_within(with_state(index, value), limits) == is_within


@pytest.mark.parametrize("off", [0.0, -1.0])
@pytest.mark.parametrize(("index", "field"), [(lib.KC_STATE_Z, "max_position"), (lib.KC_STATE_PX, "max_velocity")])
def test_a_limit_of_zero_or_less_is_off(limits, index, field, off):
    core = with_state(index, 1e9)
    assert not lib.cf_kalman_state_is_within(core, limits)
    setattr(limits, field, off)
    assert lib.cf_kalman_state_is_within(core, limits)
