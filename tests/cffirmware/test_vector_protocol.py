"""`vec` in Python: arithmetic against NumPy, indexing, conversion (docs/reference/cffirmware-api.md#7)."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crazychoir_fw import cffirmware as firm

coordinate = st.floats(-1e6, 1e6, width=32)
coordinates = st.tuples(coordinate, coordinate, coordinate)
factor = st.floats(-1e3, 1e3, width=32)


def array(v):
    return np.array(v, dtype=np.float32)


@given(coordinates, coordinates)
def test_sum_and_difference_are_those_of_numpy(a, b):
    v, w = firm.mkvec(*a), firm.mkvec(*b)
    assert np.array_equal(array(v + w), array(v) + array(w))
    assert np.array_equal(array(v - w), array(v) - array(w))
    assert np.array_equal(array(-v), -array(v))


@given(coordinates, factor)
def test_product_is_that_of_numpy(a, s):
    v = firm.mkvec(*a)
    assert np.array_equal(array(s * v), np.float32(s) * array(v))
    assert np.array_equal(array(s * v), array(firm.vscl(s, v)))


@given(coordinates, factor.filter(lambda s: abs(s) > 1e-3))
def test_quotient_is_a_product_with_the_reciprocal(a, s):
    v = firm.mkvec(*a)
    assert np.array_equal(array(v / s), (np.float32(1) / np.float32(s)) * array(v))


@given(coordinates, coordinates)
def test_products_of_vectors_are_those_of_numpy(a, b):
    v, w = firm.mkvec(*a), firm.mkvec(*b)
    x, y = np.array(a, np.float64), np.array(b, np.float64)
    scale = float(np.linalg.norm(x) * np.linalg.norm(y))
    assert firm.vdot(v, w) == pytest.approx(x @ y, abs=1e-6 * scale + 1e-30)
    assert np.allclose(np.array(firm.vcross(v, w)), np.cross(x, y), rtol=0, atol=1e-6 * scale + 1e-30)


@given(coordinates)
def test_elements_by_index_member_and_iteration(a):
    v = firm.mkvec(*a)
    assert (v[0], v[1], v[2]) == (v.x, v.y, v.z) == tuple(v) == a
    assert len(v) == 3
    assert repr(v) == f"({v.x}, {v.y}, {v.z})"


@pytest.mark.parametrize("i", [-1, 3, 100])
def test_index_beyond_the_end_is_an_error(firm, i):
    with pytest.raises(IndexError):
        _ = firm.vzero()[i]


def test_array_takes_dtype_and_copy(firm):
    v = firm.mkvec(1, 2, 3)
    assert np.array(v).dtype == np.float64
    assert np.asarray(v, dtype=np.float32).dtype == np.float32
    assert np.array(v, copy=True).tolist() == [1, 2, 3]
    with pytest.raises(ValueError, match="always a copy"):
        v.__array__(copy=False)


def test_what_upstream_does_not_define_stays_undefined(firm):
    v = firm.mkvec(1, 2, 3)
    for wrong in (lambda: v * 2, lambda: v * v, lambda: v + 1, lambda: v - (1, 2, 3), lambda: v / v, lambda: "2" * v):
        with pytest.raises(TypeError):
            wrong()


def test_arithmetic_works_on_views(firm):
    evaluation = firm.traj_eval_zero()
    evaluation.pos = firm.mkvec(1, 2, 3)
    assert list(2 * evaluation.pos + evaluation.pos) == [3, 6, 9]
