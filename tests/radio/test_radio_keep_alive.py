"""When set-points go out, are repeated, and cease; on a clock that the test advances."""

import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.radio import Mode, RadioHandlerFPQR, RadioHandlerFRPY, RadioHandlerVel, RadioHandlerXYZ
from crazychoir_fw.radio.poses import PoseThrottle
from crazychoir_fw.radio.sender import SetPointStream

HOVER = struct.pack("<Bffff", 8, 0, 0, 0, 0).hex(" ")


def at(clock, handler, air, start, times):
    """What is sent at times after the start (ms): the times at which something was."""
    sent = []
    for ms in times:
        clock.now = start + ms / 1000.0
        handler.tick()
        if air["fake://0"].take():
            sent.append(ms)
    return sent


def test_a_command_is_repeated_while_it_is_fresh(fly, air, clock):
    swarm = fly(RadioHandlerVel, keep_alive_hz=10, command_timeout_s=1.0, on_silence="nothing")
    swarm.command(0, 0.1, 0, 0)
    assert len(air["fake://0"].take()) == 1
    assert at(clock, swarm, air, clock.now, range(0, 3000, 20)) == list(range(100, 1000, 100))


def test_new_commands_need_no_repetition(fly, air, clock):
    swarm = fly(RadioHandlerVel)
    start, sent = clock.now, 0
    for i in range(50):
        clock.now = start + 0.05 * i
        swarm.command(0, 0.01 * i, 0, 0)
        clock.now += 0.025
        swarm.tick()
        sent += len(air["fake://0"].take())
    assert sent == 50


def test_of_too_many_commands_the_newest_goes_out(fly, air, clock):
    swarm = fly(RadioHandlerVel, max_rate_hz=10)
    for i in range(5):
        clock.now += 0.01
        swarm.command(0, 0.125 * i, 0, 0)
    assert len(air["fake://0"].take()) == 1
    clock.now += 0.1
    swarm.tick()
    assert air["fake://0"].take() == [(7, 0, struct.pack("<Bffff", 8, 0.5, 0, 0, 0).hex(" "))]


def test_whoever_is_silent_hovers(fly, air, clock):
    heard = []
    swarm = fly(RadioHandlerVel, command_timeout_s=0.5)
    swarm.on_event = lambda *event: heard.append(event)
    swarm.command(0, 0.5, 0, 0)
    air["fake://0"].take()
    clock.now += 0.5
    swarm.tick()
    assert air["fake://0"].take() == [(7, 0, HOVER)]
    assert heard == [("agent_0", "silence", "no command for 0.5 s: hover")]
    # for as long as it takes
    assert len(at(clock, swarm, air, clock.now, range(0, 10_000, 50))) == 99
    swarm.command(0, 0.5, 0, 0)
    assert air["fake://0"].take() == [(7, 0, struct.pack("<Bffff", 8, 0.5, 0, 0, 0).hex(" "))]


@pytest.mark.parametrize("handler", [RadioHandlerFPQR, RadioHandlerFRPY])
def test_whoever_is_silent_with_a_thrust_levels_and_stops(fly, air, clock, handler):
    swarm = fly(handler, command_timeout_s=0.2, level_s=2.0)
    swarm.takeoff()
    swarm.command(0, 0.3, 0.5, 0.5, 0.5)
    air["fake://0"].take()
    clock.now += 0.2
    swarm.tick()
    ((port, channel, packet),) = air["fake://0"].take()
    kind, roll, pitch, yaw_rate, thrust, is_rate = struct.unpack("<BfffHB", bytes.fromhex(packet))
    assert (port, channel, kind, roll, pitch, yaw_rate, is_rate) == (7, 0, 11, 0, 0, 0, 0)
    # a little below the weight of cf2, of which 65535 are 0.48 N
    assert thrust == pytest.approx(0.95 * 9.81 * 0.029 / 0.48 * 65535, rel=0.01)
    clock.now += 2.0
    swarm.tick()
    assert (7, 0, "00") in air["fake://0"].take()
    assert swarm[0].is_stopped


def test_a_command_ends_leveling(fly, air, clock):
    swarm = fly(RadioHandlerFRPY, command_timeout_s=0.2)
    swarm.takeoff()
    swarm.command(0, 0.3, 0, 0, 0)
    clock.now += 0.3
    swarm.tick()
    swarm.command(0, 0.3, 0, 0, 0)
    clock.now += 0.1
    swarm.tick()
    air["fake://0"].take()
    clock.now += 0.15
    swarm.tick()
    # level again, not stopped
    assert air["fake://0"].take()[0][2].startswith("0b")


