"""The platform service (docs/reference/crtp-cflib.md#6)."""

import pytest
from cflib_client import Client
from hypothesis import given
from hypothesis import strategies as st

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.crtp.packet import Packet, parse
from crazychoir_fw.crtp.services.platform import MAX_MESSAGES, firmware_version
from crazychoir_fw.crtp.station import Station
from crazychoir_fw.onboard import core
from crazychoir_fw.simulation import DroneConfig, World


@pytest.fixture
def world():
    return World([DroneConfig("cf1", platform="cf21bl")], visuals=False)


@pytest.fixture
def station(world):
    return Station(world, world["cf1"])


def ask(station, channel, request):
    """Return the payloads that answer at once and when the simulation goes on."""
    replies = station.receive(Packet(13, channel, bytes.fromhex(request)).to_bytes())
    station.context.carry_out()
    replies += [datagram for datagram, _ in station.context.take_out()]
    packets = [packet for packet in map(parse, replies) if packet.port != 0]  # but the console
    assert all((packet.port, packet.channel) == (13, channel) for packet in packets)
    return [packet.payload.hex() for packet in packets]


@pytest.mark.parametrize(
    ("channel", "request_", "reply"),
    [
        (0, "0001", "0001"),  # continuous wave
        (0, "0000", "0000"),
        (0, "0301", ""),  # notification
        (0, "03", ""),
        (0, "04aabb", "04aabb"),
        (0, "ff", "ff"),
        (0, "01", "0100"),  # whether to arm is missing
        (1, "00", "000c000000"),
        (1, "02", "0243463231424c"),
        (1, "07aa", "07aa"),
    ],
)
def test_questions_and_their_answers(station, channel, request_, reply):
    assert ask(station, channel, request_) == [reply]


@pytest.mark.parametrize("datagram", ["dc", "dd", "de", "df", "df01"])
def test_what_asks_nothing_is_not_answered(station, datagram):
    assert station.receive(bytes.fromhex(datagram)) == []


def test_the_device_type_of_the_other_platform():
    world = World([DroneConfig("cf1")], visuals=False)
    assert ask(Station(world, world["cf1"]), 1, "02") == [(b"\x02CF21").hex()]


def test_the_firmware_version_is_a_release_and_says_whose(station):
    (reply,) = ask(station, 1, "01")
    command, text = bytes.fromhex(reply)[0], bytes.fromhex(reply)[1:].decode()
    assert (command, text) == (1, firmware_version(0))
    assert text.startswith("2026.08 +crazychoir ")
    assert len(text) <= 29


def test_the_firmware_version_of_a_checkout_is_its_own(bitcraze_library):
    assert firmware_version(core.load_library(bitcraze_library)) == "2026.08"


def test_a_long_version_is_cut(world, monkeypatch):
    monkeypatch.setattr("crazychoir_fw.crtp.services.platform.firmware_version", lambda provider: "2026.08-" + "x" * 40)
    (reply,) = ask(Station(world, world["cf1"]), 1, "01")
    assert bytes.fromhex(reply) == b"\x012026.08-" + b"x" * 21


def test_arming_is_answered_with_what_came_of_it(world, station):
    assert ask(station, 0, "0101") == ["0100"], "it boots"
    while not world["cf1"].can_arm:
        world.step(100)
    assert ask(station, 0, "0101") == ["0101"]
    world.step(100)
    assert world["cf1"].can_fly
    assert ask(station, 0, "0100") == ["0101"]
    world.step(100)
    assert not world["cf1"].can_fly


def test_requests_are_written_into_the_journal(world, station):
    before = len(world.journal)
    ask(station, 0, "0101")
    ask(station, 0, "02")
    assert len(world.journal) == before + 2


def test_recovery_is_answered(world, station):
    world.step(2000)
    assert ask(station, 0, "02") in (["0200"], ["0201"])


def test_requests_beyond_what_can_wait_are_refused(station):
    while station.context.later(lambda: None):
        pass
    assert [reply.hex() for reply in station.receive(b"\xdc\x01\x01")] == ["dc0100"]
    assert [reply.hex() for reply in station.receive(b"\xdc\x02")] == ["dc0200"]


@given(st.integers(0, 3), st.binary(max_size=30))
def test_any_packet_is_survived(lasting_station, channel, payload):
    replies = lasting_station.receive(Packet(13, channel, payload).to_bytes())
    assert len(replies) <= 1
    assert all(parse(reply)[:2] == (13, channel) for reply in replies)
    lasting_station.context.carry_out()
    lasting_station.context.take_out()


@pytest.fixture(scope="module")
def lasting_station():
    world = World([DroneConfig("cf1")], visuals=False)
    return Station(world, world["cf1"])


# ------------------------------------------------------------------------------------------- app channel


def test_messages_wait_for_whoever_fetches_them(station):
    app = station.app_channel
    assert app.receive() is None
    assert ask(station, 2, "0102") == ask(station, 2, "03") == []
    assert (app.receive(), app.receive(), app.receive()) == (b"\1\2", b"\3", None)


def test_a_callback_gets_them_between_two_steps(station):
    heard = []
    ask(station, 2, "aa")
    station.app_channel.callback = heard.append
    station.receive(b"\xde\xbb")
    station.receive(b"\xde\xcc")
    assert heard == []
    station.context.carry_out()
    assert heard == [b"\xaa", b"\xbb", b"\xcc"]
    assert ask(station, 2, "dd") == []
    assert heard[3:] == [b"\xdd"]


def test_a_flood_is_bounded(station):
    heard = []
    station.app_channel.callback = heard.append
    for number in range(10 * MAX_MESSAGES):
        station.receive(b"\xde" + number.to_bytes(2, "big"))
    assert station.app_channel.lost == 9 * MAX_MESSAGES
    station.context.carry_out()
    assert heard == [number.to_bytes(2, "big") for number in range(MAX_MESSAGES)]


def test_a_callback_that_fails_loses_one_message(station):
    heard = []

    def fail_once(data):
        heard.append(data)
        if len(heard) == 1:
            raise ValueError("a defect of a user")

    station.app_channel.callback = fail_once
    for datagram in (b"\xde\1", b"\xde\2", b"\xde\3"):
        station.receive(datagram)
    with pytest.raises(ValueError, match="a defect"):
        station.context.carry_out()
    station.context.carry_out()
    assert heard == [b"\1", b"\2", b"\3"]


@pytest.mark.parametrize("size", [0, 31])
def test_messages_of_wrong_sizes_are_refused(station, size):
    with pytest.raises(RangeError, match=f"cf1: app channel: {size} bytes, allowed: 1 to 30"):
        station.app_channel.send(bytes(size))


def test_the_real_client_talks_with_python(station):
    client = Client(station)
    channel, heard = client.cf.appchannel, []
    channel.packet_received.add_callback(heard.append)
    station.app_channel.callback = lambda data: station.app_channel.send(data[::-1])
    channel.send_packet(b"echo")
    client.pump()
    assert [bytes(data) for data in heard] == [b"ohce"]
