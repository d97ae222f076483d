"""The beginning of a contact is reported once."""

import pytest

from crazychoir_fw._core import ffi, lib


@pytest.fixture
def contacts():
    return ffi.new("cf_contacts_t *")


def note(contacts, thing, now_ms, tick=0):
    return lib.cf_contacts_note(contacts, thing, now_ms, tick)


def test_a_contact_begins_once_while_it_lasts(contacts):
    assert note(contacts, 7, 1000)
    assert not any(note(contacts, 7, now) for now in range(1000, 3000))


@pytest.mark.parametrize(("pause", "begins"), [(1, False), (200, False), (201, True), (5000, True)])
def test_a_bounce_is_no_new_contact(contacts, pause, begins):
    note(contacts, 7, 1000)
    assert note(contacts, 7, 1000 + pause) == begins


def test_things_are_told_apart(contacts):
    things = range(1, 1 + lib.CF_MOST_TOUCHED)
    assert all(note(contacts, thing, 1000) for thing in things)
    assert not any(note(contacts, thing, 1001) for thing in things)


def test_the_oldest_is_forgotten_when_too_many_are_touched(contacts):
    for thing in range(1, 2 + lib.CF_MOST_TOUCHED):
        assert note(contacts, thing, 1000 + thing)
    assert not note(contacts, 2, 1100)
    assert note(contacts, 1, 1100)


def test_points_are_counted_in_the_present_step_only(contacts):
    for _ in range(3):
        note(contacts, 7, 1000, tick=50)
    lib.cf_contacts_refresh(contacts, 50)
    assert contacts.now == 3
    lib.cf_contacts_refresh(contacts, 51)
    assert contacts.now == 0
    note(contacts, 7, 1001, tick=51)
    lib.cf_contacts_refresh(contacts, 51)
    assert contacts.now == 1


@pytest.mark.parametrize(("time", "clock"), [(0.0, 0), (1.2345, 1235), (-0.25, 2**32 - 250), (5e6, 5 * 10**9 % 2**32)])
def test_any_simulated_time_has_its_milliseconds(time, clock):
    assert lib.cf_contacts_clock(time) == clock
