"""Port 2: parameters (docs/reference/crtp-cflib.md#9)."""

import json
import math
import struct

import pytest
from cflib_client import Client
from hypothesis import given
from hypothesis import strategies as st

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.crtp.packet import MAX_PAYLOAD, Port
from crazychoir_fw.crtp.services.param import ParamService
from crazychoir_fw.crtp.services.param_values import MAX_NEWS
from crazychoir_fw.crtp.services.param_values import MAX_WAITING as MAX_WRITES
from crazychoir_fw.crtp.station import Station
from crazychoir_fw.onboard.variables import parameter_table
from crazychoir_fw.simulation import DroneConfig, World

TOC, READ, WRITE, MISC = range(4)
FORMATS = {"u1": "<B", "u2": "<H", "u4": "<L", "i1": "<b", "i2": "<h", "i4": "<l", "f4": "<f"}
NAMES = list(parameter_table())
NUMBERS = {name: number for number, name in enumerate(parameter_table())}


def id_of(name):
    return struct.pack("<H", NUMBERS[name])


def packed(name, value):
    return struct.pack(FORMATS[parameter_table()[name].dtype.str[1:]], value)


class Bench:
    """A drone and its station."""

    def __init__(self, storage=None, world=None, **options):
        self.world = world or World([DroneConfig("cf1", **options)], visuals=False)
        self.drone = self.world["cf1"]
        self.station = Station(self.world, self.drone, storage=storage)
        self.service = next(service for service in self.station.services if isinstance(service, ParamService))
        self.context = self.station.context
        self.context.carry_out()

    def ask(self, channel, payload):
        """Return the only answer, or None."""
        replies = list(self.service.receive(Port.PARAM, channel, payload))
        assert len(replies) <= 1
        assert all(back == channel for back, _ in replies)
        return replies[0][1] if replies else None

    def told(self):
        """Return payloads that the drone has sent by itself."""
        return [datagram[1:] for datagram, _ in self.context.take_out()]


@pytest.fixture
def bench():
    return Bench()


# ----------------------------------------------------------------------------------------- reading


def test_every_parameter_is_read_with_its_size_and_value(bench):
    for number, (name, row) in enumerate(parameter_table().items()):
        answer = bench.ask(READ, struct.pack("<H", number))
        assert answer == struct.pack("<HB", number, 0) + packed(name, bench.drone.param[name])
        assert len(answer) == 3 + row.dtype.itemsize


@pytest.mark.parametrize("channel", [READ, WRITE])
def test_unknown_number_is_no_entry(bench, channel):
    assert bench.ask(channel, b"\xff\xff\x00") == b"\xff\xff\x02"


@pytest.mark.parametrize("channel", range(4))
@pytest.mark.parametrize("payload", [b"", b"\x09"])
def test_what_is_too_short_is_swallowed(bench, channel, payload):
    assert bench.ask(channel, payload) is None


# ----------------------------------------------------------------------------------------- writing


def test_a_write_is_echoed_at_once_and_takes_effect_between_two_steps(bench):
    name = "pid_attitude.pitch_kd"
    payload = id_of(name) + packed(name, 0.125)
    assert bench.ask(WRITE, payload) == payload
    assert bench.drone.param[name] == 0.0
    assert bench.ask(READ, id_of(name)) == id_of(name) + b"\0" + packed(name, 0.125)  # what waits counts already
    bench.context.carry_out()
    assert bench.drone.param[name] == 0.125
    assert bench.ask(READ, id_of(name)) == id_of(name) + b"\0" + packed(name, 0.125)


def test_writes_take_effect_in_order_and_stand_in_the_journal(bench):
    name = "ring.effect"
    for value in (1, 2, 3):
        bench.ask(WRITE, id_of(name) + bytes((value,)))
    assert bench.ask(READ, id_of(name))[3:] == b"\3"
    bench.context.carry_out()
    asked = [request.arguments for request in bench.world.journal if request.verb == "param"]
    assert asked == [(name, 1), (name, 2), (name, 3)]


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_what_is_not_finite_is_refused_with_the_value_that_stays(bench, value):
    name = "posCtlPid.xKp"
    stays = id_of(name) + packed(name, bench.drone.param[name])
    assert bench.ask(WRITE, id_of(name) + packed(name, value)) == stays
    bench.context.carry_out()
    assert bench.ask(READ, id_of(name)) == stays[:2] + b"\0" + stays[2:]