@pytest.mark.parametrize(
    ("what", "ports", "mode"),
    [("land", [(7, 1), (8, 0)], Mode.LANDING), ("stop", [(7, 0), (8, 0), (7, 0)], Mode.STOPPED)],
)
def test_whoever_is_silent_lands_or_stops(fly, air, clock, what, ports, mode):
    swarm = fly(RadioHandlerVel, on_silence=what)
    swarm.command(0, 0.5, 0, 0)
    air["fake://0"].take()
    clock.now += 1.0
    swarm.tick()
    assert sorted(packet[:2] for packet in air["fake://0"].take()) == sorted(ports)
    assert swarm[0].mode is mode


def test_commands_can_be_repeated_for_ever(fly, air, clock):
    swarm = fly(RadioHandlerVel, on_silence="repeat", keep_alive_hz=5)
    swarm.command(0, 0.5, 0, 0)
    air["fake://0"].take()
    assert len(at(clock, swarm, air, clock.now, range(0, 60_001, 100))) == 300


def test_the_planner_on_board_needs_no_repetition(fly, air, clock):
    swarm = fly(RadioHandlerXYZ)
    swarm.command(0, 1, 1, 1, 2)
    air["fake://0"].take()
    assert at(clock, swarm, air, clock.now, range(0, 10_000, 50)) == []


def test_a_thread_repeats_by_itself(fly, air, eventually):
    import time

    swarm = fly(RadioHandlerVel, threaded=True, clock=time.monotonic, keep_alive_hz=50, on_silence="repeat")
    swarm.command(0, 0.5, 0, 0)
    eventually(lambda: len(air["fake://0"].flown) >= 5)
    assert {packet for packet in air["fake://0"].flown} == {(7, 0, struct.pack("<Bffff", 8, 0.5, 0, 0, 0).hex(" "))}


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"keep_alive_hz": 2}, "keep_alive_hz is 2, allowed: above 2"),
        ({"keep_alive_hz": float("nan")}, "keep_alive_hz is nan"),
        ({"command_timeout_s": 0}, "command_timeout_s is 0, allowed: a number above 0"),
        ({"on_silence": "panic"}, "on_silence is 'panic', allowed: hover, level, land"),
        ({"on_silence": "level"}, "on_silence is 'level', allowed for RadioHandlerVel"),
        ({"on_close": "fall"}, "on_close is 'fall', allowed: land, stop, leave"),
        ({"odometry_hz": 101}, "odometry_hz is 101, allowed: 0 to 100"),
        ({"speed": 1}, "there is no option 'speed', allowed: agent_parameters, answer_timeout_s"),
    ],
)
def test_options_that_are_none(options, text):
    with pytest.raises((RangeError, KeyError)) as caught:
        RadioHandlerVel(["fake://0"], **options)
    assert text in str(caught.value)


def test_leveling_needs_a_weight():
    with pytest.raises(RangeError, match="agent_0: on_silence 'level' needs its weight"):
        RadioHandlerFPQR(["fake://0"], thrust=0.5)
    RadioHandlerFPQR(["fake://0"], thrust=0.5, weight=0.3)
    RadioHandlerFPQR(["fake://0"], thrust=0.5, on_silence="stop")


@given(st.lists(st.tuples(st.sampled_from(["give", "tick"]), st.integers(1, 400)), max_size=60))
def test_a_stream_never_exceeds_its_rate_nor_forgets(steps):
    stream = SetPointStream(keep_alive_hz=10, max_rate_hz=50, timeout_s=1.0)
    now, last_sent, given_at, sent = 0.0, None, None, []
    for what, ms in steps:
        now += ms / 1000.0
        if what == "give":
            stream.give(lambda at=now: sent.append(at), now)
            given_at = now
        count = len(sent)
        send = stream.take(now)
        if send is not None:
            send()
            assert last_sent is None or now - last_sent >= 0.02 - 1e-6
            last_sent = now
            assert sent[-1] == given_at  # always the newest
        elif given_at is not None and now - given_at < 1.0:
            # nothing is due: it went out at most a repetition ago, or the gap is not over
            assert last_sent is not None
            assert now - last_sent < 0.1
        assert len(sent) - count <= 1


@given(st.floats(1.0, 99.0), st.floats(100.0, 400.0))
def test_poses_are_thinned_out_by_time(wanted, source):
    gate = PoseThrottle(wanted)
    passed = sum(gate.passes(i / source) for i in range(int(source * 20)))
    assert passed / 20 == pytest.approx(wanted, rel=0.02, abs=0.1)


def test_poses_of_an_irregular_source_and_after_a_gap():
    gate = PoseThrottle(50.0)
    assert gate.passes(0.0)
    assert not gate.passes(0.001)
    assert not gate.passes(0.019)
    assert gate.passes(0.02)
    assert gate.passes(10.0)
    # no backlog
    assert [gate.passes(10.0 + 0.001 * i) for i in range(1, 20)] == [False] * 19


def test_poses_at_exactly_the_rate_all_pass():
    gate = PoseThrottle(100.0)
    assert all(gate.passes(0.1 * 3 + i * 0.01) for i in range(1000))
