"""Port 4 byte by byte."""

import struct
import threading

import pytest
from hypothesis import given
from hypothesis import strategies as st

from crazychoir_fw.crtp.memories import MemoryType
from crazychoir_fw.crtp.service_context import MAX_WAITING, ServiceContext
from crazychoir_fw.crtp.services.memory import MemoryService
from crazychoir_fw.simulation import DroneConfig, World

INFO, READ, WRITE = range(3)

ALWAYS = [0x00, 0x10, 0x17, 0x12, 0x14, 0x15, 0x19]

FITTED = {
    "mocap": (DroneConfig("cf1"), []),
    "flow": (DroneConfig("cf1", positioning="flow"), [0x01]),
    "lighthouse": (DroneConfig("cf1", positioning="lighthouse"), [0x01]),
    "loco": (DroneConfig("cf1", positioning="loco_tdoa2"), [0x11, 0x13, 0x01]),
    "ranges": (DroneConfig("cf1", decks=["multiranger", "zranger"]), [0x01, 0x01]),
    "all": (
        DroneConfig("cf1", positioning="loco_twr", decks=["multiranger", "zranger"]),
        [0x11, 0x13, 0x01, 0x01, 0x01],
    ),
}


def make(config):
    world = World([config], visuals=False)
    return world, world["cf1"]


@pytest.fixture(scope="module")
def service():
    return MemoryService(ServiceContext(*make(FITTED["all"][0])))


def answer(service, channel, payload):
    ((replied, reply),) = service.receive(4, channel, payload)
    assert replied == channel
    return reply


def number_of(service, type):
    return next(number for number, memory in enumerate(service.memories) if memory.type == type)


@pytest.mark.parametrize("name", FITTED)
def test_a_drone_has_the_memories_of_its_decks_in_a_fixed_order(name):
    config, of_decks = FITTED[name]
    service = MemoryService(ServiceContext(*make(config)))
    types = [service.receive(4, INFO, bytes((2, number)))[0][1][2] for number in range(len(service.memories))]
    assert types == ALWAYS + of_decks
    assert answer(service, INFO, b"\x01") == bytes((1, len(types)))


def test_details_are_those_of_the_reference(service):
    number = number_of(service, MemoryType.TRAJECTORY)
    assert answer(service, INFO, bytes((2, number))) == bytes((2, number, 0x12)) + bytes.fromhex("00100000") + bytes(8)


def test_an_unknown_memory_has_no_details(service):
    assert answer(service, INFO, b"\x02\xc8") == b"\x02\xc8"


@pytest.mark.parametrize("payload", [b"", b"\x00", b"\x02", b"\x03", b"\xff" * 30])
def test_other_questions_are_not_answered(service, payload):
    assert tuple(service.receive(4, INFO, payload)) == ()


@pytest.mark.parametrize(
    ("address", "length", "is_there"),
    [
        (0, 24, True),
        (0xFE8, 24, True),
        (0xFE9, 24, False),
        (0x1000, 0, True),
        (0x1001, 0, False),
        (0, 0, True),
        (0, 25, False),
        (0, 255, False),
        (0xFFFFFFFF, 1, False),
        (0xFFFFFFFF, 0, False),
        (0xFFFFFFF0, 24, False),
    ],
)
def test_reads_at_the_edges(service, address, length, is_there):
    for type in (MemoryType.TESTER, MemoryType.TRAJECTORY):
        place = struct.pack("<BI", number_of(service, type), address)
        reply = answer(service, READ, place + bytes((length,)))
        expected = place + (bytes(1 + length) if is_there else b"\x05")
        assert len(reply) == len(expected)
        assert reply[:6] == expected[:6]
    assert reply == expected  # nothing was uploaded


@pytest.mark.parametrize(
    ("address", "length", "is_taken"),
    [(0, 24, True), (0xFE8, 24, True), (0xFE9, 24, False), (0x1000, 0, True), (0, 25, False), (0xFFFFFFFF, 1, False)],
)
def test_writes_at_the_edges(service, address, length, is_taken):
    place = struct.pack("<BI", number_of(service, MemoryType.TRAJECTORY), address)
    assert answer(service, WRITE, place + bytes(length)) == place + (b"\x00" if is_taken else b"\x05")


@pytest.mark.parametrize("channel", [READ, WRITE])
def test_an_unknown_memory_is_an_error(service, channel):
    assert answer(service, channel, b"\xc8\x01\x02\x03\x04\x01") == b"\xc8\x01\x02\x03\x04\x05"


