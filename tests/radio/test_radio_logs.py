"""What drones say about themselves."""

import errno
import math

import numpy as np
import pytest
from cflib.crazyflie.log import LogTocElement
from hypothesis import given
from hypothesis import strategies as st

from crazychoir_fw.common.errors import RadioError, RangeError, UnknownNameError
from crazychoir_fw.radio import RadioHandler, RadioHandlerVel, RadioHandlerVelLightHouse
from crazychoir_fw.radio.logs import DroneClock, log_blocks

LOGGING = 5
TYPES = {name: size for name, _, size in LogTocElement.types.values()}


class Table:
    """A table of contents with one variable of every type, many times."""

    def __init__(self, types):
        self.toc = {"g": {f"v{i}": type("Element", (), {"ctype": kind}) for i, kind in enumerate(types)}}

    def get_element(self, group, name):
        return self.toc.get(group, {}).get(name)


def test_nothing_is_logged_without_a_logger(fly, air):
    fly(RadioHandlerVelLightHouse, logger=False, log={"pm.vbat": 1.0})
    assert air["fake://0"].blocks == {}


def test_the_usual_log(fly, air, eventually):
    heard = []
    swarm = fly(RadioHandler, logger=True)
    swarm.on_log = lambda *what: heard.append(what)
    assert list(air["fake://0"].blocks.values()) == [(["stabilizer.roll", "stabilizer.pitch", "stabilizer.yaw"], 200)]
    air["fake://0"].log(2500, stabilizer__roll=1.5, stabilizer__yaw=-2.0)
    eventually(lambda: heard)
    values = {"stabilizer.roll": 1.5, "stabilizer.pitch": 0.0, "stabilizer.yaw": -2.0}
    assert heard == [("agent_0", values, 2.5)]
    assert swarm[0].latest["stabilizer.roll"] == (1.5, 2.5, 100.0)


def test_rates_and_many_variables(fly, air):
    names = [name for name in air["fake://0"].logs if not name.startswith("stateEstimateZ")]
    fly(RadioHandler, logger=True, log=dict.fromkeys(names, 100) | {"pm.vbat": 1.0})
    blocks = list(air["fake://0"].blocks.values())
    # seven floats are 28 bytes, and the eighth has another rate
    assert sorted((len(variables), period) for variables, period in blocks) == [(1, 1000), (6, 10)]


def test_more_than_one_block(fly, air):
    air["fake://0"].logs.update({f"extra.v{i}": "float" for i in range(20)})
    fly(RadioHandler, logger=True, log={f"extra.v{i}": 50 for i in range(20)})
    blocks = [variables for variables, _ in air["fake://0"].blocks.values()]
    assert [len(variables) for variables in blocks] == [6, 6, 6, 2]
    assert [name for block in blocks for name in block] == [f"extra.v{i}" for i in range(20)]


@pytest.mark.parametrize(
    ("log", "error", "text"),
    [
        ({"pm.vbatt": 1}, UnknownNameError, "there is no log variable 'pm.vbatt'; do you mean pm.vbat?"),
        ({"vbat": 1}, UnknownNameError, "there is no log variable 'vbat'"),
        ({"pm.vbat": 0}, RangeError, "log variable 'pm.vbat': rate is 0, allowed: 0.394 to 100 Hz"),
        ({"pm.vbat": 1000}, RangeError, "rate is 1000, allowed: 0.394 to 100 Hz"),
        ({"pm.vbat": 0.1}, RangeError, "rate is 0.1, allowed"),
        ({"pm.vbat": math.nan}, RangeError, "rate is nan, allowed"),
    ],
)
def test_logs_that_are_none(fly, air, log, error, text):
    with pytest.raises(error) as caught:
        fly(RadioHandler, logger=True, log=log)
    assert str(caught.value).startswith("agent_0 (fake://0): ")
    assert text in str(caught.value)
    assert air["fake://0"].link.is_closed


def test_more_than_a_drone_can_log(fly, air):
    air["fake://0"].logs.update({f"extra.v{i}": "float" for i in range(130)})
    with pytest.raises(RangeError, match="130 log variables make 22 blocks, allowed: 128 variables in 16 blocks"):
        fly(RadioHandler, logger=True, log={f"extra.v{i}": 50 for i in range(130)})


def test_a_block_that_the_drone_refuses(fly, air):
    air["fake://0"].refuses_blocks = 12
    with pytest.raises(RadioError, match="log block of stabilizer.roll, .* was refused: No more memory available"):
        fly(RadioHandler, logger=True)


