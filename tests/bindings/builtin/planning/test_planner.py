"""The planner's states and plans against derived numbers (docs/reference/planner-commander.md#6 and #17)."""

import math
import struct
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from crazychoir_fw._core import ffi, lib

DATA = Path(__file__).parent / "data"
TAKEOFF = np.loadtxt(DATA / "takeoff.csv", delimiter=",")
GO_TO_SMOOTH = np.loadtxt(DATA / "go_to_smooth.csv", delimiter=",")
FIGURE8 = np.loadtxt(DATA / "figure8.csv", delimiter=",")

IDLE = lib.TRAJECTORY_STATE_IDLE
FLYING = lib.TRAJECTORY_STATE_FLYING
LANDING = lib.TRAJECTORY_STATE_LANDING
DISABLED = lib.TRAJECTORY_STATE_DISABLED


def xyz(v) -> list[float]:
    return [v.x, v.y, v.z]


def as_row(ev) -> NDArray[np.float64]:
    """Return position, velocity, acceleration, jerk, yaw and body rates in the order of the data files."""
    return np.array([*xyz(ev.pos), *xyz(ev.vel), *xyz(ev.acc), *xyz(ev.jerk), ev.yaw, *xyz(ev.omega)])


def is_valid(ev) -> bool:
    return lib.is_traj_eval_valid(ffi.new("struct traj_eval *", ev))


def start_at(pos=(0.0, 0.0, 0.0), vel=(0.0, 0.0, 0.0), yaw=0.0):
    return ffi.new("cf_plan_start_t *", [list(pos), list(vel), yaw])


def uploaded(
    offset=0,
    n_pieces=10,
    timescale=1.0,
    reversed=False,
    relative_position=False,
    relative_yaw=False,
    type=lib.CF_TRAJECTORY_TYPE_POLY4D,
):
    return ffi.new(
        "cf_uploaded_trajectory_t *", [type, offset, n_pieces, timescale, reversed, relative_position, relative_yaw]
    )


@pytest.fixture
def planner():
    planner = ffi.new("cf_planner_t *")
    lib.cf_planner_init(planner)
    return planner


@pytest.fixture
def memory():
    """Trajectory memory with the figure-8 behind 132 bytes of something else."""
    memory = ffi.new("uint8_t[]", 4096)
    pieces = np.zeros((10, 33), dtype="<f4")
    pieces[:, 32] = FIGURE8[:, 0]
    pieces[:, 0:16] = FIGURE8[:, 1:]
    ffi.buffer(memory)[132 : 132 + pieces.nbytes] = pieces.tobytes()
    return memory


# --- states


def test_fresh_planner_is_idle_and_finished(planner) -> None:
    assert lib.cf_planner_state(planner) == IDLE
    assert lib.cf_planner_is_stopped(planner)
    assert not lib.cf_planner_is_disabled(planner)
    assert lib.cf_planner_is_finished(planner, ffi.NULL, 0.0)
    assert not is_valid(lib.cf_planner_current_goal(planner, ffi.NULL, 0.0))


# rows: state, then the answers (0 planned, 1 refused) to take-off, land and go-to
@pytest.mark.parametrize(
    ("state", "takeoff", "land", "go_to"), [(IDLE, 0, 0, 0), (FLYING, 1, 0, 0), (LANDING, 1, 1, 0), (DISABLED, 1, 0, 0)]
)
def test_state_decides_which_plans_are_refused(state: int, takeoff: int, land: int, go_to: int) -> None:
    def planner_in_state():
        planner = ffi.new("cf_planner_t *")
        lib.cf_planner_init(planner)
        lib.cf_planner_takeoff(planner, start_at(), 1.0, 0.0, 2.0, 0.0)
        planner.state = state
        return planner

    p = planner_in_state()
    assert lib.cf_planner_takeoff(p, start_at(), 1.0, 0.0, 2.0, 0.5) == takeoff
    assert lib.cf_planner_state(p) == (state if takeoff else FLYING)
    p = planner_in_state()
    assert lib.cf_planner_land(p, start_at(), 0.0, 0.0, 2.0, 0.5) == land
    assert lib.cf_planner_state(p) == LANDING
    p = planner_in_state()
    assert lib.cf_planner_go_to(p, ffi.NULL, start_at(), False, False, [0, 0, 1], 0.0, 2.0, 0.5) == go_to
    assert lib.cf_planner_state(p) == FLYING


