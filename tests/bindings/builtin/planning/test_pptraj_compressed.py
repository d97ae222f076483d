"""Compressed trajectories against the reference's numbers, the same curves uncompressed, and hostile bytes.

docs/reference/planner-commander.md#5, #17.1 and #17.2.
"""

import math
import struct
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.interpolate import BPoly

from crazychoir_fw._core import ffi, lib

DATA = Path(__file__).parent / "data"
FIGURE8 = np.loadtxt(DATA / "figure8.csv", delimiter=",")
FIGURE8_COMPRESSED = np.loadtxt(DATA / "figure8_compressed.csv", delimiter=",").astype(int)
FIGURE8_COMPRESSED_GOALS = np.loadtxt(DATA / "figure8_compressed_goals.csv", delimiter=",")
YAW_GOALS = np.loadtxt(DATA / "compressed_yaw_goals.csv", delimiter=",")

END = bytes(3)
LENGTHS = [0, 1, 3, 7]  # stored control points, by storage type


def segment(duration_ms: int, x=(), y=(), z=(), yaw=()) -> bytes:
    """Return one piece; control points in mm and 0.1 deg."""
    axes = [list(axis) for axis in (x, y, z, yaw)]
    types = sum(LENGTHS.index(len(axis)) << 2 * i for i, axis in enumerate(axes))
    points = [point for axis in axes for point in axis]
    return struct.pack(f"<BH{len(points)}h", types, duration_ms, *points)


def start(x=0, y=0, z=0, yaw=0) -> bytes:
    return struct.pack("<4h", x, y, z, yaw)


FIGURE8_BYTES = start() + b"".join(segment(r[0], r[1:8], r[8:15]) for r in FIGURE8_COMPRESSED) + END

# docs/reference/planner-commander.md#17.1: z up, eight straight lines, z down
SIMPLIFIED_FIGURE8_BYTES = (
    start()
    + segment(2000, z=[1500])
    + b"".join(
        segment(2000, [x], [y])
        for x, y in [(1000, 1000), (2000, 0), (1000, -1000), (0, 0), (-1000, 1000), (-2000, 0), (-1000, -1000), (0, 0)]
    )
    + segment(2000, z=[0])
    + END
)

# docs/reference/planner-commander.md#17.2, as packed by cflib 0.1.34, and the end marker
YAW_BYTES = bytes.fromhex(
    "f40106ffe8037cfc 523a025802bc022003b0048403 8c14056400c8002c019001f4015802bc02e803af04a406 000000"
)


class Compressed:
    """A loaded trajectory, which keeps its bytes alive."""

    def __init__(self, data: bytes, t_begin=0.0, shift=(0.0, 0.0, 0.0), size: int | None = None) -> None:
        self.data = ffi.new("uint8_t[]", data or b"\0")
        self.view = ffi.new("struct piecewise_traj_compressed *")
        lib.piecewise_compressed_load(self.view, self.data, len(data) if size is None else size)
        self.view.t_begin = t_begin
        self.view.shift = list(shift)

    @property
    def duration(self) -> float:
        return lib.piecewise_compressed_duration(self.view)

    def is_finished(self, t: float) -> bool:
        return lib.piecewise_compressed_is_finished(self.view, t)

    def at(self, t: float) -> NDArray[np.float64]:
        """Return position, velocity, acceleration, jerk, yaw and body rates."""
        ev = lib.piecewise_compressed_eval(self.view, t)
        return np.array([*xyz(ev.pos), *xyz(ev.vel), *xyz(ev.acc), *xyz(ev.jerk), ev.yaw, *xyz(ev.omega)])


def xyz(v) -> list[float]:
    return [v.x, v.y, v.z]


# --- numbers


@pytest.mark.parametrize("row", FIGURE8_COMPRESSED_GOALS, ids=lambda row: f"t={row[0]}")
def test_compressed_figure8_goal_has_the_expected_numbers(row: NDArray[np.float64]) -> None:
    np.testing.assert_allclose(Compressed(FIGURE8_BYTES).at(row[0]), row[1:], rtol=2e-6, atol=2e-6)


@pytest.mark.parametrize("row", YAW_GOALS, ids=lambda row: f"t={row[0]}")
def test_compressed_yaw_has_the_expected_numbers(row: NDArray[np.float64]) -> None:
    """Yaw is stored in tenths of a degree, not as the firmware read it before July 2026.

    docs/reference/planner-commander.md#5.6.
    """
    goal = Compressed(YAW_BYTES).at(row[0])
    without_jerk = np.delete(goal, range(9, 12))
    np.testing.assert_allclose(without_jerk, row[1:], rtol=2e-7, atol=5e-7)