def test_a_block_that_is_not_confirmed(fly, air):
    class Deaf(type(air["fake://0"])):
        def _log(self, channel, data):
            return [] if channel == 1 and data[0] == 6 else super()._log(channel, data)

    air["fake://0"].__class__ = Deaf
    with pytest.raises(RadioError, match=r"was not confirmed within 0.05 s"):
        fly(RadioHandler, logger=True, confirm_timeout_s=0.05)


def test_odometry(fly, air, eventually):
    heard = []
    swarm = fly(RadioHandlerVelLightHouse, logger=True, log={})
    swarm.on_odometry = lambda *what: heard.append(what)
    ((names, period),) = air["fake://0"].blocks.values()
    assert period == 20
    assert len(names) == 10
    quarter = 0xC0000000 | 0x1FF  # w is the largest, and z as large: a quarter of a turn to the left
    state = {"x": 1000, "y": -2000, "z": 500, "vx": 10, "vy": 20, "vz": -30, "quat": quarter}
    state |= {"rateRoll": 100, "ratePitch": 200, "rateYaw": 300}
    air["fake://0"].log(1234, **{f"stateEstimateZ__{name}": value for name, value in state.items()})
    eventually(lambda: heard)
    agent, odometry = heard[0]
    assert agent == "agent_0"
    np.testing.assert_allclose(odometry.position, (1, -2, 0.5))
    np.testing.assert_allclose(odometry.velocity, (0.01, 0.02, -0.03))
    np.testing.assert_allclose(odometry.quat_xyzw, (0, 0, math.sqrt(0.5), math.sqrt(0.5)), atol=1e-6)
    # right-handed: the drone counts a nose that rises as positive
    np.testing.assert_allclose(odometry.body_rates, (0.1, -0.2, 0.3))
    assert (odometry.time_s, odometry.received_s) == (1.234, 100.0)
    np.testing.assert_array_equal(swarm[0].position, odometry.position)


def test_odometry_of_firmware_that_logs_less(fly, air, eventually):
    air["fake://0"].logs = {name: kind for name, kind in air["fake://0"].logs.items() if "Z." not in name}
    swarm = fly(RadioHandlerVelLightHouse, logger=True, log={})
    air["fake://0"].log(0, kalman__stateX=0.5, kalman__stateZ=1.5)
    eventually(lambda: swarm[0].odometry is not None)
    assert tuple(swarm[0].odometry.position) == (0.5, 0, 1.5)
    assert tuple(swarm[0].odometry.quat_xyzw) == (0, 0, 0, 1)


def test_a_callback_that_fails_stops_no_log(fly, air, eventually, caplog):
    swarm = fly(RadioHandlerVel, logger=True)
    swarm.on_log = lambda *_: 1 / 0
    for i in range(3):
        air["fake://0"].log(i, stabilizer__roll=i)
    eventually(lambda: swarm[0].latest.get("stabilizer.roll", (0,))[0] == 2)
    assert "ZeroDivisionError" in caplog.text


def test_the_clock_of_a_drone_goes_on_after_its_stamps_begin_anew():
    clock = DroneClock()
    stamps = [0xFFFFF0, 0xFFFFFA, 0x000004, 0xFFFFFF, 0x00000E]
    assert [clock.seconds(stamp) for stamp in stamps] == pytest.approx(
        [16777.2, 16777.21, 16777.22, 16777.215, 16777.23]
    )


@given(st.lists(st.tuples(st.sampled_from(sorted(TYPES)), st.sampled_from([1, 10, 33, 100])), min_size=1, max_size=60))
def test_blocks_hold_everything_once_and_fit(variables):
    table = Table([kind for kind, _ in variables])
    wanted = {f"g.v{i}": rate for i, (_, rate) in enumerate(variables)}
    blocks = log_blocks("cf", wanted, table)
    assert sorted(name for block in blocks for name in block.names) == sorted(wanted)
    for block in blocks:
        assert sum(TYPES[table.get_element("g", name[2:]).ctype] for name in block.names) <= 26
        assert block.period_ms % 10 == 0
        for name in block.names:
            assert block.period_ms == pytest.approx(1000 / wanted[name], abs=5.01)


def test_stamps_of_24_bits(fly, air, eventually):
    swarm = fly(RadioHandler, logger=True)
    air["fake://0"].log(0x123456, stabilizer__roll=1.0)
    eventually(lambda: "stabilizer.roll" in swarm[0].latest)
    assert swarm[0].latest["stabilizer.roll"].time_s == 0x123456 / 1000


