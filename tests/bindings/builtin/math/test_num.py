"""Number helpers: the numbers of the upstream tests and NumPy's half precision.

docs/reference/control-pid.md#8, #18.
"""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crazychoir_fw._core import lib

F = np.float32


@pytest.mark.parametrize(
    ("value", "limited"),
    [(4711, 4711), (-100, 0), (65635, 65535), (65535, 65535), (65536, 65535), (2**31 - 1, 65535), (-(2**31), 0)],
)
def test_limit_uint16(value, limited):
    assert lib.limitUint16(value) == limited


@pytest.mark.parametrize(
    ("value", "low", "high", "limited"),
    [(3.45, 0, 100, 3.45), (-10, 3.45, 100, 3.45), (10, -100, 3.45, 3.45)],
)
def test_constrain(value, low, high, limited):
    assert lib.constrain(value, low, high) == F(limited)


def test_constrain_lets_nan_through():
    assert math.isnan(lib.constrain(math.nan, -1.0, 1.0))


@pytest.mark.parametrize(("value", "expected"), [(0.5, 0.0), (-0.5, 0.0), (2.5, 1.5), (-2.5, -1.5), (1.0, 0.0)])
def test_deadband_of_one(value, expected):
    assert lib.deadband(value, 1.0) == expected


def test_deadband_lets_nan_through():
    assert math.isnan(lib.deadband(math.nan, 1.0))


# exactly representable in half precision: nothing to round, so the two formats must agree
@given(mantissa=st.integers(0, 1023), exponent=st.integers(1, 30), negative=st.booleans())
def test_halves_survive_the_round_trip(mantissa, exponent, negative):
    half = int(negative) << 15 | exponent << 10 | mantissa
    assert lib.half2single(half) == float(np.uint16(half).view(np.float16))
    assert lib.single2half(lib.half2single(half)) == half


@given(number=st.floats(2.0**-14, 65000, width=32), negative=st.booleans())
def test_rounding_is_that_of_the_twelfth_bit(number, negative):
    bits = int(F(number).view(np.uint32))
    mantissa = (bits >> 13 & 0x3FF) + (bits >> 12 & 1)
    expected = (int(negative) << 15) | ((bits >> 23) - 112) << 10 | mantissa
    assert lib.single2half(-number if negative else number) == expected


def test_a_mantissa_that_rounds_up_is_ored_into_the_exponent():
    # just below 2 (exponent field 15, odd): the carry is lost; just below 4 (16, even): it arrives
    below = [float(np.nextafter(F(limit), F(0))) for limit in (2.0, 4.0)]
    assert [lib.single2half(number) for number in below] == [15 << 10, 17 << 10]


@pytest.mark.parametrize(
    ("number", "half"),
    [
        (math.nan, 0x7E00),
        (math.inf, 0x7C00),
        (-math.inf, 0xFC00),
        (65536.0, 0x7C00),
        (-65536.0, 0xFC00),
        (2.0**-16, 0x0000),
        (-(2.0**-16), 0x0000),
        (2.0**-15, 0x0000),
        (1.5 * 2.0**-15, 0x0200),
        (0.0, 0x0000),
    ],
)
def test_single_to_half_at_the_borders(number, half):
    assert lib.single2half(number) == half


@pytest.mark.parametrize(
    ("half", "bits"),
    [(0x7C00, 0x7F800000), (0xFC00, 0xFF800000), (0x0001, 0x00002000), (0x83FF, 0x807FE000), (0x8000, 0x80000000)],
)
def test_half_to_single_at_the_borders(half, bits):
    assert F(lib.half2single(half)).view(np.uint32) == bits


@pytest.mark.parametrize("half", [0x7C01, 0x7E00, 0xFFFF])
def test_half_nan_becomes_nan(half):
    assert math.isnan(lib.half2single(half))