@pytest.mark.parametrize(
    ("data", "duration"), [(FIGURE8_BYTES, 7.283), (SIMPLIFIED_FIGURE8_BYTES, 20.0), (YAW_BYTES, 1.87)]
)
def test_duration_is_the_sum_of_the_pieces(data: bytes, duration: float) -> None:
    assert Compressed(data).duration == np.float32(duration)


@pytest.mark.parametrize(("data", "fastest"), [(FIGURE8_BYTES, 2.5), (SIMPLIFIED_FIGURE8_BYTES, None)])
def test_compressed_figure8_stays_slow_and_ends_in_time(data: bytes, fastest: float | None) -> None:
    trajectory = Compressed(data, t_begin=2.0, shift=(-1.0, 2.0, 3.0))
    for t in np.arange(1.5, 2.0 + trajectory.duration + 0.5, 0.1, dtype=np.float32):
        goal = trajectory.at(t)
        assert np.isfinite(goal).all()
        if fastest is not None:
            assert np.abs(goal[3:6]).max() <= fastest
        assert trajectory.is_finished(t) == (t - np.float32(2.0) >= np.float32(trajectory.duration))


def test_long_path_of_straight_lines_stays_slow_and_ends_in_time() -> None:
    """The path of its own data is not known, this one has its start and its pieces of 0.5 s.

    docs/reference/planner-commander.md#17.1 "frame".
    """
    corners = [(3000 + 50 * (i % 9), 7000 - 25 * (i % 13), 1000 + 10 * i) for i in range(60)]
    data = start(*corners[0]) + b"".join(segment(500, [x], [y], [z]) for x, y, z in corners[1:]) + END
    trajectory = Compressed(data)
    for t in np.arange(0.0, trajectory.duration, 0.1, dtype=np.float32):
        goal = trajectory.at(t)
        assert np.isfinite(goal).all()
        assert np.abs(goal[3:6]).max() <= 2.5
        assert trajectory.is_finished(t) == (t >= np.float32(trajectory.duration))


@given(st.lists(st.floats(1.5, 9.75, width=32), min_size=1, max_size=10))
def test_compressed_and_uncompressed_figure8_agree_at_any_times(times: list[float]) -> None:
    """Random access of docs/reference/planner-commander.md#17.1: at most 0.02 apart."""
    pieces = ffi.new("struct poly4d[]", len(FIGURE8))
    for piece, row in zip(pieces, FIGURE8, strict=True):
        piece.duration = row[0]
        piece.p[0], piece.p[1] = list(row[1:9]), list(row[9:17])
    uncompressed = ffi.new("struct piecewise_traj *", [2.0, 1.0, [0, 0, 0], 0.0, len(FIGURE8), pieces])
    compressed = Compressed(FIGURE8_BYTES, t_begin=2.0)
    for t in times:
        ev = lib.piecewise_eval(uncompressed, t)
        goal = compressed.at(t)
        np.testing.assert_allclose([*goal[:3], goal[12]], [*xyz(ev.pos), ev.yaw], atol=0.02)


def test_simplified_figure8_passes_its_corners() -> None:
    trajectory = Compressed(SIMPLIFIED_FIGURE8_BYTES)
    corners = {2: (0, 0, 1.5), 4: (1, 1, 1.5), 6: (2, 0, 1.5), 8: (1, -1, 1.5), 10: (0, 0, 1.5), 20: (0, 0, 0)}
    for t, corner in corners.items():
        np.testing.assert_allclose(trajectory.at(t)[:3], corner, atol=1e-5)


# --- curves

points = st.integers(-5000, 5000)
axes = st.sampled_from(LENGTHS).flatmap(lambda n: st.lists(points, min_size=n, max_size=n))
segments = st.lists(st.tuples(st.integers(200, 5000), axes, axes, axes, axes), min_size=1, max_size=4)


@given(st.tuples(points, points, points, points), segments, st.floats(0.0, 1.0))
def test_any_pieces_are_bezier_curves_that_join(begin, pieces, place: float) -> None:
    trajectory = Compressed(start(*begin) + b"".join(segment(*piece) for piece in pieces) + END)
    scale = np.array([1e-3, 1e-3, 1e-3, math.pi / 1800])
    ends = np.array(begin, float)
    begin_s = 0.0
    for duration_ms, *stored in pieces:
        duration = duration_ms / 1000
        t = begin_s + (0.001 + 0.998 * place) * duration  # on a border, rounding decides which piece it is
        expected, slope = np.zeros(4), np.zeros(4)
        for axis in range(4):
            control = np.array([ends[axis], *stored[axis]]) * scale[axis]
            curve = BPoly(control[:, None], [0.0, duration])
            expected[axis], slope[axis] = curve(t - begin_s), curve.derivative()(t - begin_s)
            ends[axis] = stored[axis][-1] if stored[axis] else ends[axis]
        goal = trajectory.at(t)
        np.testing.assert_allclose(goal[[0, 1, 2, 12]], expected, atol=2e-3)
        np.testing.assert_allclose(goal[3:6], slope[:3], atol=0.02 + 0.01 / duration)
        begin_s += duration


