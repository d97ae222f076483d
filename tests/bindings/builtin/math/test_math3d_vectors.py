"""Vectors and scalars of math3d: docs/reference/control-geometric.md#4.1 to #4.3, with numpy as oracle."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crazychoir_fw._core import ffi, lib

F = np.float32
A, B, C, D = (1.0, -2.0, 3.0), (0.5, 4.0, -0.25), (7.0, 0.0, 2.0), (-1.0, 1.0, 1.0)

numbers = st.floats(-1000, 1000, width=32)
vectors = st.tuples(numbers, numbers, numbers)


def vec(values):
    return ffi.new("struct vec *", dict(zip("xyz", values, strict=True)))[0]


def xyz(v):
    return (v.x, v.y, v.z)


# ---- scalars ----


def test_angles_convert_with_one_rounded_factor():
    # docs/reference/control-geometric.md#13.1
    assert lib.radians(1.0) == F(0.0174532924)
    assert lib.degrees(1.0) == F(57.2957764)


def test_fsqr_is_the_square():
    assert lib.fsqr(-3.0) == 9.0


@pytest.mark.parametrize(("value", "clamped"), [(-3, -1), (-1, -1), (0.5, 0.5), (2, 2), (9, 2)])
def test_clamp_limits_a_number(value, clamped):
    assert lib.clamp(value, -1.0, 2.0) == clamped


def test_clamp_lets_nan_pass():
    assert math.isnan(lib.clamp(math.nan, -1.0, 2.0))


def neighbour(value, ulps):
    for _ in range(ulps):
        value = np.nextafter(F(value), F(np.inf))
    return float(value)


@pytest.mark.parametrize(
    ("a", "b", "ulps", "close"),
    [
        (1.0, 1.0, 0, True),
        (1.0, neighbour(1.0, 3), 3, True),
        (neighbour(1.0, 3), 1.0, 3, True),
        (1.0, neighbour(1.0, 3), 2, False),
        (-1.0, neighbour(-1.0, 2), 2, True),
        (-1e-45, 1e-45, 1000, False),  # of different sign
        (0.0, -0.0, 5, False),  # neither is below zero, and their bits are far apart
    ],
)
def test_closeness_is_counted_in_floats(a, b, ulps, close):
    assert lib.fcloseulps(a, b, ulps) == close


# ---- construction ----


def test_constructors():
    assert xyz(lib.mkvec(1, 2, 3)) == (1, 2, 3)
    assert xyz(lib.vrepeat(4)) == (4, 4, 4)
    assert xyz(lib.vzero()) == (0, 0, 0)
    assert [xyz(lib.vbasis(i)) for i in range(3)] == [(1, 0, 0), (0, 1, 0), (0, 0, 1)]


# ---- arithmetic ----


@pytest.mark.parametrize(
    ("name", "arguments", "expected"),
    [
        ("vadd", (A, B), np.add(A, B)),
        ("vsub", (A, B), np.subtract(A, B)),
        ("vadd3", (A, B, C), np.sum([A, B, C], axis=0)),
        ("vadd4", (A, B, C, D), np.sum([A, B, C, D], axis=0)),
        ("vsub2", (A, B, C), np.array(A) - B - C),
        ("vneg", (A,), np.negative(A)),
        ("vcross", (A, B), np.cross(A, B)),
        ("veltmul", (A, B), np.multiply(A, B)),
        ("veltdiv", (A, B), np.divide(A, B)),
        ("veltrecip", (A,), np.reciprocal(A)),
        ("vabs", (A,), np.abs(A)),
        ("vmin", (A, B), np.minimum(A, B)),
        ("vmax", (A, B), np.maximum(A, B)),
        ("vclamp", (A, D, C), np.clip(A, D, C)),
        ("vclampabs", (A, (2.0, 1.0, 4.0)), (1.0, -1.0, 3.0)),
        ("vnormalize", (A,), np.array(A) / np.linalg.norm(A)),
        ("vprojectunit", (A, (0.0, 1.0, 0.0)), (0.0, -2.0, 0.0)),
        ("vorthunit", (A, (0.0, 1.0, 0.0)), (1.0, 0.0, 3.0)),
    ],
)
def test_functions_of_vectors(name, arguments, expected):
    result = getattr(lib, name)(*(vec(argument) for argument in arguments))
    assert xyz(result) == pytest.approx(tuple(expected), rel=1e-6)


@pytest.mark.parametrize(
    ("name", "arguments", "expected"),
    [
        ("vdot", (A, B), np.dot(A, B)),
        ("vmag2", (A,), 14.0),
        ("vmag", (A,), math.sqrt(14)),
        ("vdist2", (A, B), np.sum(np.subtract(A, B) ** 2)),
        ("vdist", (A, B), np.linalg.norm(np.subtract(A, B))),
        ("vmaxelt", (A,), 3.0),
        ("vminelt", (A,), -2.0),
        ("vnorm1", (A,), 6.0),
    ],
)
def test_numbers_from_vectors(name, arguments, expected):
    assert getattr(lib, name)(*(vec(argument) for argument in arguments)) == pytest.approx(expected, rel=1e-6)


def test_scaling():
    assert xyz(lib.vscl(2.0, vec(A))) == (2, -4, 6)


@pytest.mark.parametrize("divisor", [3.0, 7.0, 49.0])
def test_division_multiplies_by_the_rounded_reciprocal(divisor):
    reciprocal = F(1) / F(divisor)
    assert xyz(lib.vdiv(vec((5.0, 10.0, 49.0)), divisor)) == tuple(reciprocal * F(x) for x in (5, 10, 49))


def test_a_normalized_vector_may_be_an_ulp_short():
    # the hover force of 27 g, which case M1 of docs/reference/control-geometric.md#13.2 shows
    assert lib.vnormalize(vec((0, 0, F(0.027) * F(9.81)))).z == F(0.99999994)


def test_the_zero_vector_has_no_direction():
    assert lib.visnan(lib.vnormalize(lib.vzero()))


@pytest.mark.parametrize(("most", "expected"), [(10.0, (3.0, 0.0, 4.0)), (1.0, (0.6, 0.0, 0.8))])
def test_a_norm_is_clamped(most, expected):
    assert xyz(lib.vclampnorm(vec((3.0, 0.0, 4.0)), most)) == pytest.approx(expected, rel=1e-6)


@given(vectors, vectors)
def test_a_vector_is_the_sum_of_its_parts_along_and_across(a, b):
    unit = lib.vnormalize(vec((*b[:2], b[2] + 2000.0)))
    parts = lib.vadd(lib.vprojectunit(vec(a), unit), lib.vorthunit(vec(a), unit))
    assert xyz(parts) == pytest.approx(a, abs=1e-3)
    assert lib.vdot(lib.vorthunit(vec(a), unit), unit) == pytest.approx(0.0, abs=1e-3)


# ---- comparisons ----


@pytest.mark.parametrize(
    ("a", "b", "holding"),
    [
        ((1, 2, 3), (1, 2, 3), {"veq", "vleq", "vgeq"}),
        ((1, 2, 3), (2, 3, 4), {"vneq", "vless", "vleq"}),
        ((2, 3, 4), (1, 2, 3), {"vneq", "vgreater", "vgeq"}),
        ((1, 2, 3), (1, 3, 3), {"vneq", "vleq"}),
        ((1, 2, 3), (1, 1, 4), {"vneq"}),
        ((1, 2, math.nan), (1, 2, math.nan), {"vneq"}),
    ],
)
def test_comparisons_hold_for_all_elements(a, b, holding):
    names = ("veq", "vneq", "vless", "vleq", "vgreater", "vgeq")
    assert {name for name in names if getattr(lib, name)(vec(a), vec(b))} == holding


def test_equality_up_to_a_tolerance_is_strict():
    assert lib.veqepsilon(vec((1, 2, 3)), vec((1.25, 2, 3)), 0.5)
    assert not lib.veqepsilon(vec((1, 2, 3)), vec((1.5, 2, 3)), 0.5)


@pytest.mark.parametrize("place", [0, 1, 2])
def test_one_nan_makes_a_vector_nan(place):
    values = [1.0, 2.0, 3.0]
    assert not lib.visnan(vec(values))
    values[place] = math.nan
    assert lib.visnan(vec(values))


# ---- in and out ----


def test_vectors_are_loaded_and_stored():
    doubles, floats = ffi.new("double[3]"), ffi.new("float[3]")
    lib.vstore(vec(A), doubles)
    lib.vstoref(vec(B), floats)
    assert tuple(doubles) == A
    assert tuple(floats) == B
    assert xyz(lib.vload(doubles)) == A
    assert xyz(lib.vloadf(floats)) == B
    assert [lib.vindex(vec(A), i) for i in range(3)] == list(A)
