"""Whose turn it is to connect."""

import pytest

from crazychoir_fw.crtp.turns import LONGEST_S, SILENCE_S, STALE_S, Stage, Turns, Visit

SOURCE, PING = b"\xfd\0", b"\xfcping"
LOGS, ITEM, MEMORIES, PARAMETERS = b"\x5c\3", b"\x5c\2\0\0", b"\x4c\1", b"\x2c\3"
VALUE, LOG_BLOCK, SET_POINT = b"\x2d\0\0", b"\x5d\6\1", b"\x3c" + bytes(14)
READ = 5
"""Parameters of a drone."""


@pytest.fixture
def turns():
    return Turns(at_once=2)


@pytest.fixture
def visits(turns):
    """Clients that have come, and asked for nothing yet."""
    made = [Visit(READ) for _ in range(6)]
    for visit in made:
        turns.begin(visit)
        assert not turns.keeps(visit, SOURCE, 0.0)
    return made


def called(turns, visits, now):
    return [(visits.index(visit), kept) for visit, kept in turns.due(now)]


def ask(turns, visits, datagram, now=0.0):
    return [turns.keeps(visit, datagram, now) for visit in visits]


def test_few_are_served_at_once(turns, visits):
    assert all(ask(turns, visits, LOGS))
    assert called(turns, visits, 0.0) == [(0, [LOGS]), (1, [LOGS])]
    assert called(turns, visits, 0.0) == []
    assert turns.is_anybody_waiting


@pytest.mark.parametrize("datagram", [ITEM, MEMORIES, PARAMETERS, PING, SET_POINT, LOG_BLOCK])
def test_who_is_served_waits_for_nothing_more(turns, visits, datagram):
    ask(turns, visits, LOGS)
    turns.due(0.0)
    assert ask(turns, visits[:2], datagram) == [False, False]


@pytest.mark.parametrize("datagram", [PING, MEMORIES, SET_POINT, VALUE, ITEM, b"\x5c", b"\x5c\1"])
def test_only_who_begins_to_connect_waits(turns, visits, datagram):
    assert not any(ask(turns, visits, datagram))
    assert not turns.is_anybody_waiting


def test_pings_and_set_points_do_not_wait(turns, visits):
    ask(turns, visits, LOGS)
    turns.due(0.0)
    for datagram in (PING, SET_POINT, SOURCE):
        assert not turns.keeps(visits[5], datagram, 0.0)
    assert visits[5].kept == [LOGS]


def test_the_next_one_begins_when_one_has_connected(turns, visits):
    ask(turns, visits, LOGS)
    turns.due(0.0)
    assert turns.keeps(visits[1], VALUE, 0.0)
    assert called(turns, visits, 0.0) == [(2, [LOGS])]


def test_connecting_comes_before_reading(turns, visits):
    ask(turns, visits, LOGS)
    order = []
    while turns.is_anybody_waiting:
        for number, (datagram,) in called(turns, visits, 0.0):
            order.append((number, datagram))
            if datagram == LOGS:
                assert turns.keeps(visits[number], VALUE, 0.0)
            else:
                assert [turns.keeps(visits[number], VALUE, 0.0) for _ in range(READ - 1)] == [False] * (READ - 1)
                assert visits[number].stage is Stage.DONE
    assert order == [(number, LOGS) for number in range(6)] + [(number, VALUE) for number in range(6)]


def test_who_is_done_never_waits_again(turns, visits):
    visit = visits[0]
    for datagram in (LOGS, VALUE):
        turns.keeps(visit, datagram, 0.0)
        assert called(turns, visits, 0.0) == [(0, [datagram])]
    for _ in range(READ - 1):
        assert not turns.keeps(visit, VALUE, 0.0)
    assert visit.stage is Stage.DONE


def test_silence_lets_the_next_one_begin(turns, visits):
    ask(turns, visits, LOGS)
    turns.due(0.0)
    assert called(turns, visits, 0.9 * SILENCE_S) == []
    assert called(turns, visits, 1.1 * SILENCE_S) == [(2, [LOGS])]
    assert called(turns, visits, 1.9 * SILENCE_S) == []
    turns.keeps(visits[2], ITEM, 1.9 * SILENCE_S)
    assert called(turns, visits, 2.5 * SILENCE_S) == []
    assert called(turns, visits, 3.0 * SILENCE_S) == [(3, [LOGS])]


@pytest.mark.parametrize("end", [STALE_S, LONGEST_S])
def test_nobody_keeps_others_waiting(turns, visits, end):
    """Neither by doing something else nor by asking for ever."""
    ask(turns, visits[:3], LOGS)
    turns.due(0.0)
    now, waits = 0.0, True
    while waits and now < 2.0 * end:
        now += 0.4 * SILENCE_S
        turns.keeps(visits[1], ITEM, now)
        if end == LONGEST_S:
            turns.keeps(visits[0], ITEM, now)
        waits = not called(turns, visits, now)
    assert now == pytest.approx(end, abs=SILENCE_S)


def test_who_asks_for_more_does_not_wait(turns, visits):
    ask(turns, visits, LOGS)
    turns.due(0.0)
    assert turns.keeps(visits[5], ITEM, 0.0)
    assert called(turns, visits, 0.0) == [(5, [LOGS, ITEM])]
    assert visits[5].stage is Stage.DONE


def test_who_has_gone_is_forgotten(turns, visits):
    ask(turns, visits, LOGS)
    turns.due(0.0)
    turns.end(visits[2])
    turns.end(visits[0])
    assert called(turns, visits, 0.0) == [(3, [LOGS])]
    turns.begin(visits[1])
    assert called(turns, visits, 0.0) == [(4, [LOGS])]


def test_without_turns_nobody_waits(turns, visits):
    ask(turns, visits, LOGS)
    turns.due(0.0)
    assert [kept for _, kept in turns.release()] == [[LOGS]] * 4
    assert not turns.is_anybody_waiting
