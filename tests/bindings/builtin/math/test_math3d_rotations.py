"""Matrices and quaternions of math3d, with scipy as oracle.

docs/reference/control-geometric.md#4.4 to #4.6, #12 and #13.1.
"""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from crazychoir_fw._core import ffi, lib

M_PI_2_F = 1.57079632679
# the quaternion of 0.1, -0.2, 0.5 rad that the reference's tables call qa
QA = (0.0728518292, -0.0843056813, 0.250694811, 0.961632609)
QA_ROWS = (
    (0.860089362, -0.494436264, -0.125615031),
    (0.469868958, 0.863689482, -0.182383373),
    (0.198669344, 0.0978433937, 0.975170374),
)
C = (0.0916432887, -0.183286577, 0.274929881, 0.939372718)  # 0.7 rad about (1, -2, 3)

angles = st.floats(-3.125, 3.125, width=32)
numbers = st.floats(-10, 10, width=32)
vectors = st.tuples(numbers, numbers, numbers)
quaternions = st.tuples(angles, angles, angles).map(
    lambda rpy: tuple(Rotation.from_euler("xyz", rpy).as_quat())
)  # scalar last, as here


def vec(values):
    return ffi.new("struct vec *", dict(zip("xyz", values, strict=True)))[0]


def xyz(v):
    return (v.x, v.y, v.z)


def quat(values):
    return lib.mkquat(*values)


def xyzw(q):
    return (q.x, q.y, q.z, q.w)


def mat(rows):
    return lib.mrows(*(vec(row) for row in rows))


def rows(m):
    return np.array([list(row) for row in m.m])


def close(expected, tolerance=3e-7):
    return pytest.approx(tuple(np.ravel(expected)), rel=0, abs=tolerance)


def x90():
    return lib.qaxisangle(lib.vbasis(0), M_PI_2_F)


def y90():
    return lib.qaxisangle(lib.vbasis(1), M_PI_2_F)


# ---- matrices ----

M = ((1.0, 2.0, 3.0), (4.0, 5.0, 6.0), (7.0, 8.0, 10.0))
N = ((0.5, -1.0, 2.0), (3.0, 0.25, -4.0), (1.0, 1.0, 1.5))


@pytest.mark.parametrize(
    ("matrix", "expected"),
    [
        (lambda: lib.mzero(), np.zeros((3, 3))),
        (lambda: lib.meye(), np.eye(3)),
        (lambda: lib.meyescl(3.0), 3 * np.eye(3)),
        (lambda: lib.mdiag(1, 2, 3), np.diag([1, 2, 3])),
        (lambda: lib.mcolumns(vec(M[0]), vec(M[1]), vec(M[2])), np.transpose(M)),
        (lambda: mat(M), M),
        (lambda: lib.mtranspose(mat(M)), np.transpose(M)),
        (lambda: lib.mscl(2.0, mat(M)), 2 * np.array(M)),
        (lambda: lib.mneg(mat(M)), np.negative(M)),
        (lambda: lib.madd(mat(M), mat(N)), np.add(M, N)),
        (lambda: lib.msub(mat(M), mat(N)), np.subtract(M, N)),
        (lambda: lib.madd3(mat(M), mat(N), mat(M)), 2 * np.array(M) + N),
        (lambda: lib.maddridge(mat(M), 0.5), M + 0.5 * np.eye(3)),
        (lambda: lib.mmul(mat(M), mat(N)), np.array(M) @ N),
    ],
)
def test_matrices(matrix, expected):
    assert np.array_equal(rows(matrix()), expected)


def test_rows_and_columns_are_taken_out():
    assert [xyz(lib.mrow(mat(M), i)) for i in range(3)] == list(M)
    assert [xyz(lib.mcolumn(mat(M), i)) for i in range(3)] == [tuple(column) for column in np.transpose(M)]


def test_matrix_times_vector():
    assert xyz(lib.mvmul(mat(M), vec((1, -1, 2)))) == tuple(np.array(M) @ (1, -1, 2))


@given(vectors, vectors)
def test_the_cross_matrix_is_the_cross_product(a, b):
    assert xyz(lib.mvmul(lib.mcrossmat(vec(a)), vec(b))) == pytest.approx(xyz(lib.vcross(vec(a), vec(b))), abs=1e-4)


