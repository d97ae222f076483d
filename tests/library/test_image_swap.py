"""Drones share the code of a library and nothing else, whichever copy of it works for them."""

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from crazychoir_fw._core import lib

OOT = lib.ControllerTypeOot


def flying(copy):
    drone = copy.drone()
    assert copy.controller_init(drone.block, OOT) == lib.CF_OK
    return drone


def test_counts_from_the_factory_values(app, fly):
    drone = flying(app)
    # calls; 1 + 2 + 3 + gain + 0.25; number 1 + two bytes in .ccmbss + one of the cells; half of the byte 6
    assert fly(app, drone) == (1.0, 6.75, 4.0, 3.0)
    assert fly(app, drone)[0] == 2.0


def test_two_drones_in_turn_are_as_each_alone(app, fly):
    alone = flying(app)
    expected = [fly(app, alone) for _ in range(20)]
    first, second = flying(app), flying(app)
    seen = [(fly(app, first), fly(app, second)) for _ in range(20)]
    assert seen == [(row, row) for row in expected]


def test_a_new_drone_starts_from_the_factory(app, fly):
    drone = flying(app)
    before = drone.save(app.host.ffi)
    first = fly(app, drone)
    assert app.init(drone.block, lib.CF_PLATFORM_CF2, 0) == lib.CF_OK
    assert app.controller_init(drone.block, OOT) == lib.CF_OK
    assert drone.save(app.host.ffi) == before
    assert fly(app, drone) == first


def test_snapshot_and_restore(app, fly):
    drone = flying(app)
    fly(app, drone)
    saved = drone.save(app.host.ffi)
    then = [fly(app, drone) for _ in range(5)]
    drone.restore(app.host.ffi, saved)
    assert [fly(app, drone) for _ in range(5)] == then


def test_copies_at_different_addresses_exchange_blocks(open_library, app_library, fly):
    one, other = open_library(app_library), open_library(app_library)
    assert int(one.host.ffi.cast("uintptr_t", one.provider)) != int(one.host.ffi.cast("uintptr_t", other.provider))
    alone = flying(one)
    expected = [fly(one, alone) for _ in range(20)]
    wanderer = flying(one)
    assert [fly((one, other)[i % 2], wanderer) for i in range(20)] == expected
    assert wanderer.save(one.host.ffi) == alone.save(one.host.ffi)


def test_a_library_without_its_pointers_is_caught_by_the_test_above(open_library, app_library, fly):
    one, other = (open_library(app_library, pointers=[]) for _ in range(2))
    alone, wanderer = flying(one), flying(one)
    expected = [fly(one, alone) for _ in range(6)]
    # the other copy follows pointers into the first one, and counts there
    assert [fly((one, other)[i % 2], wanderer) for i in range(6)] != expected


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=25)
@given(turns=st.lists(st.tuples(st.integers(0, 2), st.integers(0, 1), st.booleans()), max_size=30))
def test_any_order_of_drones_and_copies(open_library, app_library, fly, turns):
    copies = getattr(open_library, "copies", None) or [open_library(app_library), open_library(app_library)]
    open_library.copies = copies
    drones = [flying(copies[0]) for _ in range(3)]
    alone = flying(copies[0])
    longest = [fly(copies[0], alone) for _ in range(len(turns))]
    counts = [0, 0, 0]
    for which, copy, in_one_go in turns:
        if in_one_go:
            copies[copy].begin(drones[which].block)
        assert fly(copies[copy], drones[which]) == longest[counts[which]]
        if in_one_go:
            copies[copy].end(drones[which].block)
        counts[which] += 1


def test_between_begin_and_end_the_block_rests(app, fly):
    drone = flying(app)
    app.begin(drone.block)
    before = drone.save(app.host.ffi)
    answers = [fly(app, drone) for _ in range(3)]
    assert drone.save(app.host.ffi) == before
    app.end(drone.block)
    assert drone.save(app.host.ffi) != before
    assert fly(app, drone)[0] == answers[-1][0] + 1


def test_another_drone_may_come_between_begin_and_end(app, fly):
    first, second = flying(app), flying(app)
    app.begin(first.block)
    assert [fly(app, drone)[0] for drone in (first, second, first, second)] == [1, 1, 2, 2]
    third = flying(app)
    app.end(first.block)
    assert [fly(app, drone)[0] for drone in (first, second, third)] == [3, 3, 1]


def test_functions_that_promise_not_to_change_the_state_do_not(app, fly):
    drone = flying(app)
    before = drone.save(app.host.ffi)
    memory = app.host.ffi.new("uint8_t[]", lib.CF_TRAJECTORY_MEMORY_BYTES)
    estimate, acc = app.host.ffi.new("state_t *"), app.host.ffi.new("Axis3f *")
    assert app.controller_type(drone.block) == OOT
    assert app.plan_state(drone.block) == 0
    assert app.plan_is_stopped(drone.block)
    assert app.plan_is_finished(drone.block, memory, 1.0)
    assert app.kalman_is_within_bounds(drone.block)
    app.kalman_externalize(drone.block, estimate, acc)
    assert app.idle_thrust(drone.block) == 0
    assert drone.save(app.host.ffi) == before


def test_blocks_are_whole_words_with_all_ranges(app, app_library):
    used = sum(size for _, size in app_library.ranges)
    assert app.state_bytes % 8 == 0
    assert used <= app.state_bytes < used + 8 * (len(app_library.ranges) + 1)


def test_variables_are_aligned_in_a_block(app):
    sizes = [1, 2, 4, 1, 2, 4, 4]
    rows = app.variables("parameters") + app.variables("logs")
    assert [row for row in rows if row[4] % sizes[row[2]] != 0] == []


def test_another_abi_is_refused(open_library, app_library, host):
    assert open_library(app_library, abi=99).provider == host.ffi.NULL


@pytest.mark.parametrize("ranges, pointers", [([(10**9, 8)], []), ([(0, 10**9)], []), (None, [0])])
def test_a_map_of_another_library_is_refused(open_library, app_library, host, ranges, pointers):
    assert open_library(app_library, ranges=ranges, pointers=pointers).provider == host.ffi.NULL
