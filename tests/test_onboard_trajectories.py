"""Bytes of trajectory memory as cflib packs them (docs/reference/crtp-cflib.md#10.3 and #21)."""

import math
from pathlib import Path

import numpy as np
import pytest
from cflib.crazyflie import mem
from hypothesis import given
from hypothesis import strategies as st
from numpy.polynomial import Polynomial

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.trajectory_files import end_points, read_pieces
from crazychoir_fw.onboard.trajectories import CompressedSegment, CompressedStart, Poly4D, compress, pack_compressed

coefficients = st.lists(st.floats(-1e6, 1e6, width=32), min_size=8, max_size=8)
meters = st.floats(-32.7, 32.7)
radians = st.floats(-57.0, 57.0)


def axis(values):
    """Return none, one, three or seven control points."""
    return st.sampled_from([0, 1, 3, 7]).flatmap(lambda n: st.lists(values, min_size=n, max_size=n))


def test_captured_bytes_of_a_compressed_trajectory():
    start = CompressedStart(0.0, 0.0, 1.0, 0.0)
    segment = CompressedSegment(2.0, [], [1.0], [1.0, 2.0, 3.0], [0.1] * 7)
    expected = "00000000E8030000 E4D007E803E803D007B80B" + 7 * "3900"
    assert start.pack() + segment.pack() == bytes.fromhex(expected)
    assert pack_compressed(start, [segment]) == bytes.fromhex(expected) + bytes(3)


@given(st.floats(0.125, 1000.0, width=32), coefficients, coefficients, coefficients, coefficients)
def test_pieces_are_packed_as_cflib_does(duration, x, y, z, yaw):
    ours = Poly4D(duration, *(Poly4D.Poly(c) for c in (x, y, z, yaw)))
    theirs = mem.Poly4D(duration, *(mem.Poly4D.Poly(c) for c in (x, y, z, yaw)))
    assert ours.pack() == bytes(theirs.pack())
    assert len(ours.pack()) == 132


def test_axis_that_is_not_given_is_zero():
    assert Poly4D(1.0).pack() == bytes(mem.Poly4D(1.0).pack())
    assert repr(Poly4D(1.5)) == "<Poly4D of 1.5 s>"


@given(meters, meters, meters, radians)
def test_starts_are_packed_as_cflib_does(x, y, z, yaw):
    assert CompressedStart(x, y, z, yaw).pack() == bytes(mem.CompressedStart(x, y, z, yaw).pack())


@given(st.floats(0.001, 65.0), axis(meters), axis(meters), axis(meters), axis(radians))
def test_segments_are_packed_as_cflib_does(duration, x, y, z, yaw):
    ours = CompressedSegment(duration, x, y, z, yaw).pack()
    assert ours == bytes(mem.CompressedSegment(duration, x, y, z, yaw).pack())


@given(meters, radians, st.lists(st.tuples(st.floats(0.5, 10.0), axis(meters), axis(radians)), min_size=1, max_size=4))
def test_onboard_planner_reads_what_was_packed(x, yaw, pieces):
    data = pack_compressed(
        CompressedStart(x, 0.0, 0.0, yaw), [CompressedSegment(t, xs, [], [], yaws) for t, xs, yaws in pieces]
    )
    view = ffi.new("struct piecewise_traj_compressed *")
    buffer = ffi.new("uint8_t[]", data)
    lib.piecewise_compressed_load(view, buffer, len(data))
    assert view.duration == pytest.approx(sum(int(1000 * t) for t, _, _ in pieces) / 1000)
    end = lib.piecewise_compressed_eval(view, 100.0)
    for _, xs, yaws in pieces:
        x, yaw = xs[-1] if xs else x, yaws[-1] if yaws else yaw
    # truncated, and rounded in each of the conversions
    assert end.pos.x == pytest.approx(x, abs=4e-3)
    assert end.yaw == pytest.approx(yaw, abs=6e-3)


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (
            lambda: CompressedSegment(1.0, [1.0, 2.0], [], [], []),
            r"has \[2, 0, 0, 0\] control points.*allowed: 0, 1, 3",
        ),
        (lambda: CompressedSegment(0.0, [], [], [], []).pack(), "takes 0.001 to 65.535 s"),
        (lambda: CompressedSegment(65.6, [], [], [], []).pack(), "takes 0.001 to 65.535 s"),
        (lambda: CompressedSegment(math.nan, [], [], [], []).pack(), "allowed: finite numbers"),
        (lambda: CompressedSegment(1.0, [math.inf], [], [], []).pack(), "allowed: finite numbers"),
        (lambda: CompressedSegment(1.0, [40.0], [], [], []).pack(), "allowed: -32.767 m to 32.767 m"),
        (lambda: CompressedStart(0.0, 0.0, 0.0, 60.0).pack(), "allowed: -3276.7 deg to 3276.7 deg"),
        (lambda: Poly4D(1.0, Poly4D.Poly([1.0, 2.0])).pack(), r"has \[2, 8, 8, 8\] coefficients"),
    ],
)
def test_what_does_not_fit_is_refused_in_words(make, sentence):
    with pytest.raises(RangeError, match=sentence):
        make()