def test_one_nan_makes_a_matrix_nan():
    assert not lib.misnan(mat(M))
    for i in range(9):
        values = np.array(M)
        values.flat[i] = math.nan
        assert lib.misnan(mat(values))


def test_a_block_is_written_into_a_larger_matrix():
    large = np.zeros((5, 6), dtype=np.float32)
    block = ffi.cast("float *", ffi.from_buffer(large)) + 6 + 2
    lib.set_block33_rowmaj(block, 6, ffi.new("struct mat33 *", mat(M)))
    expected = np.zeros((5, 6))
    expected[1:4, 2:5] = M
    assert np.array_equal(large, expected)


@given(vectors, angles)
def test_a_matrix_turns_about_an_axis(axis, angle):
    unit = np.array([*axis[:2], axis[2] + 20.0])
    unit /= np.linalg.norm(unit)
    expected = Rotation.from_rotvec(angle * unit).as_matrix()
    assert rows(lib.maxisangle(vec(unit), angle)) == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize(("name", "axis"), [("mrotx", 0), ("mroty", 1), ("mrotz", 2)])
@given(angle=angles)
def test_turns_about_the_axes_have_the_same_bits(name, axis, angle):
    assert np.array_equal(rows(getattr(lib, name)(angle)), rows(lib.maxisangle(lib.vbasis(axis), angle)))


# ---- quaternions: the table of docs/reference/control-geometric.md#13.1 ----


def test_table_angles_and_matrices_of_a_quaternion():
    assert xyzw(lib.rpy2quat(vec((0.1, -0.2, 0.5)))) == close(QA, 1e-8)
    assert xyz(lib.quat2rpy(quat(QA))) == close((0.100000001, -0.200000018, 0.5), 5e-8)
    assert tuple(rows(lib.quat2rotmat(quat(QA))).ravel()) == close(QA_ROWS, 1e-8)
    expected = (0.072851643, -0.0843056142, 0.250694811, 0.961632609)
    assert xyzw(lib.mat2quat(lib.quat2rotmat(quat(QA)))) == close(expected, 1e-8)


def test_table_axis_and_angle():
    assert xyzw(x90()) == close((0.707106769, 0, 0, 0.707106769), 1e-8)
    assert xyzw(lib.qaxisangle(vec((1, -2, 3)), 0.7)) == close(C, 1e-8)


def test_table_products_of_quarter_turns():
    assert xyzw(lib.qqmul(x90(), y90())) == close((0.49999997,) * 4, 1e-8)


def test_table_turned_vector():
    assert xyz(lib.qvrot(quat(C), vec((0.3, 0.2, -0.1)))) == close((0.153864086, 0.33858043, 0.0410989225), 1e-8)


def test_table_from_vector_to_vector():
    a, b = lib.vnormalize(vec((1, 2, 3))), lib.vnormalize(vec((-2, 1, 0.5)))
    expected = (-0.152180538, -0.494586736, 0.380451351, 0.766473591)
    assert xyzw(lib.qvectovec(a, b)) == close(expected, 1e-8)


def test_table_small_angles():
    expected = (0.00999999978, -0.0149999997, 0.0250000004, 0.999524891)
    assert xyzw(lib.rpy2quat_small(vec((0.02, -0.03, 0.05)))) == close(expected, 1e-8)


def test_table_gyro_update():
    expected = (0.0925826579, -0.185165316, 0.277747989, 0.938089728)
    assert xyzw(lib.quat_gyro_update(quat(C), vec((1, -2, 3)), 0.002)) == close(expected, 1e-8)


def test_table_interpolation():
    goal = lib.qaxisangle(lib.vbasis(2), 0.4)
    line = (0.0690534338, -0.138106868, 0.257059574, 0.953980327)
    arc = (0.0689824969, -0.137964994, 0.257002473, 0.954021335)
    assert xyzw(lib.qnlerp(quat(C), goal, 0.25)) == close(line, 1e-8)
    assert xyzw(lib.qslerp(quat(C), goal, 0.25)) == close(arc, 1e-8)


# ---- quaternions: upstream's test of the product, docs/reference/control-geometric.md#12 ----