def test_a_write_that_is_too_short_is_refused_with_the_value_that_stays(bench):
    name = "posCtlPid.xKp"
    assert bench.ask(WRITE, id_of(name) + b"\0\0\0") == id_of(name) + packed(name, bench.drone.param[name])


def test_bytes_behind_a_value_are_ignored_and_echoed(bench):
    payload = id_of("ring.effect") + b"\7\1\2\3"
    assert bench.ask(WRITE, payload) == payload
    bench.context.carry_out()
    assert bench.drone.param["ring.effect"] == 7


def test_read_only_parameter_is_not_answered(bench):
    """The firmware does not answer (9.4)."""
    assert bench.ask(WRITE, id_of("deck.bcFlow2") + b"\1") is None
    bench.context.carry_out()
    assert bench.drone.param["deck.bcFlow2"] == 0


def test_writes_do_not_pile_up_while_the_simulation_is_paused(bench):
    name = "ring.effect"
    for i in range(MAX_WRITES):
        assert bench.ask(WRITE, id_of(name) + bytes((i % 256,)))[2] == i % 256
    last = (MAX_WRITES - 1) % 256
    assert bench.ask(WRITE, id_of(name) + b"\xfe") == id_of(name) + bytes((last,))
    bench.context.carry_out()
    assert bench.drone.param[name] == last
    assert bench.ask(WRITE, id_of(name) + b"\xfe") == id_of(name) + b"\xfe"


def test_no_flood_of_other_requests_keeps_a_write_from_the_drone(bench):
    while bench.context.later(lambda: None):
        pass
    assert bench.ask(WRITE, id_of("ring.effect") + b"\5") == id_of("ring.effect") + b"\5"
    bench.context.carry_out()
    assert bench.drone.param["ring.effect"] == 5


# ------------------------------------------------------------------------------------ set by name


def by_name(name, type_byte, raw):
    return b"\0" + name.replace(".", "\0").encode() + b"\0" + bytes((type_byte,)) + raw


@pytest.mark.parametrize(
    ("name", "type_byte", "raw", "error"),
    [
        ("kalman.resetEstimation", 0x08, b"\1", 0),
        ("ring.effect", 0x08, b"\1", 0),
        ("ring.effect", 0x38, b"\1", 0),  # flags do not count
        ("ring.nothing", 0x08, b"\1", 2),
        ("posCtlPid.xKp", 0x08, b"\1", 22),
        ("posCtlPid.xKp", 0x06, b"\0\0", 22),
        ("posCtlPid.xKp", 0x06, struct.pack("<f", math.nan), 22),
        ("deck.bcFlow2", 0x08, b"\1", 13),
    ],
)
def test_set_by_name_has_the_error_numbers_of_the_firmware(bench, name, type_byte, raw, error):
    before = dict(bench.drone.param)
    request = by_name(name, type_byte, raw)
    assert bench.ask(MISC, request) == request[: len(name) + 2] + bytes((error,))
    bench.context.carry_out()
    changed = {key for key, value in bench.drone.param.items() if value != before[key]}
    assert changed == (set() if error else {name})


@pytest.mark.parametrize("payload", [b"\0", b"\0ring", b"\0ring\0effect", b"\0ring\0effect\0", b"\0" * 3])
def test_set_by_name_without_names_or_type_is_swallowed(bench, payload):
    assert bench.ask(MISC, payload) is None


# --------------------------------------------------------------------------- defaults and storage

PARAMETERS_BY_SIZE = {1: "ring.effect", 2: "supervisor.landedTimeout", 4: "posCtlPid.xKp"}


@pytest.mark.parametrize(("size", "name"), PARAMETERS_BY_SIZE.items())
def test_defaults_are_those_of_a_stock_drone(bench, size, name):
    bench.drone.param[name] = 3
    default = packed(name, Bench().drone.param[name])
    assert bench.ask(MISC, b"\x08" + id_of(name)) == b"\x08" + id_of(name) + b"\0" + default
    assert len(bench.ask(MISC, b"\x08" + id_of(name))) == 4 + size  # 5, 6 and 8 bytes in upstream's tests
    assert bench.ask(MISC, b"\x06" + id_of(name)) == b"\x06" + id_of(name) + default


