"""Collision avoidance: the table of docs/reference/planner-commander.md#17.2, and what must hold for every cell."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crazychoir_fw._core import ffi, lib

FLT_MAX = float(np.finfo(np.float32).max)
ORIGIN = (0.0, 0.0, 0.0)
SHARED, APART = "otherPositions within the workspace", "otherPositions apart"


class Avoidance:
    """One drone's collision avoidance with the stock parameters, switched on."""

    def __init__(self, last_feasible=None, **parameters):
        self.state = ffi.new("cf_collision_avoidance_t *")
        lib.cf_collision_avoidance_init(self.state)
        self.state.enable = 1
        for name, value in parameters.items():
            setattr(self.state.params, name, value)
        if last_feasible is not None:
            self.state.state.lastFeasibleSetPosition = vector(last_feasible)

    def core(self, mode, peers=(), position=ORIGIN, velocity=ORIGIN, own=ORIGIN, memory=SHARED):
        """Run the pure core; returns position and velocity of the setpoint."""
        flat = [float(x) for peer in peers for x in peer]
        self.workspace = ffi.new("float[]", 7 * (len(peers) + 6))
        others = self.workspace
        if memory == SHARED:
            self.workspace[0 : len(flat)] = flat
        else:
            others = ffi.new("float[]", flat or [0.0])
        target, estimate = setpoint(mode, position, velocity), ffi.new("state_t *", {"position": vector(own)})
        lib.collisionAvoidanceUpdateSetpointCore(
            ffi.addressof(self.state, "params"),
            ffi.addressof(self.state, "state"),
            len(peers),
            others,
            self.workspace,
            target,
            ffi.NULL,
            estimate,
        )
        return numbers(target.position), numbers(target.velocity)

    def update(self, target, table, now=0, own=ORIGIN):
        """Run what the drone runs, on a table of (id, position, timestamp)."""
        peers = ffi.new("cf_peer_t[]", [{"id": i, "pos": {**vector(at), "timestamp": t}} for i, at, t in table])
        estimate = ffi.new("state_t *", {"position": vector(own)})
        lib.cf_collision_avoidance_update(self.state, target, peers, len(table), ffi.NULL, estimate, now)
        return numbers(target.position), numbers(target.velocity)

    def row(self, i, count):
        """Return row i of the cell that the last call of `core` made."""
        rows = count + 6
        return (*self.workspace[3 * i : 3 * i + 3], self.workspace[3 * rows + i])

    @property
    def last_feasible(self):
        return numbers(self.state.state.lastFeasibleSetPosition)


def vector(xyz):
    return dict(zip("xyz", map(float, xyz), strict=True))


def numbers(v):
    return (v.x, v.y, v.z)


def setpoint(mode, position=ORIGIN, velocity=ORIGIN):
    return ffi.new("setpoint_t *", {"mode": {"x": mode}, "position": vector(position), "velocity": vector(velocity)})


# one float32 rounding of what the table prints; zeros are exact
def near(expected):
    return pytest.approx(expected, rel=1e-7, abs=0)