def test_refused_takeoff_leaves_the_plan_alone(planner) -> None:
    lib.cf_planner_takeoff(planner, start_at(), 1.0, 0.0, 2.0, 0.0)
    before = bytes(ffi.buffer(planner))
    assert lib.cf_planner_takeoff(planner, start_at((9, 9, 9)), 5.0, 1.0, 3.0, 1.0) == 1
    assert bytes(ffi.buffer(planner)) == before


def test_landing_makes_the_planner_idle_at_its_end_and_still_answers(planner) -> None:
    lib.cf_planner_land(planner, start_at((0, 0, 1)), 0.0, 0.0, 2.0, 10.0)
    assert is_valid(lib.cf_planner_current_goal(planner, ffi.NULL, 11.99))
    assert lib.cf_planner_state(planner) == LANDING
    last = lib.cf_planner_current_goal(planner, ffi.NULL, 12.0)
    assert xyz(last.pos) == [0.0, 0.0, 0.0]
    assert lib.cf_planner_state(planner) == IDLE
    assert not is_valid(lib.cf_planner_current_goal(planner, ffi.NULL, 12.0))


def test_takeoff_hovers_at_its_end(planner) -> None:
    lib.cf_planner_takeoff(planner, start_at(), 1.0, 0.0, 2.0, 0.0)
    assert not lib.cf_planner_is_finished(planner, ffi.NULL, 1.99)
    assert lib.cf_planner_is_finished(planner, ffi.NULL, 2.0)
    goal = lib.cf_planner_current_goal(planner, ffi.NULL, 100.0)
    assert as_row(goal).tolist() == [0.0, 0.0, 1.0, *[0.0] * 13]
    assert lib.cf_planner_state(planner) == FLYING


def test_stopped_and_disabled_planners_have_no_goal(planner) -> None:
    for end in (lib.cf_planner_stop, lib.cf_planner_disable):
        lib.cf_planner_init(planner)
        lib.cf_planner_takeoff(planner, start_at(), 1.0, 0.0, 2.0, 0.0)
        end(planner)
        assert not is_valid(lib.cf_planner_current_goal(planner, ffi.NULL, 1.0))
    assert lib.cf_planner_is_disabled(planner)
    assert lib.cf_planner_state(planner) == DISABLED


# --- take-off


@pytest.mark.parametrize("row", TAKEOFF, ids=lambda row: f"t={row[0]}")
def test_takeoff_has_the_expected_numbers(planner, row: NDArray[np.float64]) -> None:
    assert lib.cf_planner_takeoff(planner, start_at(), 1.0, 0.0, 2.0, 0.0) == 0
    np.testing.assert_allclose(as_row(lib.cf_planner_current_goal(planner, ffi.NULL, row[0])), row[1:], rtol=1e-7)


def test_takeoff_polynomial_has_the_expected_numbers(planner) -> None:
    lib.cf_planner_takeoff(planner, start_at(), 1.0, 0.0, 2.0, 0.0)
    assert list(planner.planned.p[2]) == [0, 0, 0, 0, 2.1875, -2.625, 1.09375, -0.15625]