@pytest.mark.parametrize("command", [6, 8])
@pytest.mark.parametrize("number", [id_of("deck.bcFlow2"), b"\xff\xff"])
def test_there_is_no_default_of_what_is_read_only_or_unknown(bench, command, number):
    request = bytes((command,)) + number
    assert bench.ask(MISC, request) == request + b"\2"


@pytest.mark.parametrize("command", range(2, 9))
def test_misc_command_about_an_unknown_parameter_is_no_entry(bench, command):
    request = bytes((command,)) + b"\xff\xff"
    assert bench.ask(MISC, request) == request + b"\2"


@pytest.mark.parametrize("command", [1, 9, 0xFF])
def test_misc_command_that_does_not_exist_is_swallowed(bench, command):
    assert bench.ask(MISC, bytes((command,)) + id_of("ring.effect")) is None


@pytest.mark.parametrize(("name", "kind"), [("ring.effect", 1), ("led.bitmask", None)])
def test_extended_types(bench, name, kind):
    expected = (b"\2", b"\2") if kind is None else (bytes((kind,)), bytes((0, kind)))
    assert bench.ask(MISC, b"\x02" + id_of(name)) == b"\x02" + id_of(name) + expected[0]
    assert bench.ask(MISC, b"\x07" + id_of(name)) == b"\x07" + id_of(name) + expected[1]


@pytest.mark.parametrize(("size", "name"), PARAMETERS_BY_SIZE.items())
def test_store_state_and_clear(bench, size, name):
    """Sizes of upstream's tests: 4 + size when nothing is stored, 4 + 2 size when something is."""
    default = packed(name, bench.drone.param[name])
    assert bench.ask(MISC, b"\x04" + id_of(name)) == b"\x04" + id_of(name) + b"\0" + default
    assert bench.ask(MISC, b"\x05" + id_of(name)) == b"\x05" + id_of(name) + b"\2"  # nothing to forget

    bench.ask(WRITE, id_of(name) + packed(name, 0x17))
    assert bench.ask(MISC, b"\x03" + id_of(name)) == b"\x03" + id_of(name) + b"\0"  # while it waits
    state = bench.ask(MISC, b"\x04" + id_of(name))
    assert state == b"\x04" + id_of(name) + b"\1" + default + packed(name, 0x17)
    assert len(state) == 4 + 2 * size

    assert bench.ask(MISC, b"\x05" + id_of(name)) == b"\x05" + id_of(name) + b"\0"
    assert bench.ask(MISC, b"\x04" + id_of(name)) == b"\x04" + id_of(name) + b"\0" + default


def test_only_persistent_parameters_are_stored(bench):
    assert bench.ask(MISC, b"\x03" + id_of("led.bitmask")) == b"\x03" + id_of("led.bitmask") + b"\2"


def test_what_is_stored_survives_reboot_reset_and_server(bench):
    bench.ask(WRITE, id_of("ring.effect") + b"\7")
    bench.ask(MISC, b"\x03" + id_of("ring.effect"))
    for boot in (bench.drone.reboot, bench.world.reset):
        bench.context.carry_out()
        bench.world.step(10)
        boot()
        assert bench.drone.param["ring.effect"] == 0
        bench.context.carry_out()
        assert bench.drone.param["ring.effect"] == 7
    again = Bench(world=bench.world)
    assert again.ask(MISC, b"\x04" + id_of("ring.effect"))[3:] == b"\1\0\7"
    assert Bench().ask(MISC, b"\x04" + id_of("ring.effect"))[3:] == b"\0\0"  # of another world


