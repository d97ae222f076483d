"""Tables of contents that are sent ahead of the questions for their items."""

import functools
from collections import deque

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crazychoir_fw.crtp.services import reading_ahead
from crazychoir_fw.crtp.station import Station
from crazychoir_fw.crtp.toc import log_toc, parameter_toc
from crazychoir_fw.simulation import DroneConfig, World

TABLES = {0x5C: log_toc(), 0x2C: parameter_toc()}


@functools.cache
def a_world():
    return World([DroneConfig("cf1")], visuals=False)


def open_station():
    made = Station(a_world(), a_world()["cf1"])
    made.context.reads_ahead = True
    return made


@pytest.fixture
def station():
    made = open_station()
    yield made
    made.close()


def ask(station, header, number):
    return station.receive(bytes((header, 2)) + number.to_bytes(2, "little"))


def number_of(datagram):
    return int.from_bytes(datagram[2:4], "little")


def look(station, times=1):
    for _ in range(times):
        for call in tuple(station.context.looks):
            call()
    return [datagram for datagram, _ in station.context.take_out()]


@pytest.mark.parametrize("header", TABLES)
def test_every_item_comes_once_and_in_order(station, header):
    toc, came, most = TABLES[header], [], 0
    for number in range(len(toc)):
        came += ask(station, header, number)
        most = max(most, len(came) - number)
        assert len(came) > number  # a question is never left alone
    station.context.reads_ahead = False
    assert came == [ask(station, header, number)[0] for number in range(len(toc))]
    assert reading_ahead.AHEAD // 2 < most <= reading_ahead.AHEAD + 1
    assert look(station, 1000) == []


def test_few_questions_get_few_answers(station):
    for number in (0, 1, 2, 7, 8, 9, 3, 3, 3, 3, 4):
        assert [number_of(reply) for reply in ask(station, 0x5C, number)] == [number]


@pytest.mark.parametrize("number", [len(TABLES[0x5C]), 65535])
def test_there_is_nothing_behind_the_end(station, number):
    assert ask(station, 0x5C, number) == [b"\x5c\x02"]
    assert [number_of(reply) for reply in ask(station, 0x5C, 0)] == [0]


def test_what_is_waited_for_comes_again(station):
    for number in range(10):
        ask(station, 0x5C, number)
    assert look(station, reading_ahead.LOOKS - 1) == []
    assert [number_of(copy) for copy in look(station)] == [9]
    assert ask(station, 0x5C, 10) == []  # it had come
    assert look(station, reading_ahead.LOOKS - 1) == []
    # the service stops sending copies to a client that does not answer
    copies = look(station, 10_000)
    assert {number_of(copy) for copy in copies} == {10}
    assert len(copies) == reading_ahead.MAX_COPIES


def test_a_session_that_ends_leaves_nothing(station):
    for number in range(10):
        ask(station, 0x5C, number)
        ask(station, 0x2C, number)
    assert len(station.context.looks) == 2
    station.end_session()
    assert not station.context.looks
    assert [number_of(reply) for reply in ask(station, 0x5C, 10)] == [10]


@given(losses=st.sets(st.integers(0, 400), max_size=40))
@settings(max_examples=25)
def test_a_client_that_never_asks_twice_gets_all_of_it(losses):
    """Whatever is lost on the way, as long as it was sent unasked: the rest is as reliable as without this."""
    station = open_station()
    toc, header, inbox, sent, has = TABLES[0x5C], 0x5C, deque(), 0, []

    def post(datagrams, is_lost):
        nonlocal sent
        for datagram in datagrams:
            sent += 1
            if not (is_lost and sent in losses):
                inbox.append(datagram)

    post(ask(station, header, 0), False)
    while len(has) < len(toc):
        if not inbox:
            post(look(station, reading_ahead.LOOKS), False)
            assert inbox, f"item {len(has)} never comes"
        datagram = inbox.popleft()
        if number_of(datagram) == len(has):
            has.append(datagram)
            replies = ask(station, header, len(has)) if len(has) < len(toc) else []
            post(replies, len(replies) != 1)
    station.close()
    assert [number_of(datagram) for datagram in has] == list(range(len(toc)))