@given(st.floats(-3.0, 3.0, width=32), st.floats(-3.0, 3.0, width=32))
def test_takeoff_turns_the_short_way_and_ignores_start_velocity(yaw: float, goal_yaw: float) -> None:
    planner = ffi.new("cf_planner_t *")
    lib.cf_planner_init(planner)
    lib.cf_planner_takeoff(planner, start_at((1, 2, 0), (5, 5, 5), yaw), 1.0, goal_yaw, 2.0, 7.0)
    first = lib.cf_planner_current_goal(planner, ffi.NULL, 7.0)
    last = lib.cf_planner_current_goal(planner, ffi.NULL, 9.5)
    assert xyz(first.vel) == [0.0, 0.0, 0.0]
    assert first.yaw == pytest.approx(yaw, abs=1e-6)
    assert xyz(last.pos) == pytest.approx([1.0, 2.0, 1.0], abs=1e-5)
    assert abs(last.yaw - first.yaw) <= math.pi + 1e-5
    assert math.remainder(last.yaw - goal_yaw, 2 * math.pi) == pytest.approx(0.0, abs=1e-4)


# --- go-to


def flying_through_start(planner) -> None:
    """Make the current goal at t = 0 the start of the reference's smooth go-to: body rate z is 0.1 rad/s there."""
    lib.cf_planner_takeoff(planner, start_at(), 1.0, 0.0, 2.0, 0.0)
    up = 9.81 / np.linalg.norm([0.2, -0.1, 9.81])
    axes = [(1.0, 0.3, 0.1), (-0.5, 0.0, -0.05), (1.0, -0.1, 0.0), (0.2, 0.1 / up, 0.0)]
    for axis, p in zip(planner.planned.p, axes, strict=True):
        axis[0:8] = [*p, 0.0, 0.0, 0.0, 0.0, 0.0]


# docs/reference/planner-commander.md#17.2
GO_TO_SMOOTH_COEFFICIENTS = [
    [1, 0.300000012, 0.100000001, 0, 0.0987654179, -0.104938269, 0.0330589823, -0.00338363042],
    [-0.5, 0, -0.0500000007, 0, 0.703703701, -0.555555582, 0.153292179, -0.0145404665],
    [1, -0.100000001, 0, 0, -0.141975313, 0.117283948, -0.0331961587, 0.00320073171],
    [0.200000048, 0.100000001, 0, 0, 0.358024776, -0.290123552, 0.0812071562, -0.00777320703],
]


def test_smooth_go_to_has_the_expected_polynomials(planner) -> None:
    flying_through_start(planner)
    assert lib.cf_planner_go_to(planner, ffi.NULL, start_at(), False, False, [2, 1, 0.5], 1.2, 3.0, 0.0) == 0
    np.testing.assert_allclose([list(axis) for axis in planner.planned.p], GO_TO_SMOOTH_COEFFICIENTS, rtol=2e-7)


@pytest.mark.parametrize("row", GO_TO_SMOOTH, ids=lambda row: f"t={row[0]}")
def test_smooth_go_to_has_the_expected_numbers(planner, row: NDArray[np.float64]) -> None:
    flying_through_start(planner)
    lib.cf_planner_go_to(planner, ffi.NULL, start_at(), False, False, [2, 1, 0.5], 1.2, 3.0, 0.0)
    goal = lib.cf_planner_current_goal(planner, ffi.NULL, row[0])
    # a few units in the last place of the largest intermediate of the polynomials
    np.testing.assert_allclose(as_row(goal), row[1:], rtol=1e-6, atol=2e-6)


def test_linear_go_to_has_the_expected_polynomials(planner) -> None:
    start = start_at((0, 0, 1))
    assert lib.cf_planner_go_to(planner, ffi.NULL, start, False, True, [1, 2, 1.5], 1.0, 4.0, 0.0) == 0
    x, y, z, yaw = [list(axis) for axis in planner.planned.p]
    assert x == [0, 0.25, 0, 0, 0, 0, 0, 0]
    assert y == [0, 0.5, 0, 0, 0, 0, 0, 0]
    assert z == [1, 0.125, 0, 0, 0, 0, 0, 0]
    np.testing.assert_allclose(yaw, [0, 0.25000006, 0, 0, 4.65661287e-9, -3.7252903e-9, 0, 0], rtol=1e-7)