# case: peers, mode, own position, last feasible position, position and velocity asked for, and what comes out
TABLE = {
    "A": ([], lib.modeAbs, ORIGIN, None, (2, 0, 0), ORIGIN, (0.5, 0, 0), ORIGIN),
    "B": ([(1, 0, 0)], lib.modeAbs, ORIGIN, None, (2, 0, 0), ORIGIN, (0.20000005, -0.079999991, 0), ORIGIN),
    "C": ([(1, 0, 0)], lib.modeVelocity, ORIGIN, None, ORIGIN, (1, 0, 0), ORIGIN, (0.19999999, -0.039999995, 0)),
    "D": ([(0.4, 0, 0)], lib.modeVelocity, ORIGIN, None, ORIGIN, (1, 0, 0), ORIGIN, (-0.099999987, 0, 0)),
    "E": ([(1, 0, 0)], lib.modeAbs, ORIGIN, None, (0.1, 0, 0), (1, 0, 0), (0.1, 0, 0), (0.1, 0, 0)),
    "F": (
        [(0.5, 0.5, 1.5)],
        lib.modeAbs,
        (0, 0, 1),
        None,
        (1, 1, 1.2),
        ORIGIN,
        (0.5, -0.41957933, 1.1031792),
        ORIGIN,
    ),
    "G": ([(0.4, 0, 0), (-0.4, 0, 0)], lib.modeAbs, ORIGIN, None, (1, 0, 0), ORIGIN, ORIGIN, ORIGIN),
    "G2": (
        [(0.4, 0, 0), (-0.4, 0, 0)],
        lib.modeAbs,
        ORIGIN,
        (0.05, 0, 0),
        (1, 0, 0),
        (0.2, 0, 0),
        (0.05, 0, 0),
        ORIGIN,
    ),
    "H": ([(1, 0, 0)], lib.modeAbs, ORIGIN, None, (0.4, 0.1, 0), (1, 0, 0), (0.2, 0.087696902, 0), ORIGIN),
    "I": ([], lib.modeVelocity, ORIGIN, None, ORIGIN, (2, 1, 0), ORIGIN, (0.5, 0.5, 0)),
    "J": ([(-0.2, 0.7, 0.1), (0.7, -0.7, 0.4)], lib.modeAbs, ORIGIN, None, (0.8, 0.7, 0), ORIGIN, ORIGIN, ORIGIN),
}


@pytest.mark.parametrize("memory", [SHARED, APART])
@pytest.mark.parametrize("case", TABLE.values(), ids=TABLE)
def test_expected_numbers(case, memory):
    peers, mode, own, last, position, velocity, position_out, velocity_out = case
    got_position, got_velocity = Avoidance(last).core(mode, peers, position, velocity, own, memory)
    assert got_position == near(position_out)
    assert got_velocity == near(velocity_out)


@pytest.mark.parametrize(
    ("peers", "own", "expected"),
    [
        ([(1, 0, 0)], ORIGIN, (1, 0, 0, 0.2)),
        ([(0.4, 0, 0)], ORIGIN, (1, 0, 0, -0.099999987)),
        ([(0.5, 0.5, 1.5)], (0, 0, 1), (0.70493442, 0.70493442, 0.078326061, 0.064774908)),
    ],
)
def test_row_of_a_peer(peers, own, expected):
    avoidance = Avoidance()
    avoidance.core(lib.modeVelocity, peers, own=own)
    assert avoidance.row(0, len(peers)) == near(expected)


def sweeps_of(name, most):
    """Return the fewest sweeps that give what `most` give."""
    peers, mode, own, last, position, velocity, *_ = TABLE[name]

    def result(sweeps):
        return Avoidance(last, voronoiProjectionMaxIters=sweeps).core(mode, peers, position, velocity, own)

    final = result(most)
    return next(n for n in range(1, most + 1) if result(n) == final and result(n + 1) == final)


def test_case_f_takes_16_sweeps():
    assert sweeps_of("F", 100) == 16


def test_case_j_would_arrive_after_581_sweeps():
    peers, mode, own, last, position, *_ = TABLE["J"]
    ended = Avoidance(last, voronoiProjectionMaxIters=5000).core(mode, peers, position, ORIGIN, own)[0]
    assert ended == pytest.approx((0.49928, 0.21068, -0.06292), abs=1.5e-5)
    assert Avoidance(last, voronoiProjectionMaxIters=581).core(mode, peers, position, ORIGIN, own)[0] == ended
    assert Avoidance(last, voronoiProjectionMaxIters=580).core(mode, peers, position, ORIGIN, own)[0] != ended


@pytest.mark.parametrize("mode", [lib.modeDisable, 7])
def test_other_modes_change_nothing(mode):
    avoidance = Avoidance()
    result = avoidance.core(mode, [(0.1, 0, 0)], (9, 8, 7), (6, 5, 4))
    assert result == ((9, 8, 7), (6, 5, 4))
    assert all(math.isnan(x) for x in avoidance.last_feasible)


