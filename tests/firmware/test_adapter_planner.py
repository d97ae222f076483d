"""The planner of a checkout beside that of the builtin provider: the same bits.

The miniature's keeps trajectories by pointers, which must not outlive the memory that they point into.
"""

import numpy as np
import pytest
from flight_inputs import GOAL, START, pieces_of
from side_by_side import all_of, same

from crazychoir_fw._core import ffi, lib


def goals(drone, memory, times):
    found = []
    for t in times:
        goal = drone.plan_current_goal(memory, t)
        found.append([goal, drone.plan_state(), drone.plan_is_finished(memory, t)])
    return found


def assert_same_plans(pair, memory=None, times=None):
    times = np.arange(0, 4, 0.25).tolist() if times is None else times
    memory = ffi.new("uint8_t[]", lib.CF_TRAJECTORY_MEMORY_BYTES) if memory is None else memory
    one, other = (goals(drone, memory, times) for drone in pair)
    for (goal, *rest), (their_goal, *their_rest) in zip(one, other, strict=True):
        assert same(ffi.new("struct traj_eval *", goal), ffi.new("struct traj_eval *", their_goal))
        assert rest == their_rest
    return one


def test_a_flight_from_take_off_to_landing(pair):
    memory = ffi.new("uint8_t[]", lib.CF_TRAJECTORY_MEMORY_BYTES)
    assert all_of(pair, "plan_is_stopped")
    assert all_of(pair, "plan_takeoff", START, 1.0, 0.2, 1.0, 0.0) == 0
    assert all_of(pair, "plan_takeoff", START, 1.0, 0.2, 1.0, 0.0) == 1, "not from the air"
    assert_same_plans(pair, memory)
    assert all_of(pair, "plan_go_to", memory, START, False, False, GOAL, 1.0, 2.0, 1.5) == 0
    assert_same_plans(pair, memory)
    assert all_of(pair, "plan_go_to", memory, START, True, True, GOAL, 3.0, 2.0, 2.5) == 0
    assert_same_plans(pair, memory)
    spiral = {"angle": 4.0, "radius0": 0.5, "radiusF": 1.0, "ascent": 0.3, "duration": 2.0}
    for sideways, clockwise in [(False, False), (True, True)]:
        turn = ffi.new("cf_spiral_t *", {**spiral, "sideways": sideways, "clockwise": clockwise})
        assert all_of(pair, "plan_spiral", START, turn, 0.0) == 0
        assert_same_plans(pair, memory)
    all_of(pair, "plan_disable")
    assert all_of(pair, "plan_is_disabled")
    assert_same_plans(pair, memory)
    assert all_of(pair, "plan_go_to", memory, START, False, False, GOAL, 1.0, 2.0, 0.0) == 0, "from where it is"
    assert_same_plans(pair, memory)
    assert all_of(pair, "plan_land", START, 0.0, 0.0, 1.0, 0.0) == 0
    assert all_of(pair, "plan_land", START, 0.0, 0.0, 1.0, 0.0) == 1
    assert_same_plans(pair, memory)
    assert all_of(pair, "plan_is_stopped"), "landed"
    all_of(pair, "plan_stop")
    assert all_of(pair, "plan_state") == lib.TRAJECTORY_STATE_IDLE


@pytest.mark.parametrize("reversed_", [False, True])
@pytest.mark.parametrize("relative", [(False, False), (True, False), (True, True)])
def test_uploaded_trajectories(pair, rng, reversed_, relative):
    memory = pieces_of(rng, 3)
    uploaded = ffi.new(
        "cf_uploaded_trajectory_t *",
        {
            "type": lib.CF_TRAJECTORY_TYPE_POLY4D,
            "offset": 132,
            "n_pieces": 3,
            "timescale": 1.5,
            "reversed": reversed_,
            "relative_position": relative[0],
            "relative_yaw": relative[1],
        },
    )
    assert all_of(pair, "plan_start_trajectory", memory, uploaded, START, 0.1) == 0
    flown = assert_same_plans(pair, memory)
    assert flown[-1][2], "it is over"
    # the planner keeps no address of the memory: another place, other bytes
    moved = pieces_of(rng, 3)
    assert_same_plans(pair, moved)
    assert flown[4][0].pos.x != goals(pair[1], moved, [1.0])[0][0].pos.x
    assert all_of(pair, "plan_go_to", moved, START, False, False, GOAL, 1.0, 2.0, 1.0) == 0
    assert_same_plans(pair, moved)


def compressed(rng, count, end=True):
    """Return a compressed trajectory: a start and `count` pieces of all storage types."""
    data = rng.integers(-1000, 1000, 4).astype("<i2").tobytes()
    for i in range(count):
        types = [(i + axis) % 4 for axis in range(4)]
        points = sum((0, 1, 3, 7)[kind] for kind in types)
        header = sum(kind << 2 * axis for axis, kind in enumerate(types))
        data += bytes([header]) + (400 + 50 * i).to_bytes(2, "little")
        data += rng.integers(-1500, 1500, points).astype("<i2").tobytes()
    return data + (bytes(3) if end else b"")


@pytest.mark.parametrize("relative", [False, True])
def test_compressed_trajectories(pair, rng, relative):
    data = compressed(rng, 4)
    memory = ffi.new("uint8_t[]", bytes(100) + data + bytes(lib.CF_TRAJECTORY_MEMORY_BYTES - 100 - len(data)))
    kind = lib.CF_TRAJECTORY_TYPE_POLY4D_COMPRESSED
    uploaded = ffi.new(
        "cf_uploaded_trajectory_t *", {"type": kind, "offset": 100, "timescale": 1.0, "relative_position": relative}
    )
    assert all_of(pair, "plan_start_trajectory", memory, uploaded, START, 0.1) == 0
    assert_same_plans(pair, memory)
    assert_same_plans(pair, ffi.new("uint8_t[]", ffi.buffer(memory)[:]), times=[0.3, 2.0, 0.5])


def test_a_compressed_trajectory_ends_with_the_memory_at_the_latest(pair, rng):
    data = compressed(rng, 100, end=False)[: lib.CF_TRAJECTORY_MEMORY_BYTES - 4000]
    memory = ffi.new("uint8_t[]", bytes(4000) + data)
    kind = lib.CF_TRAJECTORY_TYPE_POLY4D_COMPRESSED
    uploaded = ffi.new("cf_uploaded_trajectory_t *", {"type": kind, "offset": 4000, "timescale": 1.0})
    bitcraze = pair[1]
    assert bitcraze.plan_start_trajectory(memory, uploaded, START, 0.0) == 0
    assert np.isfinite([goal.pos.x for goal, *_ in goals(bitcraze, memory, [0.0, 1.0, 100.0])]).all()
    uploaded.offset = lib.CF_TRAJECTORY_MEMORY_BYTES - 7
    assert all_of(pair, "plan_start_trajectory", memory, uploaded, START, 0.0) == 1
    assert bitcraze.cf.onboard.fault == 0


def test_pieces_beyond_the_memory_are_refused(pair):
    kind = lib.CF_TRAJECTORY_TYPE_POLY4D
    uploaded = ffi.new("cf_uploaded_trajectory_t *", {"type": kind, "offset": 4000, "n_pieces": 1, "timescale": 1.0})
    memory = ffi.new("uint8_t[]", lib.CF_TRAJECTORY_MEMORY_BYTES)
    assert pair[1].plan_start_trajectory(memory, uploaded, START, 0.0) == 1
    assert pair[1].plan_is_stopped()