def test_a_folder_keeps_what_is_stored_for_the_next_world(tmp_path):
    first = Bench(tmp_path)
    for name, value in (("ring.effect", 7), ("posCtlPid.xKp", 1.1)):
        first.ask(WRITE, id_of(name) + packed(name, value))
        first.ask(MISC, b"\x03" + id_of(name))
    xkp = struct.unpack("<f", struct.pack("<f", 1.1))[0]
    assert json.loads((tmp_path / "cf1.json").read_text()) == {"prm/posCtlPid.xKp": xkp, "prm/ring.effect": 7}
    second = Bench(tmp_path)
    assert (second.drone.param["ring.effect"], second.drone.param["posCtlPid.xKp"]) == (7, xkp)
    assert [request.verb for request in second.world.journal] == ["param", "param"]
    second.ask(MISC, b"\x05" + id_of("ring.effect"))
    assert Bench(tmp_path).drone.param["ring.effect"] == 0


@pytest.mark.parametrize("content", ["", "[]", '{"ring.effect": 1}', '{"prm/ring.effect": "1"}', '{"prm/a.b": NaN}'])
def test_a_file_that_holds_something_else_is_refused(tmp_path, content):
    (tmp_path / "cf1.json").write_text(content)
    with pytest.raises(RangeError, match="cf1.json"):
        Bench(tmp_path)


def test_stored_values_that_this_drone_cannot_have_are_left_alone(tmp_path):
    stored = {"prm/my.own": 1, "prm/ring.effect": 300, "prm/led.bitmask": 5, "prm/posCtlPid.xKp": 1e39}
    (tmp_path / "cf1.json").write_text(json.dumps(stored))
    bench = Bench(tmp_path)
    fresh = Bench()
    assert dict(bench.drone.param) == dict(fresh.drone.param)
    assert bench.ask(MISC, b"\x04" + id_of("ring.effect"))[3:] == b"\0\0"
    bench.ask(MISC, b"\x03" + id_of("posCtlPid.yKp"))
    assert json.loads((tmp_path / "cf1.json").read_text()).keys() == stored.keys() | {"prm/posCtlPid.yKp"}


def test_a_folder_that_cannot_be_written_is_told(tmp_path):
    bench = Bench(tmp_path / "file" / "folder")
    (tmp_path / "file").write_text("")
    assert bench.ask(MISC, b"\x03" + id_of("ring.effect"))[3:] == b"\2"
    assert bench.ask(MISC, b"\x04" + id_of("ring.effect"))[3:] == b"\0\0"


# ----------------------------------------------------------------------------------- value updated


def test_a_change_by_the_drone_is_told_to_whoever_read_it(bench):
    name = "ring.effect"
    bench.ask(READ, id_of(name))
    bench.drone.param[name] = 9
    bench.drone.param["led.bitmask"] = 9  # which no client has read
    bench.world.step(100)
    assert bench.told() == [b"\1" + id_of(name) + b"\x09"]
    bench.world.step(200)
    assert bench.told() == []


def test_a_request_that_clears_itself_is_told(bench):
    """Written and cleared within a look: the client would go on to believe in the 1 that was echoed."""
    name = "supervisor.infdmp"
    bench.world.step(2000)  # until the supervisor works
    bench.ask(WRITE, id_of(name) + b"\1")
    bench.context.carry_out()
    bench.world.step(100)
    assert bench.told() == [b"\1" + id_of(name) + b"\0"]


def test_an_own_write_is_not_told(bench):
    bench.ask(WRITE, id_of("ring.effect") + b"\3")
    bench.world.step(100)
    bench.context.carry_out()
    bench.world.step(100)
    assert bench.told() == []


def test_a_client_that_has_gone_is_told_nothing(bench):
    bench.ask(READ, id_of("ring.effect"))
    bench.station.end_session()
    bench.drone.param["ring.effect"] = 9
    bench.world.step(100)
    assert bench.told() == []


def test_many_changes_are_told_little_by_little(bench):
    names = [name for name, row in parameter_table().items() if not row.is_read_only][: MAX_NEWS + 5]
    for name in names:
        bench.ask(READ, id_of(name))
        bench.drone.param[name] = bench.drone.param[name] + 1
    told = []
    for count in (MAX_NEWS, 5, 0):
        bench.world.step(100)
        news = bench.told()
        assert len(news) == count
        told += news
    assert sorted(told) == sorted(b"\1" + id_of(name) + packed(name, bench.drone.param[name]) for name in names)


# ------------------------------------------------------------------------------------- real client