def test_velocity_mode_remembers_the_own_position():
    avoidance = Avoidance()
    avoidance.core(lib.modeVelocity, [(1.4, 2, 3)], velocity=(1, 0, 0), own=(1, 2, 3))
    assert avoidance.last_feasible == (1, 2, 3)


def test_position_mode_remembers_what_it_asks_for():
    avoidance = Avoidance()
    position, _ = avoidance.core(lib.modeAbs, [(1, 0, 0)], (2, 0, 0))
    assert avoidance.last_feasible == position


def test_stuck_drone_keeps_its_first_place():
    """Where there was no feasible position yet, the own one becomes it."""
    avoidance = Avoidance()
    between = [(0.4, 0, 0), (-0.4, 0, 0)]
    avoidance.core(lib.modeAbs, between, (1, 0, 0))
    position, _ = avoidance.core(lib.modeAbs, between, (1, 0, 0), own=(0.01, 0, 0))
    assert position == ORIGIN


def test_velocity_between_two_peers_is_zero():
    velocity = Avoidance().core(lib.modeVelocity, [(0.4, 0, 0), (-0.4, 0, 0)], velocity=(0, 1, 0))[1]
    assert velocity == ORIGIN


def test_way_out_is_no_faster_than_the_largest_speed():
    """The wall is 0.12 m behind the drone, less on each axis than the box allows."""
    peer = (0.36 * math.sqrt(0.5), 0.36 * math.sqrt(0.5), 0)
    fast = Avoidance(maxSpeed=0.2).core(lib.modeVelocity, [peer], velocity=(1, 0, 0))[1]
    slow = Avoidance(maxSpeed=0.1).core(lib.modeVelocity, [peer], velocity=(1, 0, 0))[1]
    assert fast == pytest.approx((-0.12 * math.sqrt(0.5), -0.12 * math.sqrt(0.5), 0), abs=1e-5)
    assert slow == pytest.approx((-0.1 * math.sqrt(0.5), -0.1 * math.sqrt(0.5), 0), abs=1e-5)


def test_drone_stays_in_the_box():
    avoidance = Avoidance(bboxMin=(-1, -1, 0), bboxMax=(1, 1, 2))
    assert avoidance.core(lib.modeAbs, [], (3, 0.6, 1), own=(0.8, 0.6, 1))[0][0] == pytest.approx(1.0, abs=1e-5)
    assert avoidance.core(lib.modeVelocity, [], velocity=(0, 0, -1), own=(0, 0, 0.1))[1][2] == pytest.approx(-0.1)


def test_two_that_meet_turn_to_their_right():
    left_to_right = Avoidance().core(lib.modeVelocity, [(0.9, 0, 0)], velocity=(1, 0, 0))[1]
    right_to_left = Avoidance().core(lib.modeVelocity, [(0, 0, 0)], velocity=(-1, 0, 0), own=(0.9, 0, 0))[1]
    assert left_to_right[1] < -0.01
    assert right_to_left[1] > 0.01


# ------------------------------------------------------------------------------------------------- for every cell

metres = st.floats(-4, 4, width=32)
points = st.tuples(metres, metres, metres)
swarms = st.lists(points, max_size=10)
modes = st.sampled_from([lib.modeAbs, lib.modeVelocity])


def cell(peers, own, radii=(0.3, 0.3, 0.9), reach=0.5):
    """Return normals and distances of the cell in double precision, relative to the own position."""
    rows = []
    for peer in peers:
        u = (np.array(peer) - own) / radii
        d = np.linalg.norm(u)
        normal = u / radii / d
        rows.append((normal / np.linalg.norm(normal), (d / 2 - 1) / np.linalg.norm(normal)))
    rows += [(sign * axis, reach) for sign in (1, -1) for axis in np.eye(3)]
    return np.array([row for row, _ in rows]), np.array([distance for _, distance in rows])


def are_apart(peers, own):
    return all(np.linalg.norm(np.array(peer) - own) > 1e-2 for peer in peers)