def test_upstream_products():
    assert xyzw(lib.qqmul(x90(), y90())) == close((0.5,) * 4, 1e-5)
    assert lib.qqmul(y90(), x90()).z == pytest.approx(-0.5, abs=1e-5)
    v = vec((0, 0, 1))
    turned = lib.qvrot(x90(), lib.qvrot(y90(), v))
    assert xyz(lib.qvrot(lib.qqmul(x90(), y90()), v)) == close(xyz(turned), 1e-5)


def test_upstream_inverse():
    q = lib.qaxisangle(lib.vnormalize(vec((1, -2, 3))), 0.7)
    assert xyzw(lib.qqmul(q, lib.qinv(q))) == close((0, 0, 0, 1), 1e-5)


def test_upstream_difference_of_attitudes():
    z90 = lib.qaxisangle(lib.vbasis(2), M_PI_2_F)
    difference = lib.qqmul(lib.qinv(z90), quat((0.5, 0.5, 0.5, 0.5)))
    assert xyzw(difference) == close((0.70711, 0, 0, 0.70711), 1e-5)


# ---- quaternions against scipy ----


@given(quaternions, quaternions)
def test_the_product_is_hamiltons(q, p):
    expected = (Rotation.from_quat(q) * Rotation.from_quat(p)).as_matrix()
    assert rows(lib.quat2rotmat(lib.qqmul(quat(q), quat(p)))) == pytest.approx(expected, abs=2e-6)


@given(quaternions, vectors)
def test_quaternion_and_matrix_turn_alike(q, v):
    turned = xyz(lib.qvrot(quat(q), vec(v)))
    assert turned == pytest.approx(xyz(lib.mvmul(lib.quat2rotmat(quat(q)), vec(v))), abs=3e-5)
    assert turned == pytest.approx(tuple(Rotation.from_quat(q).apply(v)), abs=3e-5)


@given(angles, st.floats(-1.5, 1.5, width=32), angles)
def test_angles_go_to_a_quaternion_and_back(roll, pitch, yaw):
    q = lib.rpy2quat(vec((roll, pitch, yaw)))
    same = Rotation.from_quat(xyzw(q)) * Rotation.from_euler("ZYX", (yaw, pitch, roll)).inv()
    assert same.magnitude() < 1e-6
    assert xyz(lib.quat2rpy(q)) == pytest.approx((roll, pitch, yaw), abs=2e-5)


@given(quaternions)
def test_a_matrix_becomes_the_quaternion_with_positive_scalar(q):
    back = lib.mat2quat(lib.quat2rotmat(quat(q)))
    assert back.w >= 0.0
    # poor near half a turn (docs/reference/control-geometric.md#14, quirk 20)
    assert (Rotation.from_quat(xyzw(back)) * Rotation.from_quat(q).inv()).magnitude() < 2e-3


@given(vectors, st.floats(0.015625, 3.125, width=32))
def test_axis_and_angle_come_back(axis, angle):
    axis = np.array([*axis[:2], axis[2] + 20.0])
    q = lib.qaxisangle(vec(axis), angle)
    assert lib.quat2angle(q) == pytest.approx(angle, abs=1e-3)
    assert xyz(lib.quat2axis(q)) == pytest.approx(tuple(axis / np.linalg.norm(axis)), abs=3e-3)


def test_an_angle_is_that_of_the_shorter_way():
    assert lib.quat2angle(lib.qaxisangle(lib.vbasis(0), 5.0)) == pytest.approx(5.0 - 2 * math.pi, rel=1e-5)


@given(vectors, vectors)
def test_a_vector_is_turned_into_another(a, b):
    a, b = lib.vnormalize(vec((*a[:2], a[2] + 20.0))), lib.vnormalize(vec((b[0], b[1] + 20.0, b[2])))
    assert xyz(lib.qvrot(lib.qvectovec(a, b), a)) == close(xyz(b), 3e-6)


def test_parallel_vectors_need_no_turn_and_opposite_ones_have_none():
    x = lib.vbasis(0)
    assert xyzw(lib.qvectovec(x, x)) == (0, 0, 0, 1)
    assert xyzw(lib.qvectovec(x, lib.vneg(x))) == (0, 0, 0, 0)