def test_a_read_without_a_length_is_an_error(service):
    assert answer(service, READ, b"\x05\x00\x00\x00\x00") == b"\x05\x00\x00\x00\x00\x05"


@given(st.integers(0, 3), st.binary(max_size=4))
def test_what_names_no_address_is_not_answered_on_channels_1_to_3(service, channel, payload):
    assert channel == INFO or tuple(service.receive(4, channel, payload)) == ()


@given(
    st.integers(0, 3),
    st.one_of(
        st.binary(max_size=30),
        st.builds(
            lambda number, address, rest: struct.pack("<BI", number, address) + rest,
            st.integers(0, 15),
            st.one_of(st.integers(0, 0x3000), st.integers(0, 0xFFFFFFFF)),
            st.binary(max_size=25),
        ),
    ),
)
def test_any_payload_is_survived_and_answered_in_the_right_form(service, channel, payload):
    for replied, reply in service.receive(4, channel, payload):
        assert replied == channel
        if channel == INFO:
            assert reply[0] == payload[0]
            assert len(reply) in (2, 15)
        else:
            assert reply[:5] == payload[:5]
            assert reply[5] in (0, 5)
            length = payload[5] if channel == READ and reply[5] == 0 else 0
            assert len(reply) == 6 + length


KEPT = [MemoryType.TRAJECTORY, MemoryType.EEPROM, MemoryType.LED_RING, MemoryType.LED_TIMINGS, MemoryType.LIGHTHOUSE]
STARTS = {MemoryType.LIGHTHOUSE: st.sampled_from([0, 0x0C, 0x18, 0x30, 0x100, 0x1000, 0x1018, 0x1030, 0x1100, 0x200])}


@given(st.data(), st.sampled_from(KEPT))
def test_reads_see_what_waits_for_the_simulation(service, data, type):
    """Whatever of it has been carried out by then."""
    context = ServiceContext(None, service.memories[0]._drone)
    fresh = MemoryService(context)
    number = number_of(fresh, type)
    memory = fresh.memories[number]
    for _ in range(data.draw(st.integers(0, 10))):
        address = data.draw(STARTS.get(type, st.integers(0, memory.size)))
        content = data.draw(st.binary(min_size=1, max_size=24))
        place = struct.pack("<BI", number, address)
        is_taken = answer(fresh, WRITE, place + content)[5] == 0
        if type != MemoryType.LIGHTHOUSE:
            assert is_taken == (address + len(content) <= memory.size)
        if is_taken and type != MemoryType.LIGHTHOUSE:
            assert memory.read(address, len(content)) == content
    pages = [(0, 49), (0x100, 49), (0x1000, 61), (0x1100, 61)] if type == MemoryType.LIGHTHOUSE else [(0, memory.size)]
    expected = [memory.read(*page) for page in pages]
    for _ in range(data.draw(st.integers(0, len(context._later)))):
        context._later.popleft()()
    assert [memory.read(*page) for page in pages] == expected
    context.carry_out()
    assert [memory._present(*page) for page in pages] == expected


def test_a_client_reads_what_it_wrote_while_the_simulation_catches_up():
    """Two threads: one writes and reads, the other carries out."""
    context = ServiceContext(*make(DroneConfig("cf1")))
    service = MemoryService(context)
    number = number_of(service, MemoryType.TRAJECTORY)
    wrong, is_done = [], threading.Event()

    def client():
        for i in range(3000):
            place = struct.pack("<BI", number, i * 7 % 64)
            data = struct.pack("<I", i) * 4
            if answer(service, WRITE, place + data)[5] != 0:
                continue  # too much waits
            reply = answer(service, READ, place + bytes((len(data),)))
            if reply[6:] != data:
                wrong.append((i, reply))
        is_done.set()

    thread = threading.Thread(target=client)
    thread.start()
    while not is_done.is_set():
        context.carry_out()
    thread.join()
    assert wrong == []


def test_a_flood_of_writes_is_refused_and_forgotten():
    context = ServiceContext(*make(DroneConfig("cf1")))
    service = MemoryService(context)
    place = struct.pack("<BI", number_of(service, MemoryType.TRAJECTORY), 0)
    statuses = [answer(service, WRITE, place + bytes((i % 256,)))[5] for i in range(MAX_WAITING + 50)]
    assert statuses == [0] * MAX_WAITING + [5] * 50
    last = answer(service, READ, place + b"\x01")[6]
    assert last == (MAX_WAITING - 1) % 256
    context.carry_out()
    assert answer(service, READ, place + b"\x01")[6] == last
    assert answer(service, WRITE, place + b"\x07")[5] == 0
