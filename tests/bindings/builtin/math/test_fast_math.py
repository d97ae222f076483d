"""Sine and cosine by table (docs/reference/estimators.md#2)."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crazychoir_fw._core import lib

F = np.float32
TABLE = np.array([round(math.sin(2 * math.pi * k / 512), 8) for k in range(513)], dtype=np.float32)


def interpolated(turns: np.float32) -> float:
    whole = np.trunc(turns) - F(1.0 if turns < 0 else 0.0)
    position = F(512.0) * (turns - whole)
    segment = int(position)
    if segment >= 512:
        segment, position = 0, position - F(512.0)
    part = position - F(segment)
    return float((F(1.0) - part) * TABLE[segment] + part * TABLE[segment + 1])


@given(st.floats(-1e6, 1e6, width=32))
def test_both_functions_interpolate_the_table(x):
    turns = F(x) * F(0.159154943092)
    assert lib.cf_fast_sin(x) == interpolated(turns)
    assert lib.cf_fast_cos(x) == interpolated(turns + F(0.25))


@given(st.floats(-100.0, 100.0, width=32))
def test_the_error_stays_below_that_of_linear_interpolation(x):
    assert lib.cf_fast_sin(x) == pytest.approx(math.sin(x), abs=3e-5)
    assert lib.cf_fast_cos(x) == pytest.approx(math.cos(x), abs=3e-5)


def test_an_entry_of_the_table_has_eight_decimals():
    assert lib.cf_fast_sin(2 * math.pi / 512) == pytest.approx(0.01227154, abs=1e-8)


@pytest.mark.parametrize("x", [math.nan, math.inf, -math.inf])
def test_what_is_no_angle_gives_nan(x):
    assert math.isnan(lib.cf_fast_sin(x))
    assert math.isnan(lib.cf_fast_cos(x))


@pytest.mark.parametrize("x", [2e8, -2e8, 2e10, -2e10, 3e38, -3e38])
def test_angles_beyond_the_resolution_of_a_float_count_as_whole_turns(x):
    assert lib.cf_fast_sin(x) == 0.0
    assert lib.cf_fast_cos(x) == 0.0