@given(vectors)
def test_small_angles_make_unit_quaternions_at_any_size(rpy):
    q = lib.rpy2quat_small(vec(rpy))
    assert lib.qdot(q, q) == pytest.approx(1.0, abs=1e-5)


def test_large_small_angles_keep_their_axis():
    w = 1 / math.sqrt(1 + 9 / 4)
    assert xyzw(lib.rpy2quat_small(vec((3, 0, 0)))) == close((1.5 * w, 0, 0, w), 1e-7)


@given(quaternions, quaternions, st.floats(0, 1, width=32))
def test_the_arc_has_constant_speed(a, b, t):
    q = lib.qslerp(quat(a), quat(b), t)
    start, goal = Rotation.from_quat(a), Rotation.from_quat(b)
    whole = (start.inv() * goal).magnitude()
    done = (start.inv() * Rotation.from_quat(xyzw(q))).magnitude()
    # half a turn goes either way; near the start the straight line is taken
    assert done == pytest.approx(t * whole, abs=3e-4)
    assert lib.qdot(q, q) == pytest.approx(1.0, abs=2e-6)


def test_the_arc_goes_the_short_way():
    a, b = lib.qeye(), lib.qneg(x90())
    assert lib.qslerp(a, b, 0.5).x == pytest.approx(math.sin(math.pi / 8), rel=1e-6)


@given(quaternions, vectors)
def test_rates_turn_the_body(q, gyro):
    dt = 1e-3
    updated = lib.qnormalize(lib.quat_gyro_update(quat(q), vec(gyro), dt))
    expected = Rotation.from_quat(q) * Rotation.from_rotvec(np.array(gyro) * dt)
    assert (expected.inv() * Rotation.from_quat(xyzw(updated))).magnitude() < 2e-6


@given(quaternions, quaternions)
def test_the_angle_between_two_quaternions_is_always_zero(a, b):
    # docs/reference/control-geometric.md#4.6: a guard of 1e9 where 1e-9 was meant
    assert lib.qanglebetween(quat(a), quat(b)) == 0.0


def test_the_angle_to_nan_is_nan():
    assert math.isnan(lib.qanglebetween(quat((0, 0, 0, math.nan)), lib.qeye()))


def test_small_operations():
    q = quat((1, -2, 3, -4))
    assert xyzw(lib.quatvw(vec((1, 2, 3)), 4)) == (1, 2, 3, 4)
    assert xyz(lib.quatimagpart(q)) == (1, -2, 3)
    assert xyzw(lib.qeye()) == (0, 0, 0, 1)
    assert xyzw(lib.qinv(q)) == (-1, 2, -3, -4)
    assert xyzw(lib.qneg(q)) == (-1, 2, -3, 4)
    assert xyzw(lib.qposreal(q)) == (-1, 2, -3, 4)
    assert xyzw(lib.qposreal(lib.qneg(q))) == (-1, 2, -3, 4)
    assert lib.qdot(q, quat((2, 2, 2, 1))) == 0.0
    assert lib.qeq(q, q)
    assert not any(lib.qeq(q, quat(other)) for other in ((0, -2, 3, -4), (1, 0, 3, -4), (1, -2, 0, -4), (1, -2, 3, 0)))


def test_the_zero_quaternion_turns_nothing():
    assert np.array_equal(rows(lib.quat2rotmat(quat((0, 0, 0, 0)))), np.eye(3))


def test_quaternions_are_loaded_and_stored():
    doubles, floats = ffi.new("double[4]"), ffi.new("float[4]")
    lib.qstore(quat((1, 2, 3, 4)), doubles)
    lib.qstoref(quat((5, 6, 7, 8)), floats)
    assert tuple(doubles) == (1, 2, 3, 4)
    assert tuple(floats) == (5, 6, 7, 8)
    assert xyzw(lib.qload(doubles)) == (1, 2, 3, 4)
    assert xyzw(lib.qloadf(floats)) == (5, 6, 7, 8)


# ---- accuracy of docs/reference/control-geometric.md#16, and quirk 20


def largest_error(compute, count=500):
    """Return the largest error over random cases, each given a random generator."""
    rng = np.random.default_rng(16)
    return max(np.abs(np.subtract(*compute(rng))).max() for _ in range(count))