@given(mode=modes, peers=swarms, own=points, position=points, velocity=points)
def test_result_is_inside_of_the_cell(mode, peers, own, position, velocity):
    """Or, where no way in was found, the setpoint is to stay; or the drone leaves a margin at its max speed."""
    peers = [peer for peer in peers if are_apart([peer], own)]
    new_position, new_velocity = Avoidance().core(mode, peers, position, velocity, own)
    normals, distances = cell(peers, np.array(own))
    if mode == lib.modeVelocity:
        assert new_position == position
        aim, is_stopped = np.array(new_velocity), new_velocity == ORIGIN
        if distances.min() < 0 and np.linalg.norm(aim) > 0.5 - 1e-5:
            # part of the straight way into the cell: away from every wall that the drone is behind
            distances = np.maximum(distances, 0)
    else:
        aim, is_stopped = np.array(new_position) - own, new_position == own
    assert is_stopped or (normals @ aim <= distances + 2e-4).all()


@given(peers=swarms, own=points, offset=points, velocity=points)
def test_far_from_everybody_nothing_changes(peers, own, offset, velocity):
    """A setpoint well inside of the cell, and as slow as the drone may be, is left alone."""
    goal = 0.1 * np.array(offset) / max(1.0, np.linalg.norm(offset))
    slow = 0.3 * np.array(velocity) / max(1.0, np.linalg.norm(velocity))
    far = [p for p in peers if np.linalg.norm((np.array(p) - own) / (0.3, 0.3, 0.9)) > 12]
    position = tuple(map(float, np.float32(np.array(own) + goal)))
    velocity = tuple(map(float, np.float32(slow)))
    _, kept = Avoidance().core(lib.modeVelocity, far, ORIGIN, velocity, own)
    assert kept == pytest.approx(velocity, rel=1e-6)
    new_position, new_velocity = Avoidance().core(lib.modeAbs, far, position, velocity, own)
    assert new_position == pytest.approx(position, abs=1e-6)
    assert new_velocity == pytest.approx(velocity, rel=1e-6)


odd = st.sampled_from([math.nan, math.inf, -math.inf, FLT_MAX, -FLT_MAX, 1e20, 1e-30, 0.0])


@given(
    mode=modes,
    peers=swarms,
    bad=st.tuples(odd, odd, odd),
    own=points,
    position=points,
    velocity=points,
)
def test_result_is_finite_whatever_is_told_about_a_peer(mode, peers, bad, own, position, velocity):
    result = Avoidance().core(mode, [*peers, bad], position, velocity, own)
    assert np.isfinite(result).all()


def test_peer_that_is_no_number_makes_the_drone_stay():
    bad = [(math.nan, 0, 0)]
    assert Avoidance().core(lib.modeVelocity, bad, velocity=(1, 0, 0))[1] == ORIGIN
    assert Avoidance().core(lib.modeAbs, bad, (1, 0, 0), own=(0.5, 0, 1)) == ((0.5, 0, 1), ORIGIN)


# --------------------------------------------------------------------------------------------------- on the drone

CLOSE = (1.0, 0.0, 0.0)
FREE, BENT = (0.5, 0.0, 0.0), (0.20000005, -0.079999991, 0.0)


def asked():
    return setpoint(lib.modeAbs, (2, 0, 0))


def test_nothing_happens_while_it_is_off():
    avoidance = Avoidance()
    avoidance.state.enable = 0
    assert avoidance.update(asked(), [(1, CLOSE, 0)]) == ((2, 0, 0), ORIGIN)
    assert all(math.isnan(x) for x in avoidance.last_feasible)


def test_peer_of_the_table_counts():
    assert Avoidance().update(asked(), [(1, CLOSE, 0)])[0] == near(BENT)


def test_empty_entry_does_not_count():
    assert Avoidance().update(asked(), [(0, CLOSE, 0)])[0] == FREE