def test_logs_that_a_drone_has_deleted_are_started_again(fly, air, clock, eventually):
    drone, told = air["fake://0"], []
    swarm = fly(RadioHandlerVelLightHouse, logger=True)
    swarm.on_event = lambda *what: told.append(what)
    blocks = dict(drone.blocks)
    assert len(blocks) == 2
    drone.blocks.clear()  # as after a second without a packet
    clock.now += 1.4
    swarm.tick()
    drone.log(10)
    assert drone.blocks == {}
    clock.now += 0.2
    swarm.tick()
    eventually(lambda: drone.blocks == blocks)
    assert [(agent, kind) for agent, kind, _ in told] == [("agent_0", "logs")]
    drone.log(2000, stateEstimateZ__x=1500, stabilizer__roll=3.0)
    eventually(lambda: swarm[0].odometry is not None and "stabilizer.roll" in swarm[0].latest)
    assert swarm[0].position[0] == 1.5


def test_logs_that_are_deleted_twice(fly, air, clock, eventually):
    drone, told = air["fake://0"], []
    swarm = fly(RadioHandler, logger=True)
    swarm.on_event = lambda *what: told.append(what)
    for stamp in (1000, 2000):
        drone.blocks.clear()
        clock.now += 2.0
        swarm.tick()
        eventually(lambda: drone.blocks and all(period for _, period in drone.blocks.values()))
        clock.now += 0.2
        drone.log(stamp, stabilizer__roll=stamp)
        eventually(lambda stamp=stamp: swarm[0].latest.get("stabilizer.roll", (0,))[0] == stamp)
        clock.now += 0.2
        drone.log(stamp + 200)
        eventually(lambda stamp=stamp: swarm[0].latest["stabilizer.roll"].time_s == (stamp + 200) / 1000)
    assert len(told) == 2


def test_a_drone_that_refuses_to_start_a_block_is_not_asked_at_once_again(fly, air, clock, eventually):
    class Refuses(type(air["fake://0"])):
        def _log(self, channel, data):
            if channel != 1:
                return super()._log(channel, data)
            commands.append(data[0])
            return [(1, bytes((*data[:2], errno.ENOMEM)))]

    drone, commands, told = air["fake://0"], [], []
    swarm = fly(RadioHandler, logger=True)
    swarm.on_event = lambda *what: told.append(what)
    drone.__class__ = Refuses
    block = swarm[0].cf.log.log_blocks[0]
    refusals = []
    block.started_cb.add_callback(lambda *_: refusals.append(block.err_no))
    for number in (1, 2):
        clock.now += 60.0
        swarm.tick()
        eventually(lambda number=number: len(refusals) == number)
    start = 3
    assert (refusals, commands, told) == ([errno.ENOMEM] * 2, [start] * 2, [])


def test_questions_that_are_lost_are_asked_again(fly, air, clock, eventually):
    class Deaf(type(air["fake://0"])):
        def _log(self, channel, data):
            if channel != 1 or data[0] in heard:
                return super()._log(channel, data)
            missed.append(data[0])
            return []

    create, start = 6, 3
    drone, heard, missed = air["fake://0"], {create, start}, []
    swarm = fly(RadioHandler, logger=True)
    blocks = dict(drone.blocks)
    drone.__class__ = Deaf
    drone.blocks.clear()
    for now_heard, missing in ((set(), start), ({start}, create), ({create}, start), ({create, start}, None)):
        clock.now += 60.0
        heard.clear()
        heard.update(now_heard)
        missed.clear()
        swarm.tick()
        if missing is not None:
            eventually(lambda missing=missing: missing in missed)
    eventually(lambda: drone.blocks == blocks)
    assert swarm[0].is_connected


def test_slow_logs_are_not_disturbed_for_long(fly, air, clock, eventually):
    drone = air["fake://0"]
    swarm = fly(RadioHandler, logger=True)
    asked = []
    for second in range(1, 61):
        clock.now += 1.0
        drone.packets.clear()
        swarm.tick()
        if LOGGING in drone.ports:
            asked.append(second)
        if second % 4 == 0:  # of five per second, at a twentieth of the speed
            drone.log(second)
            eventually(
                lambda second=second: swarm[0].latest and swarm[0].latest["stabilizer.roll"].time_s == second / 1000
            )
    assert asked == [2]


def test_without_a_link_nothing_is_asked(fly, air, clock, eventually):
    drone = air["fake://0"]
    swarm = fly(RadioHandler, logger=True, reconnect=None)
    drone.break_link()
    eventually(lambda: not swarm[0].is_connected)
    drone.packets.clear()
    clock.now += 10.0
    swarm.tick()
    assert LOGGING not in drone.ports