def same_sign(found, expected):
    return found, np.copysign(1.0, np.dot(found, expected)) * np.asarray(expected)


def random_rotation(rng):
    """Return a scipy rotation whose quaternion has float32 numbers, and that quaternion as ours."""
    q = Rotation.random(random_state=rng).as_quat().astype(np.float32)
    return Rotation.from_quat(q.astype(float)), quat(q.tolist())


def matrix_of(rng):
    rotation, q = random_rotation(rng)
    return rows(lib.quat2rotmat(q)), rotation.as_matrix()


def from_angles(rng):
    rpy = rng.uniform(-np.pi, np.pi, 3).astype(np.float32)
    return same_sign(xyzw(lib.rpy2quat(vec(rpy.tolist()))), Rotation.from_euler("xyz", rpy).as_quat())


def to_angles(rng):
    rpy = (rng.uniform(-1, 1, 3) * [np.pi, 1.5, np.pi]).astype(np.float32)
    q = Rotation.from_euler("xyz", rpy).as_quat().astype(np.float32)
    return xyz(lib.quat2rpy(quat(q.tolist()))), Rotation.from_quat(q.astype(float)).as_euler("xyz")


def from_axis(rng):
    axis, angle = rng.normal(size=3).astype(np.float32), np.float32(rng.uniform(-np.pi, np.pi))
    expected = Rotation.from_rotvec(angle * axis / np.linalg.norm(axis)).as_quat()
    return same_sign(xyzw(lib.qaxisangle(vec(axis.tolist()), float(angle))), expected)


def product(rng):
    (a, q), (b, p) = random_rotation(rng), random_rotation(rng)
    return same_sign(xyzw(lib.qqmul(q, p)), (a * b).as_quat())


def on_the_arc(rng):
    (a, q), t = random_rotation(rng), np.float32(rng.random())
    # beyond 0.3 rad, below which the straight line is taken, and short of half a turn
    way = rng.normal(size=3)
    b = a * Rotation.from_rotvec(rng.uniform(0.3, 3.0) * way / np.linalg.norm(way))
    p = b.as_quat().astype(np.float32)
    expected = a * Rotation.from_rotvec(t * (a.inv() * Rotation.from_quat(p.astype(float))).as_rotvec())
    return same_sign(xyzw(lib.qslerp(q, quat(p.tolist()), float(t))), expected.as_quat())


def turned(rng):
    a, b = (lib.vnormalize(vec(v.tolist())) for v in rng.normal(size=(2, 3)).astype(np.float32))
    if lib.vdot(a, b) < -0.9:  # near half a turn the axis is poor
        b = lib.vneg(b)
    axis = np.cross(xyz(a), xyz(b))
    angle = math.atan2(np.linalg.norm(axis), np.dot(xyz(a), xyz(b)))
    expected = Rotation.from_rotvec(angle * axis / np.linalg.norm(axis))
    return same_sign(xyzw(lib.qvectovec(a, b)), expected.as_quat())


# docs/reference/control-geometric.md#16, from 3000 cases, but for the axis: 1.5e-7 there
ACCURACY = [
    (matrix_of, 2e-7),
    (from_angles, 1.5e-7),
    (from_axis, 2e-7),
    (on_the_arc, 4e-7),
    (product, 1.5e-7),
    (to_angles, 1.5e-6),
    (turned, 7e-7),
]


@pytest.mark.parametrize(("compute", "most"), ACCURACY)
def test_section_16_rotations_agree_with_scipy(compute, most):
    assert largest_error(compute) < most


def test_quirk_20_a_matrix_near_half_a_turn_gives_a_poor_quaternion():
    """The small components are roots of differences of ones: right to 1e-4 alone."""
    errors = []
    for w in np.linspace(-3e-4, 3e-4, 61):
        q = np.array([0.6, 0.0, 0.8 * math.sqrt(1 - w * w), w])
        back = np.array(xyzw(lib.mat2quat(lib.quat2rotmat(quat((q / np.linalg.norm(q)).tolist())))))
        errors.append(np.abs(np.abs(back) - np.abs(q)).max())
    assert 2e-5 < max(errors) < 5e-4