@pytest.mark.parametrize("state", [IDLE, DISABLED])
def test_go_to_starts_at_the_given_state_when_nothing_is_flown(planner, state: int) -> None:
    planner.state = state
    start = start_at((1, 2, 3), (0.5, 0.25, -0.5), 0.5)
    lib.cf_planner_go_to(planner, ffi.NULL, start, True, False, [1, 1, 1], 0.25, 2.0, 5.0)
    first = lib.cf_planner_current_goal(planner, ffi.NULL, 5.0)
    assert [xyz(first.pos), xyz(first.vel), xyz(first.acc)] == [[1, 2, 3], [0.5, 0.25, -0.5], [0, 0, 0]]
    last = lib.cf_planner_current_goal(planner, ffi.NULL, 8.0)
    assert [*xyz(last.pos), last.yaw] == pytest.approx([2.0, 3.0, 4.0, 0.75], abs=2e-5)


def test_go_to_while_flying_starts_at_the_current_goal(planner) -> None:
    lib.cf_planner_takeoff(planner, start_at(), 1.0, 0.0, 2.0, 0.0)
    before = lib.cf_planner_current_goal(planner, ffi.NULL, 0.75)
    lib.cf_planner_go_to(planner, ffi.NULL, start_at((9, 9, 9), (9, 9, 9), 1.0), True, False, [1, 0, 0], 0.5, 2.0, 0.75)
    after = lib.cf_planner_current_goal(planner, ffi.NULL, 0.75)
    assert [xyz(after.pos), xyz(after.vel), xyz(after.acc)] == [xyz(before.pos), xyz(before.vel), xyz(before.acc)]
    last = lib.cf_planner_current_goal(planner, ffi.NULL, 3.0)
    assert [*xyz(last.pos), last.yaw] == pytest.approx([1.0, 0.0, before.pos.z, 0.5], abs=1e-5)


# --- uploaded trajectories


def test_uploaded_trajectory_is_read_at_its_offset(planner, memory) -> None:
    assert lib.cf_planner_start_trajectory(planner, memory, uploaded(offset=132), start_at((5, 5, 5)), 10.0) == 0
    assert lib.cf_planner_state(planner) == FLYING
    # docs/reference/planner-commander.md#17.2, figure-8 at t = 2
    goal = lib.cf_planner_current_goal(planner, memory, 12.0)
    assert xyz(goal.pos) == pytest.approx([0.98464, -0.047883496, 0.0], rel=1e-6)
    assert not lib.cf_planner_is_finished(planner, memory, 17.2)
    assert lib.cf_planner_is_finished(planner, memory, 17.3)


def test_uploaded_trajectory_survives_moving_the_memory(planner, memory) -> None:
    lib.cf_planner_start_trajectory(planner, memory, uploaded(offset=132), start_at(), 0.0)
    before = as_row(lib.cf_planner_current_goal(planner, memory, 3.0))
    moved = ffi.new("uint8_t[]", bytes(ffi.buffer(memory)))
    assert as_row(lib.cf_planner_current_goal(planner, moved, 3.0)).tolist() == before.tolist()


@pytest.mark.parametrize("reversed", [False, True])
def test_relative_trajectory_starts_here(planner, memory, reversed: bool) -> None:
    trajectory = uploaded(offset=132, reversed=reversed, relative_position=True)
    lib.cf_planner_start_trajectory(planner, memory, trajectory, start_at((1, 2, 3)), 4.0)
    goal = lib.cf_planner_current_goal(planner, memory, 4.0)
    assert xyz(goal.pos) == pytest.approx([1.0, 2.0, 3.0], abs=1e-6)


