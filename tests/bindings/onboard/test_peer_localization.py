"""The table of the other drones (docs/reference/planner-commander.md#13)."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from crazychoir_fw._core import ffi, lib

ROOM = lib.PEER_LOCALIZATION_MAX_NEIGHBORS


@pytest.fixture
def table():
    return make_table()


def make_table():
    table = ffi.new("cf_peer_localization_t *")
    lib.cf_peer_localization_init(table)
    return table


def tell(table, peer_id, x=0.0, now=0):
    return lib.cf_peer_localization_tell(table, peer_id, [x, 2.0, 3.0], now)


def tell_all(table, ids, now=0):
    peers = [{"id": i, "pos": {"x": float(k), "y": 2.0, "z": 3.0, "timestamp": 999}} for k, i in enumerate(ids)]
    lib.cf_peer_localization_tell_all(table, ffi.new("cf_peer_t[]", peers or 1), len(ids), now)


def entries(table):
    """Return (id, x, timestamp) of all entries."""
    return [(peer.id, peer.pos.x, peer.pos.timestamp) for peer in table.peers]


def ids(table):
    return [peer.id for peer in table.peers]


def test_there_is_room_for_ten():
    assert ROOM == 10


def test_first_position_takes_the_first_entry(table):
    assert tell(table, 7, x=1.5, now=123)
    peer = lib.cf_peer_localization_by_index(table, 0)
    assert (peer.id, peer.pos.x, peer.pos.y, peer.pos.z, peer.pos.timestamp) == (7, 1.5, 2.0, 3.0, 123)


def test_same_id_writes_the_same_entry(table):
    tell(table, 7)
    tell(table, 8)
    assert tell(table, 7, x=5.0, now=9)
    assert entries(table)[:3] == [(7, 5.0, 9), (8, 0.0, 0), (0, 0.0, 0)]


def test_eleventh_peer_is_not_taken(table):
    assert all(tell(table, i) for i in range(1, 11))
    assert not tell(table, 11)
    assert tell(table, 10, x=4.0)
    assert ids(table) == list(range(1, 11))


def test_id_zero_is_nobody(table):
    assert not tell(table, 0)
    assert not lib.cf_peer_localization_is_id_active(table, 0)
    assert lib.cf_peer_localization_by_id(table, 0) == ffi.NULL
    tell_all(table, [0, 0])
    assert ids(table) == [0] * ROOM


def test_peers_are_found_by_id(table):
    tell(table, 255, x=8.0)
    assert lib.cf_peer_localization_is_id_active(table, 255)
    assert lib.cf_peer_localization_by_id(table, 255).pos.x == 8.0
    assert not lib.cf_peer_localization_is_id_active(table, 254)
    assert lib.cf_peer_localization_by_id(table, 254) == ffi.NULL


@pytest.mark.parametrize(("index", "exists"), [(-1, False), (0, True), (9, True), (10, False), (2**31 - 1, False)])
def test_only_ten_indices_exist(table, index, exists):
    assert (lib.cf_peer_localization_by_index(table, index) != ffi.NULL) is exists


# ---------------------------------------------------------------------------------------------------- broadcasts


def test_broadcast_fills_the_table(table):
    tell_all(table, [3, 1, 2], now=40)
    assert entries(table)[:4] == [(3, 0.0, 40), (1, 1.0, 40), (2, 2.0, 40), (0, 0.0, 0)]


def test_known_ids_keep_their_entries(table):
    tell_all(table, [3, 1, 2])
    tell_all(table, [2, 9, 3], now=50)
    assert entries(table)[:4] == [(3, 2.0, 50), (1, 1.0, 0), (2, 0.0, 50), (9, 1.0, 50)]


def test_who_is_not_told_of_grows_old_until_the_place_is_needed(table):
    tell_all(table, range(1, 11))
    tell_all(table, [2, 3], now=10)
    assert ids(table) == list(range(1, 11))
    assert entries(table)[0] == (1, 0.0, 0)
    tell_all(table, [2, 3, 4, 5, 6, 7, 8, 9, 10, 99], now=20)
    assert entries(table)[0] == (99, 9.0, 20)
    assert ids(table)[1:] == list(range(2, 11))


def test_ten_new_peers_replace_ten_old_ones(table):
    tell_all(table, range(1, 11))
    tell_all(table, range(21, 31), now=5)
    assert ids(table) == list(range(21, 31))


def test_equal_ids_get_an_entry_each(table):
    """As in a swarm of more than 255, where ids repeat."""
    tell_all(table, [4, 4, 5])
    assert entries(table)[:3] == [(4, 0.0, 0), (4, 1.0, 0), (5, 2.0, 0)]
    tell_all(table, [5, 4, 4], now=6)
    assert entries(table)[:4] == [(4, 1.0, 6), (4, 2.0, 6), (5, 0.0, 6), (0, 0.0, 0)]


def test_no_more_than_ten_are_taken(table):
    tell_all(table, range(1, 21))
    assert ids(table) == list(range(1, 11))


def test_empty_broadcast_changes_nothing(table):
    tell_all(table, [1, 2])
    before = bytes(ffi.buffer(table))
    tell_all(table, [])
    assert bytes(ffi.buffer(table)) == before


some_ids = st.lists(st.integers(1, 255), max_size=10)


@given(broadcasts=st.lists(some_ids, min_size=1, max_size=6))
def test_last_broadcast_is_always_complete_in_the_table(broadcasts):
    table = make_table()
    for now, told in enumerate(broadcasts, start=1):
        tell_all(table, told, now)
    fresh = sorted((peer_id, x) for peer_id, x, stamp in entries(table) if stamp == len(broadcasts))
    assert fresh == sorted((peer_id, float(k)) for k, peer_id in enumerate(broadcasts[-1]))


@given(told=st.lists(st.integers(1, 255), unique=True, max_size=10))
def test_broadcast_into_an_empty_table_is_what_single_positions_make(told):
    at_once, one_by_one = make_table(), make_table()
    tell_all(at_once, told, 3)
    for k, peer_id in enumerate(told):
        tell(one_by_one, peer_id, float(k), 3)
    assert bytes(ffi.buffer(at_once)) == bytes(ffi.buffer(one_by_one))