@pytest.fixture
def client(bench):
    client = Client(bench.station)
    client.fetch_parameters()
    yield client
    client.close()


def test_cflib_knows_writes_and_stores_all_parameters(bench, client):
    """The table, extended types and values as a client fetches them, then what users do (9.6)."""
    param = client.cf.param
    known = {f"{group}.{name}": float(value) for group, row in param.values.items() for name, value in row.items()}
    assert known == pytest.approx(dict(bench.drone.param), rel=1e-6)
    persistent = {name for name, row in parameter_table().items() if row.is_persistent}
    assert {name for name in known if param.toc.get_element_by_complete_name(name).is_persistent()} == persistent

    heard = []
    param.add_update_callback("ring", "effect", lambda name, value: heard.append((name, value)))
    param.set_value("ring.effect", 8)
    client.read(until=lambda: heard)
    assert heard.pop() == ("ring.effect", "8")

    answers = []
    collect = lambda *answer: answers.append(answer)
    for call in (param.persistent_store, param.persistent_get_state, param.get_default_value, param.persistent_clear):
        call("ring.effect", collect)
        client.read(until=lambda: answers)
        heard.append(answers.pop())
    assert heard == [
        ("ring.effect", True),
        ("ring.effect", (True, 0, 8)),
        ("ring.effect", 0),
        ("ring.effect", True),
    ]

    bench.context.carry_out()
    bench.drone.param["ring.effect"] = 2
    bench.world.step(100)
    client.read()
    assert param.get_value("ring.effect") == "2"


def test_cflib_stores_parameters_of_a_deck_that_is_not_fitted(client):
    # what its example persistent_params_from_file.py does
    param, answers = client.cf.param, []
    collect = lambda *answer: answers.append(answer)
    param.set_value("activeMarker.back", 30)
    param.persistent_store("activeMarker.back", collect)
    client.read(until=lambda: answers)
    param.persistent_get_state("activeMarker.back", collect)
    client.read(until=lambda: len(answers) == 2)
    assert answers == [("activeMarker.back", True), ("activeMarker.back", (True, 3, 30))]


def test_cflib_writes_by_name(bench):
    client = Client(bench.station)
    client.cf.param.set_value_raw("kalman.resetEstimation", 0x08, 1)
    assert client.link.sent == [(2, 3, b"\0kalman\0resetEstimation\0\x08\1")]  # docs/reference/crtp-cflib.md#21
    assert client.link.arrived.get()[1:] == b"\0kalman\0resetEstimation\0\0"
    bench.context.carry_out()
    assert bench.drone.param["kalman.resetEstimation"] == 1


# ----------------------------------------------------------------------------------- hostile bytes

SHARED = Bench()


@given(st.integers(0, 3), st.binary(max_size=MAX_PAYLOAD))
def test_any_payload_is_survived(channel, payload):
    answer = SHARED.ask(channel, payload)
    SHARED.context.carry_out()
    assert answer is None or 1 <= len(answer) <= MAX_PAYLOAD


@given(st.integers(READ, WRITE), st.integers(0, len(NUMBERS) - 1), st.binary(max_size=MAX_PAYLOAD - 2))
def test_answers_about_known_parameters_have_the_size_that_cflib_unpacks(channel, number, rest):
    name = NAMES[number]
    row = parameter_table()[name]
    answer = SHARED.ask(channel, struct.pack("<H", number) + rest)
    SHARED.context.carry_out()
    size = row.dtype.itemsize
    assert answer is None or answer[:2] == struct.pack("<H", number)
    if channel == READ:
        assert len(answer) == 3 + size
    elif row.is_read_only:
        assert answer is None
    else:
        assert len(answer) == 2 + max(size, len(rest)) or len(answer) == 2 + size
    assert math.isfinite(SHARED.drone.param[name])


@given(st.integers(0, 8), st.integers(0, len(NUMBERS) + 3), st.binary(max_size=8))
def test_misc_answers_repeat_command_and_number(command, number, rest):
    request = struct.pack("<BH", command, number) + rest
    answer = SHARED.ask(MISC, request)
    SHARED.context.carry_out()
    if 2 <= command <= 8:
        assert answer[:3] == request[:3]
        assert 4 <= len(answer) <= 12