@given(st.integers(0, 3), st.floats(-2.0, 30.0, width=32))
def test_play_head_may_jump_anywhere(first: int, t: float) -> None:
    """Random access costs a walk, and gives the same as a fresh walk."""
    moved = Compressed(SIMPLIFIED_FIGURE8_BYTES)
    moved.at(6.0 * first)
    assert moved.at(t).tolist() == Compressed(SIMPLIFIED_FIGURE8_BYTES).at(t).tolist()


def test_exact_joint_belongs_to_the_later_piece() -> None:
    trajectory = Compressed(start() + segment(1000, [1000]) + segment(1000, [0]) + END)
    assert trajectory.at(np.nextafter(np.float32(1.0), np.float32(0.0)))[3] == 1.0
    assert trajectory.at(1.0)[3] == -1.0


def test_trajectory_stands_still_behind_its_end() -> None:
    goal = Compressed(YAW_BYTES, shift=(1.0, 2.0, 3.0)).at(1e6)
    assert goal[:3] == pytest.approx([1.8, 2.7, 4.2], abs=1e-6)
    assert not goal[3:12].any()
    assert goal[12] == pytest.approx(math.radians(170), abs=1e-6)


def test_first_piece_goes_on_backwards_before_the_begin() -> None:
    trajectory = Compressed(start() + segment(1000, [1000]) + END, t_begin=5.0)
    assert trajectory.at(4.5)[0] == pytest.approx(-0.5)


def test_timescale_and_yaw_shift_are_ignored() -> None:
    trajectory = Compressed(YAW_BYTES)
    before = trajectory.at(0.3).tolist()
    trajectory.view.timescale, trajectory.view.shift_yaw = 3.0, 1.0
    assert trajectory.at(0.3).tolist() == before
    assert trajectory.duration == np.float32(1.87)


# --- bytes that are no trajectory


@pytest.mark.parametrize("size", range(8))
def test_bytes_without_a_start_record_have_no_goal(size: int) -> None:
    trajectory = Compressed(bytes(size))
    assert np.isnan(trajectory.at(0.0)[:3]).all()
    assert trajectory.duration == 0.0
    assert trajectory.is_finished(0.0)


@pytest.mark.parametrize("tail", [b"", b"\0", b"\0\0", END, b"\xff\0\0"])
def test_start_without_pieces_is_a_place_to_stay(tail: bytes) -> None:
    trajectory = Compressed(start(1000, 2000, 3000, 900) + tail)
    assert trajectory.duration == 0.0
    goal = trajectory.at(1.0)
    assert goal[[0, 1, 2]].tolist() == [1.0, 2.0, 3.0]
    assert goal[12] == pytest.approx(math.pi / 2)
    assert not goal[3:12].any()


@pytest.mark.parametrize("missing", range(1, 14))
def test_piece_that_does_not_end_within_the_bytes_ends_the_trajectory(missing: int) -> None:
    whole = start() + segment(1000, [1000]) + segment(1000, [0, 0, 500], [1], [2])
    trajectory = Compressed(whole, size=len(whole) - missing)
    assert trajectory.duration == 1.0
    assert trajectory.at(2.0)[:3].tolist() == [1.0, 0.0, 0.0]


def test_stale_bytes_behind_a_trajectory_without_end_marker_are_pieces() -> None:
    """What cflib's uploads do, because it appends no end marker (docs/reference/planner-commander.md#5.1)."""
    without = start() + segment(1000, [1000])
    assert Compressed(without + segment(2000, [0]) + END).duration == 3.0
    assert Compressed(without + END + segment(2000, [0])).duration == 1.0


@given(st.binary(max_size=400), st.lists(st.floats(-10.0, 200.0, width=32), min_size=1, max_size=8))
def test_any_bytes_give_finite_goals(data: bytes, times: list[float]) -> None:
    trajectory = Compressed(data)
    assert 0.0 <= trajectory.duration < 400 / 3 * 65.6
    for t in times:
        goal = trajectory.at(max(t, 0.0))
        assert np.isfinite(goal[:13]).all() == (len(data) >= 8)


def test_time_that_is_no_number_moves_nothing_out_of_bounds() -> None:
    trajectory = Compressed(YAW_BYTES)
    for t in [math.nan, math.inf, -math.inf, 3e38, -3e38]:
        trajectory.at(t)
    assert trajectory.at(0.25)[0] == pytest.approx(YAW_GOALS[1][1], rel=1e-6)
