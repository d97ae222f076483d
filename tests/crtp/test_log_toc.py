"""The table of contents of log variables (docs/reference/crtp-cflib.md#8.1 and #8.4)."""

import struct
from dataclasses import replace

import numpy as np
import pytest

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.crtp.packet import MAX_PAYLOAD
from crazychoir_fw.crtp.station import Station
from crazychoir_fw.crtp.toc import TableOfContents, log_entry
from crazychoir_fw.onboard import core
from crazychoir_fw.onboard.variables import Variable, log_table
from crazychoir_fw.simulation import DroneConfig, World

ROWS = list(log_table(0).values())[:5]
KINDS = {"u1": 1, "u2": 2, "u4": 3, "i1": 4, "i2": 5, "i4": 6, "f4": 7}


@pytest.fixture(scope="module")
def station():
    world = World([DroneConfig("cf1")], visuals=False)
    return Station(world, world["cf1"])


def check_items(station, table):
    (info,) = station.receive(bytes.fromhex("5c 03"))
    count, _crc, blocks, values = struct.unpack("<HIBB", info[2:])
    assert (info[:2], count, blocks, values) == (b"\x5c\x03", len(table), 16, 128)
    for index, row in enumerate(table.values()):
        (item,) = station.receive(bytes.fromhex("5c 02") + struct.pack("<H", index))
        group, name, rest = item[5:].split(b"\0")
        assert item[:4] == b"\x5c\x02" + struct.pack("<H", index)
        assert (item[4], f"{group.decode()}.{name.decode()}", rest) == (KINDS[row.dtype.str[1:]], row.name, b"")
        assert len(item) <= 1 + MAX_PAYLOAD


def test_all_variables_are_told_by_their_ids(station):
    check_items(station, log_table(0))


def test_all_variables_of_a_checkout_are_told(bitcraze_library, miniature, monkeypatch):
    monkeypatch.setenv("CRAZYFLIE_FIRMWARE", str(miniature))
    provider = core.load_library(bitcraze_library)
    world = World([DroneConfig("cf1", provider="bitcraze")], visuals=False)
    assert world["cf1"].provider_number == provider
    check_items(Station(world, world["cf1"]), log_table(provider))


@pytest.mark.parametrize("request_", ["5c02ffff", "5c02", "5c0200", f"5c02{len(log_table(0)):04x}"[:4] + "ff7f"])
def test_an_id_that_there_is_not_is_answered_with_the_command_alone(station, request_):
    assert station.receive(bytes.fromhex(request_)) == [b"\x5c\x02"]


@pytest.mark.parametrize("request_", ["5c", "5c04", "5e03", "5f03"])
def test_what_is_no_question_is_not_answered(station, request_):
    assert station.receive(bytes.fromhex(request_)) == []


CHANGES = {
    "order": [ROWS[1], ROWS[0], *ROWS[2:]],
    "fewer": ROWS[:-1],
    "name": [*ROWS[:-1], replace(ROWS[-1], name="other.name")],
    "type": [*ROWS[:-1], replace(ROWS[-1], dtype=np.dtype(np.int8))],
    "core": [*ROWS[:-1], replace(ROWS[-1], is_core=not ROWS[-1].is_core)],
}


def crc(rows):
    return TableOfContents("log", [log_entry(row) for row in rows]).crc


@pytest.mark.parametrize("change", CHANGES)
def test_the_crc_changes_with_whatever_clients_store(change):
    assert crc(CHANGES[change]) != crc(ROWS)


def test_the_place_of_a_variable_in_memory_does_not_matter_to_clients():
    assert crc([replace(row, offset=row.offset + 4) for row in ROWS]) == crc(ROWS) < 2**32


def test_names_that_fit_no_packet_are_refused():
    long = Variable("group.a_name_of_20_letters", np.dtype(np.uint8), 0, False, False, False)
    fits = Variable("group.a_name_of_19_lettrs", np.dtype(np.uint8), 0, False, False, False)
    assert (len(long.name), len(fits.name)) == (26, 25)
    assert len(TableOfContents("log", [log_entry(fits)]).answer(bytes.fromhex("02 00 00"))) == MAX_PAYLOAD
    with pytest.raises(RangeError, match=r"log 'group.a_name_of_20_letters': 25 characters .* at most 24 fit"):
        TableOfContents("log", [log_entry(long)])
