"""The console ring: the latest text, for any number of readers."""

from hypothesis import given
from hypothesis import strategies as st

from crazychoir_fw._core import ffi, lib

ROOM = lib.CF_CONSOLE_BYTES


def read(console, seen=0, capacity=2 * ROOM):
    text, first = ffi.new("char[]", capacity + 1), ffi.new("uint32_t *")
    count = lib.cf_console_read(console, seen, text, capacity, first)
    return ffi.unpack(text, count).decode(), first[0]


def new_console():
    console = ffi.new("cf_console_t *")
    lib.cf_console_init(console)
    return console


def print_line(console, *parts):
    lib.cf_console_print_line(
        console, *[ffi.new("char[]", part.encode()) for part in parts], *[ffi.NULL] * (3 - len(parts))
    )


def test_parts_are_joined_and_end_the_line():
    console = new_console()
    print_line(console, "SUP: ", "state ", "Locked")
    print_line(console, "alone")
    print_line(console)
    assert read(console) == ("SUP: state Locked\nalone\n\n", 0)


def test_a_reader_gets_what_it_has_not_seen():
    console = new_console()
    print_line(console, "one")
    print_line(console, "two")
    assert read(console, seen=4) == ("two\n", 4)
    assert read(console, seen=8) == ("", 8)


def test_a_reader_with_little_room_gets_the_oldest_first():
    console = new_console()
    print_line(console, "abcdef")
    assert read(console, capacity=3) == ("abc", 0)
    assert read(console, seen=3, capacity=3) == ("def", 3)


def test_a_reader_from_before_a_reboot_starts_again():
    console = new_console()
    print_line(console, "fresh")
    assert read(console, seen=400) == ("fresh\n", 0)


@given(st.lists(st.text(st.characters(codec="ascii", exclude_characters="\0"), max_size=200), max_size=20))
def test_the_ring_holds_the_latest_characters(lines):
    console = new_console()
    for line in lines:
        print_line(console, line)
    everything = "".join(line + "\n" for line in lines)
    assert read(console) == (everything[-ROOM:], max(0, len(everything) - ROOM))