# --- compression


def evaluate(start, segments, times):
    """Return x, y, z and yaw of a compressed trajectory, shape (T, 4)."""
    data = pack_compressed(start, segments)
    view = ffi.new("struct piecewise_traj_compressed *")
    buffer = ffi.new("uint8_t[]", data)
    lib.piecewise_compressed_load(view, buffer, len(data))
    goals = [lib.piecewise_compressed_eval(view, t) for t in times]
    return np.array([[goal.pos.x, goal.pos.y, goal.pos.z, goal.yaw] for goal in goals])


smooth = st.lists(st.floats(-1.0, 1.0), min_size=1, max_size=8)


@given(st.lists(st.integers(200, 2000), min_size=1, max_size=3), st.lists(smooth, min_size=4, max_size=4))
def test_compressed_pieces_keep_the_curve(durations_ms, axes):
    """Pieces of one polynomial per axis, of any degree up to 7, which join by themselves."""
    total = sum(durations_ms) / 1000
    curves = [Polynomial(c, domain=[0, total], window=[0, 1]).convert() for c in axes]
    rows, begin = [], 0.0
    for duration_ms in durations_ms:
        pieces = [curve(Polynomial([begin, 1.0])) for curve in curves]
        rows.append(
            [*(c for piece in pieces for c in np.pad(piece.coef, (0, 8 - len(piece.coef)))), duration_ms / 1000]
        )
        begin += duration_ms / 1000
    start, segments = compress(rows)
    times = np.linspace(0, total, 40)
    expected = np.array([[curve(t) for curve in curves] for t in times])
    np.testing.assert_allclose(evaluate(start, segments, times), expected, atol=0.005)


def test_each_axis_takes_its_shortest_form():
    row = np.zeros(33)
    row[0] = 0.25  # x constant
    row[8:10] = 0.0, 0.5  # y linear
    row[16:20] = 0.5, 0.0, 0.3, -0.1  # z cubic
    row[24:32] = 0.0, 0.0, 0.0, 0.0, 3.0, -4.0, 2.0, -0.5
    row[32] = 2.0
    stay = np.zeros(33)
    stay[0:32:8] = end_points(row[None])[1]
    stay[32] = 0.57
    start, segments = compress([row, stay])
    assert start.pack() == CompressedStart(0.25, 0, 0.5, 0).pack()
    first, second = segments
    assert [len(element) for element in (first.x, first.y, first.z, first.yaw)] == [0, 1, 3, 7]
    assert [len(element) for element in (second.x, second.y, second.z, second.yaw)] == [0, 0, 0, 0]
    assert [int.from_bytes(segment.pack()[1:3], "little") for segment in segments] == [2000, 570]


def test_figure8_shrinks_to_a_fourth():
    path = Path(__file__).parents[1] / "examples" / "figure8.csv"
    pieces = read_pieces(path)
    start, segments = compress(pieces)
    assert len(pack_compressed(start, segments)) < pieces.nbytes / 4


@pytest.mark.parametrize(
    ("pieces", "sentence"),
    [
        (np.zeros((1, 32)), r"shape \(1, 32\), allowed: \(n, 33\)"),
        (np.zeros((0, 33)), "shape"),
        (np.full((1, 33), np.nan), "finite"),
        (np.vstack([np.zeros(33), np.ones(33)]), "piece 1 starts 1 m or rad beside the one before"),
    ],
)
def test_pieces_that_cannot_be_compressed_are_refused_in_words(pieces, sentence):
    with pytest.raises(RangeError, match=sentence):
        compress(pieces)