def test_yaw_relative_trajectory_is_turned_about_the_origin(planner, memory) -> None:
    trajectory = uploaded(offset=132, relative_position=True, relative_yaw=True)
    lib.cf_planner_start_trajectory(planner, memory, trajectory, start_at((1, 2, 3), yaw=math.pi / 2), 0.0)
    goal = lib.cf_planner_current_goal(planner, memory, 2.0)
    assert goal.yaw == pytest.approx(math.pi / 2, rel=1e-6)
    assert xyz(goal.pos) == pytest.approx([1.0 + 0.047883496, 2.0 + 0.98464, 3.0], rel=1e-6)
    # jerk stays unturned (docs/reference/planner-commander.md#4.7)
    assert goal.jerk.x == pytest.approx(-0.76503682, rel=1e-5)


def test_absolute_trajectory_ignores_yaw_alignment(planner, memory) -> None:
    trajectory = uploaded(offset=132, relative_yaw=True)
    lib.cf_planner_start_trajectory(planner, memory, trajectory, start_at((1, 2, 3), yaw=1.0), 0.0)
    assert lib.cf_planner_current_goal(planner, memory, 0.0).yaw == 0.0


def test_plan_after_a_turned_trajectory_is_not_turned(planner, memory) -> None:
    trajectory = uploaded(offset=132, timescale=2.0, relative_position=True, relative_yaw=True)
    lib.cf_planner_start_trajectory(planner, memory, trajectory, start_at((1, 2, 3), yaw=1.0), 0.0)
    lib.cf_planner_go_to(planner, memory, start_at(), False, False, [2, 0, 1], 0.0, 1.0, 5.0)
    goal = lib.cf_planner_current_goal(planner, memory, 6.5)
    assert [*xyz(goal.pos), goal.yaw] == pytest.approx([2.0, 0.0, 1.0, 0.0], abs=2e-5)


# --- compressed trajectories


COMPRESSED = lib.CF_TRAJECTORY_TYPE_POLY4D_COMPRESSED

# from (1, 2, 0) m and 90 deg: 1 s along x, 1 s along y while turning to 0
LINES = struct.pack("<4h", 1000, 2000, 0, 900) + struct.pack("<BHh", 1, 1000, 2000)
LINES += struct.pack("<BHhh", 0x44, 1000, 3000, 0) + bytes(3)


def test_compressed_trajectory_is_read_at_any_offset(planner, memory) -> None:
    ffi.buffer(memory)[133 : 133 + len(LINES)] = LINES
    trajectory = uploaded(type=COMPRESSED, offset=133)
    assert lib.cf_planner_start_trajectory(planner, memory, trajectory, start_at((9, 9, 9)), 10.0) == 0
    assert lib.cf_planner_state(planner) == FLYING
    goal = lib.cf_planner_current_goal(planner, memory, 10.5)
    assert [xyz(goal.pos), xyz(goal.vel), goal.yaw] == [[1.5, 2, 0], [1, 0, 0], pytest.approx(math.pi / 2)]
    goal = lib.cf_planner_current_goal(planner, memory, 11.5)
    assert [xyz(goal.pos), xyz(goal.vel)] == [[2, 2.5, 0], [0, 1, 0]]
    assert goal.yaw == pytest.approx(math.pi / 4, rel=1e-6)
    assert not lib.cf_planner_is_finished(planner, memory, 11.99)
    assert lib.cf_planner_is_finished(planner, memory, 12.0)
    assert xyz(lib.cf_planner_current_goal(planner, memory, 100.0).pos) == [2, 3, 0]


def test_compressed_trajectory_survives_moving_the_memory_and_the_planner(planner, memory) -> None:
    ffi.buffer(memory)[0 : len(LINES)] = LINES
    lib.cf_planner_start_trajectory(planner, memory, uploaded(type=COMPRESSED), start_at(), 0.0)
    lib.cf_planner_current_goal(planner, memory, 1.25)
    moved_memory = ffi.new("uint8_t[]", bytes(ffi.buffer(memory)))
    moved = ffi.new("cf_planner_t *", planner[0])
    for t in (1.5, 0.5):
        expected = as_row(lib.cf_planner_current_goal(planner, memory, t)).tolist()
        assert as_row(lib.cf_planner_current_goal(moved, moved_memory, t)).tolist() == expected


