import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crazychoir_fw._core import ffi, lib


def cube_roots(values):
    x = np.array(values, np.float32)
    out = np.empty_like(x)
    lib.cf_cube_roots(ffi.from_buffer("float[]", x), ffi.from_buffer("float[]", out), len(x))
    return out


def test_roots_are_correctly_rounded():
    """A double holds the root of a float to more than twice its digits, so that rounding it is exact."""
    rng = np.random.default_rng(1)
    x = np.concatenate(
        [
            rng.uniform(-100, 100, 100_000).astype(np.float32),
            (2.0 ** rng.uniform(-120, 120, 100_000)).astype(np.float32),
        ]
    )
    assert np.array_equal(cube_roots(x), np.cbrt(x.astype(np.float64)).astype(np.float32))


@given(st.floats(width=32, allow_nan=False, allow_infinity=False, allow_subnormal=False))
def test_cube_of_the_root_is_the_number(x):
    assert float(cube_roots([x])[0]) ** 3 == pytest.approx(x, rel=4e-7, abs=0.0)


@pytest.mark.parametrize("x", [0.0, -0.0, np.inf, -np.inf, np.nan])
def test_what_has_no_ordinary_root_stays(x):
    root = cube_roots([x])[0]
    assert np.array_equal(root, np.float32(x), equal_nan=True)
    assert np.signbit(root) == np.signbit(np.float32(x)) or np.isnan(x)


def test_many_at_once_are_the_same_as_one_by_one():
    x = np.linspace(-5, 5, 23).astype(np.float32)
    assert np.array_equal(cube_roots(x), [cube_roots([value])[0] for value in x])
