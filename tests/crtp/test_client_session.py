"""Whom a drone listens to."""

import pytest

from crazychoir_fw.crtp.client_session import GOODBYE_S, MAX_WAITING, SILENCE_S, ClientSession, Ruling

FIRST, SECOND, THIRD = ("127.0.0.1", 1001), ("127.0.0.1", 1002), ("10.0.0.3", 1001)
SOURCE, PING, NULL = b"\xfd\0", b"\xfc" + bytes(9), b"\xff"
GOODBYE, HOVER = b"\x3c" + bytes(14), b"\x7c\x0a" + bytes(16)


@pytest.fixture
def owner():
    """A drone that belongs to FIRST since 10 s."""
    owner = ClientSession()
    assert owner.hear(FIRST, SOURCE, 10.0) is Ruling.BEGIN
    return owner


@pytest.mark.parametrize("packet", [SOURCE, PING, HOVER, b"\x00"])
def test_a_free_drone_goes_to_the_first_packet(packet):
    owner = ClientSession()
    assert owner.hear(FIRST, packet, 0.0) is Ruling.BEGIN
    assert owner.address == FIRST


@pytest.mark.parametrize("packet", [NULL, b"\xf3", b"\xf7\1\2\3"])
def test_a_scan_gets_an_answer_and_nothing_else(owner, packet):
    assert ClientSession().hear(FIRST, packet, 0.0) is Ruling.NULL
    assert owner.hear(SECOND, packet, 10.1) is Ruling.NULL
    assert owner.address == FIRST
    assert owner.heard_at == 10.0


def test_null_packets_of_the_owner_keep_it(owner):
    assert owner.hear(FIRST, NULL, 10.9) is Ruling.NULL
    assert not owner.is_gone(11.5)


@pytest.mark.parametrize("datagram", [b"", bytes(32), bytes(64)])
def test_what_is_no_packet_owns_nothing(datagram):
    owner = ClientSession()
    assert owner.hear(FIRST, datagram, 0.0) is Ruling.MALFORMED
    assert owner.address is None


def test_what_is_no_packet_keeps_nobody(owner):
    assert owner.hear(FIRST, bytes(32), 10.9) is Ruling.MALFORMED
    assert owner.is_gone(11.1)


@pytest.mark.parametrize("packet", [PING, HOVER, GOODBYE])
@pytest.mark.parametrize("other", [SECOND, THIRD])
def test_others_are_refused_while_the_owner_lives(owner, packet, other):
    assert owner.hear(other, packet, 10.5) is Ruling.REFUSE
    assert owner.address == FIRST


def test_the_owner_is_gone_after_a_second(owner):
    assert not owner.is_gone(10.0 + SILENCE_S)
    assert owner.is_gone(10.001 + SILENCE_S)
    assert owner.hear(SECOND, HOVER, 10.001 + SILENCE_S) is Ruling.BEGIN
    assert owner.address == SECOND


def test_a_newcomer_waits_until_the_owner_is_gone(owner):
    assert owner.hear(SECOND, SOURCE, 10.5) is Ruling.KEEP
    assert owner.next_in_line(10.9) is None
    assert owner.next_in_line(11.001) == SOURCE
    assert owner.address == SECOND
    assert owner.next_in_line(99.0) is None


def test_of_two_newcomers_the_latest_comes_first_and_the_other_one_next(owner):
    owner.hear(SECOND, SOURCE, 10.1)
    owner.hear(THIRD, b"\xfd\1", 10.2)
    owner.leave()
    assert owner.next_in_line(10.3) == b"\xfd\1"
    assert owner.address == THIRD
    assert owner.next_in_line(10.4) is None
    owner.leave()
    assert owner.next_in_line(10.5) == SOURCE
    assert owner.address == SECOND


def test_who_asks_again_waits_once_and_is_the_latest(owner):
    for address, request in ((SECOND, SOURCE), (THIRD, SOURCE), (SECOND, b"\xfd\2")):
        assert owner.hear(address, request, 10.1) is Ruling.KEEP
    owner.leave()
    assert owner.next_in_line(10.3) == b"\xfd\2"
    assert owner.next_in_line(12.0) == SOURCE
    assert owner.next_in_line(14.0) is None


def test_nobody_else_takes_a_free_drone_for_which_somebody_waits(owner):
    owner.hear(SECOND, SOURCE, 10.1)
    assert owner.hear(THIRD, HOVER, 11.5) is Ruling.REFUSE
    assert owner.next_in_line(11.5) == SOURCE
    assert owner.address == SECOND


def test_who_has_stopped_waiting_is_not_served(owner):
    owner.hear(SECOND, SOURCE, 10.1)
    owner.hear(THIRD, b"\xfd\1", 10.2)
    owner.forget(THIRD)
    owner.forget(("10.0.0.9", 9))
    owner.leave()
    assert owner.next_in_line(10.3) == SOURCE


def test_many_newcomers_fill_no_memory(owner):
    for number in range(3 * MAX_WAITING):
        assert owner.hear(("10.0.0.4", number), SOURCE, 10.1) is Ruling.KEEP
    served = []
    while (owner.leave(), owner.next_in_line(10.2))[1] is not None:
        served.append(owner.address[1])
    assert served == list(range(3 * MAX_WAITING))[: -MAX_WAITING - 1 : -1]


def test_the_next_script_has_the_drone_as_soon_as_the_last_one_has_closed_its_link(owner):
    owner.hear(FIRST, GOODBYE, 10.5)
    # pings go on for a while after the set-point of zeros
    owner.hear(FIRST, PING, 10.6)
    assert owner.hear(SECOND, SOURCE, 10.61) is Ruling.KEEP
    assert owner.next_in_line(10.59 + GOODBYE_S) is None
    assert owner.next_in_line(10.61 + GOODBYE_S) == SOURCE
    assert owner.address == SECOND


def test_a_set_point_of_zeros_is_no_goodbye_when_more_follow(owner):
    owner.hear(FIRST, GOODBYE, 10.1)
    owner.hear(FIRST, HOVER, 10.2)
    assert owner.hear(SECOND, SOURCE, 10.9) is Ruling.KEEP
    assert owner.next_in_line(11.1) is None


def test_a_client_that_pings_after_a_set_point_of_zeros_keeps_its_drone(owner):
    owner.hear(FIRST, GOODBYE, 10.1)
    owner.hear(SECOND, SOURCE, 10.15)
    for tenth in range(2, 100):
        owner.hear(FIRST, PING, 10.0 + 0.1 * tenth)
        assert owner.next_in_line(10.09 + 0.1 * tenth) is None


def test_the_newest_wins_if_wanted():
    owner = ClientSession(newest_wins=True)
    owner.hear(FIRST, SOURCE, 10.0)
    assert owner.hear(SECOND, HOVER, 10.1) is Ruling.REFUSE
    assert owner.hear(SECOND, SOURCE, 10.2) is Ruling.BEGIN
    assert owner.hear(FIRST, PING, 10.3) is Ruling.REFUSE


def test_a_request_for_the_source_begins_a_new_session(owner):
    assert owner.hear(FIRST, SOURCE, 10.1) is Ruling.BEGIN
    assert owner.hear(FIRST, b"\xf1\0", 10.2) is Ruling.BEGIN  # the reserved bits do not count