def test_relative_compressed_trajectory_starts_here_and_keeps_its_yaw_and_pace(planner, memory) -> None:
    """docs/reference/planner-commander.md#6.7; what the high-level commander refuses has no effect."""
    ffi.buffer(memory)[0 : len(LINES)] = LINES
    trajectory = uploaded(
        type=COMPRESSED, timescale=2.0, reversed=True, relative_position=True, relative_yaw=True, n_pieces=0
    )
    lib.cf_planner_start_trajectory(planner, memory, trajectory, start_at((5, 6, 7), yaw=1.0), 3.0)
    first = lib.cf_planner_current_goal(planner, memory, 3.0)
    assert [*xyz(first.pos), first.yaw] == [5, 6, 7, pytest.approx(math.pi / 2)]
    assert xyz(lib.cf_planner_current_goal(planner, memory, 4.0).pos) == [6, 6, 7]


@pytest.mark.parametrize("offset", [4089, 4095, 4096, 4097, 2**32 - 1])
def test_compressed_trajectory_without_room_for_a_start_is_refused(planner, memory, offset: int) -> None:
    lib.cf_planner_takeoff(planner, start_at(), 1.0, 0.0, 2.0, 0.0)
    before = bytes(ffi.buffer(planner))
    assert (
        lib.cf_planner_start_trajectory(planner, memory, uploaded(type=COMPRESSED, offset=offset), start_at(), 0) == 1
    )
    assert bytes(ffi.buffer(planner)) == before


def test_compressed_start_may_be_the_last_bytes_of_the_memory(planner, memory) -> None:
    ffi.buffer(memory)[4088:4096] = LINES[:8]
    assert lib.cf_planner_start_trajectory(planner, memory, uploaded(type=COMPRESSED, offset=4088), start_at(), 0) == 0
    assert xyz(lib.cf_planner_current_goal(planner, memory, 5.0).pos) == [1, 2, 0]


def test_plan_after_a_compressed_trajectory_is_flown(planner, memory) -> None:
    ffi.buffer(memory)[0 : len(LINES)] = LINES
    lib.cf_planner_start_trajectory(planner, memory, uploaded(type=COMPRESSED), start_at(), 0.0)
    lib.cf_planner_go_to(planner, memory, start_at((9, 9, 9)), False, False, [0, 0, 1], 0.0, 2.0, 0.5)
    begin = lib.cf_planner_current_goal(planner, memory, 0.5)
    assert [xyz(begin.pos), xyz(begin.vel)] == [[1.5, 2, 0], [1, 0, 0]]
    end = lib.cf_planner_current_goal(planner, memory, 3.0)
    assert [*xyz(end.pos), end.yaw] == pytest.approx([0, 0, 1, 0], abs=1e-5)


# --- goals that are no numbers


def test_go_to_from_a_goal_that_is_no_number_starts_at_the_given_state(planner) -> None:
    lib.cf_planner_takeoff(planner, start_at(), 1.0, 0.0, 2.0, 0.0)
    planner.planned.p[1][0] = math.nan
    lib.cf_planner_go_to(planner, ffi.NULL, start_at((1, 2, 3)), False, False, [1, 2, 4], 0.0, 2.0, 1.0)
    assert xyz(lib.cf_planner_current_goal(planner, ffi.NULL, 1.0).pos) == [1.0, 2.0, 3.0]


def test_trajectory_of_nan_has_no_goal(planner, memory) -> None:
    ffi.buffer(memory)[:] = np.full(1024, np.nan, dtype="<f4").tobytes()
    lib.cf_planner_start_trajectory(planner, memory, uploaded(), start_at(), 0.0)
    assert not is_valid(lib.cf_planner_current_goal(planner, memory, 0.5))
    assert not lib.cf_planner_is_finished(planner, memory, 1e9)