@pytest.mark.parametrize(
    ("max_age", "age", "position"),
    [(5000, 5000, BENT), (5000, 5001, FREE), (0, 0, BENT), (0, 1, FREE), (-1, 2**31, BENT), (100, 2**32 - 1, FREE)],
)
def test_old_positions_do_not_count(max_age, age, position):
    now = 12
    avoidance = Avoidance(maxPeerLocAgeMillis=max_age)
    assert avoidance.update(asked(), [(3, CLOSE, (now - age) % 2**32)], now)[0] == near(position)


def test_gaps_in_the_table_are_closed():
    table = [(0, ORIGIN, 0), (5, (9, 9, 9), 0), (0, ORIGIN, 0), (7, CLOSE, 0)]
    assert Avoidance().update(asked(), table)[0] == pytest.approx(BENT, abs=1e-6)


def test_only_ten_entries_are_looked_at():
    table = [(i, (50.0 + i, 0, 0), 0) for i in range(1, 11)]
    assert Avoidance().update(asked(), [*table, (11, CLOSE, 0)])[0] == pytest.approx(FREE, abs=1e-6)
    assert Avoidance().update(asked(), [*table[:9], (11, CLOSE, 0)])[0] == pytest.approx(BENT, abs=1e-6)


def test_sweeps_of_a_client_are_limited():
    """Case J with more sweeps than a processor has time for: as with the limit, and soon."""
    table = [(1, (-0.2, 0.7, 0.1), 0), (2, (0.7, -0.7, 0.4), 0)]
    results = []
    for sweeps in (lib.CF_COLLISION_AVOIDANCE_MAX_SWEEPS, 2**31 - 1):
        avoidance = Avoidance(voronoiProjectionMaxIters=sweeps, voronoiProjectionTolerance=1e-30)
        results.append(avoidance.update(setpoint(lib.modeAbs, (0.8, 0.7, 0)), table))
        assert avoidance.state.params.voronoiProjectionMaxIters == sweeps
    assert results[0] == results[1]


PARAMETERS = [
    ("enable", 0),
    ("ellipsoidX", 0.3),
    ("ellipsoidY", 0.3),
    ("ellipsoidZ", 0.9),
    ("bboxMinX", -FLT_MAX),
    ("bboxMinY", -FLT_MAX),
    ("bboxMinZ", -FLT_MAX),
    ("bboxMaxX", FLT_MAX),
    ("bboxMaxY", FLT_MAX),
    ("bboxMaxZ", FLT_MAX),
    ("horizon", 1.0),
    ("maxSpeed", 0.5),
    ("sidestepThrsh", 0.25),
    ("maxPeerLocAge", 5000),
    ("vorTol", 1e-5),
    ("vorIters", 100),
]
TYPES = {"enable": lib.CF_TYPE_UINT8, "maxPeerLocAge": lib.CF_TYPE_INT32, "vorIters": lib.CF_TYPE_INT32}
C_TYPES = {lib.CF_TYPE_UINT8: "uint8_t *", lib.CF_TYPE_INT32: "int32_t *", lib.CF_TYPE_FLOAT: "float *"}


def rows_of(table):
    return [table.rows[i] for i in range(table.count)]


def test_parameters_in_the_order_and_with_the_defaults_of_the_firmware():
    avoidance = Avoidance()
    avoidance.state.enable = 0
    rows = rows_of(lib.cf_collision_avoidance_parameters())
    assert [ffi.string(row.name).decode() for row in rows] == [name for name, _ in PARAMETERS]
    for row, (name, default) in zip(rows, PARAMETERS, strict=True):
        assert ffi.string(row.group) == b"colAv"
        assert row.type == TYPES.get(name, lib.CF_TYPE_FLOAT)
        value = ffi.cast(C_TYPES[row.type], ffi.cast("char *", avoidance.state) + row.offset)[0]
        assert value == pytest.approx(default, rel=1e-6)


def test_log_variable():
    (row,) = rows_of(lib.cf_collision_avoidance_logs())
    assert (ffi.string(row.group), ffi.string(row.name), row.type) == (b"colAv", b"latency", lib.CF_TYPE_UINT32)
