"""Links that open, hang, break, come back and end."""

import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

from crazychoir_fw.common.errors import RadioError, RangeError, UnknownNameError
from crazychoir_fw.radio import (
    LinkState,
    Mode,
    RadioHandler,
    RadioHandlerFPQR,
    RadioHandlerVel,
    RadioHandlerXYZ,
    ReconnectPolicy,
    leaving,
)

AT_ONCE = ReconnectPolicy(attempts=3, first_wait_s=0.0)


def plain(air, handler=RadioHandler, count=1, **options):
    chosen = {"logger": False, "cache": None, "reset_estimator": False, "on_close": "leave", **options}
    return handler(air.uris(count), **chosen)


def test_agents_have_names(air):
    uris = air.uris(3)
    assert RadioHandler(uris).agent_ids == ["agent_0", "agent_1", "agent_2"]
    assert RadioHandler(uris, [7, "left", 12]).agent_ids == ["agent_7", "left", "agent_12"]
    assert RadioHandler({"a": "radio://0/80/2M/E7E7E7E7FF", 3: "usb://0"}).agent_ids == ["a", "agent_3"]
    assert RadioHandler("fake://0")[0].uri == "fake://0"


@pytest.mark.parametrize(
    ("uris", "ids", "text"),
    [
        ([], None, "at least one drone"),
        (["fake://0"], [1, 2], "1 uris but 2 agent_ids"),
        (["fake://0", "fake://0"], None, "comes twice"),
        (["fake://0", "fake://1"], [1, 1], "agent_1 comes twice"),
        (["E7E7E7E701"], None, "agent_0: URI is 'E7E7E7E701', allowed for instance: udp://"),
        ({1: "fake://0"}, [1], "given twice"),
        (["fake://0"], [1.5], "agent id is 1.5"),
    ],
)
def test_agents_that_are_none(uris, ids, text):
    with pytest.raises(RangeError) as caught:
        RadioHandler(uris, ids)
    assert text in str(caught.value)


def test_an_unknown_agent(air):
    with pytest.raises(UnknownNameError, match="there is no agent 'agent_4', allowed: agent_0, agent_1"):
        RadioHandler(air.uris(2)).command(4, 0.0)


def test_all_links_are_opened_and_closed(air):
    states = []
    swarm = plain(air, count=4)
    swarm.on_state = lambda agent, state, _: states.append((agent, str(state)))
    with swarm as entered:
        assert entered is swarm
        assert all(drone.is_connected for drone in swarm)
        assert swarm[2].cf.link is air["fake://2"].link
    assert all(air[f"fake://{i}"].link.is_closed for i in range(4))
    assert [state for agent, state in states if agent == "agent_1"] == ["connecting", "connected", "closed"]
    swarm.close()
    with pytest.raises(RadioError, match=r"agent_1 \(fake://1\): not connected, the link is closed"):
        _ = swarm[1].cf


def test_links_are_closed_after_an_exception(air):
    with pytest.raises(ZeroDivisionError), plain(air, count=2):
        1 / 0  # noqa: B018
    assert all(air[f"fake://{i}"].link.is_closed for i in range(2))


def test_a_handler_connects_again_after_close(air):
    swarm = plain(air, RadioHandlerVel)
    with swarm:
        pass
    with swarm:
        assert swarm[0].is_connected
        assert swarm.command(0, 0.1, 0, 0)


def test_closing_does_not_stop_motors(air):
    """cflib itself would send a thrust of zero."""
    with plain(air):
        air["fake://0"].packets.clear()
    assert air["fake://0"].flown == [(7, 1, "00 00 00 00 00")]


@pytest.mark.parametrize(
    ("on_close", "packets"),
    [("stop", [(7, 0, "00")]), ("leave", []), ("land", [(8, 0, "08 00 00 00 00 00 00 00 00 00 01 00 00 00 40")])],
)
def test_what_flies_is_landed_stopped_or_left(air, eventually, monkeypatch, on_close, packets):
    swarm = plain(air, RadioHandlerVel, on_close=on_close, ready_timeout_s=0)
    with swarm:
        swarm.command(0, 0, 0, 0.5)
        eventually(lambda: air["fake://0"].flown[-1][0] == 7)
        air["fake://0"].bits |= 1 << 4
        monkeypatch.setattr(leaving, "_LONGEST_LANDING_S", 0.0)  # else 2 s
        air["fake://0"].packets.clear()
    # set-points may be repeated meanwhile
    said = [packet for packet in air["fake://0"].flown if packet[2][:2] != "08" or packet[0] == 8]
    for packet in packets:
        assert packet in said
    assert (on_close == "leave") == (said == [])


def test_what_flies_by_thrust_without_a_position_sinks_level_before_its_motors_stop(air, eventually):
    with plain(air, RadioHandlerFPQR, on_close="land", level_s=0.3, ready_timeout_s=0, arms=False) as swarm:
        swarm[0].takeoff()
        swarm.command(0, 0.3, 0, 0, 0)
        eventually(lambda: air["fake://0"].flown[-1][0] == 3)
        air["fake://0"].bits |= 1 << 4
        air["fake://0"].packets.clear()
    said = air["fake://0"].flown
    ports = [(port, channel, data[:2]) for port, channel, data in said if (port, channel) != (7, 1)]
    level, stop = (7, 0, "0b"), (7, 0, "00")
    assert ports.count(level) >= 2
    assert max(k for k, packet in enumerate(ports) if packet == level) < ports.index(stop)


def test_a_drone_that_is_not_there(air):
    swarm = plain(air, count=3)
    air["fake://1"].is_reachable = False
    with pytest.raises(RadioError, match=r"^agent_1: fake://1: Couldn't load link driver: no such drone in the air$"):
        swarm.connect()
    assert air["fake://0"].link.is_closed
    assert swarm[0].link_state is LinkState.CLOSED


def test_a_uri_that_nobody_knows(air):
    with pytest.raises(RadioError, match="carrier-pigeon://1: No driver found or malformed URI"):
        RadioHandler(["carrier-pigeon://1"], cache=None).connect()


def test_a_silent_drone_does_not_hang(air):
    swarm = plain(air, count=2, answer_timeout_s=0.05)
    for drone in (air["fake://0"], air["fake://1"]):
        drone.is_silent = True
    with pytest.raises(RadioError) as caught:
        swarm.connect()
    assert str(caught.value).startswith("2 of 2 drones: agent_0: fake://0: no answer within the time allowed; is the")
    assert "agent_1: fake://1: no answer" in str(caught.value)


@pytest.mark.parametrize(("port", "what"), [(5, "tables of contents"), (2, "tables of contents")])
def test_a_drone_that_stops_answering_does_not_hang(air, port, what):
    swarm = plain(air, connect_timeout_s=0.1)
    air["fake://0"].mute_ports = {port}
    with pytest.raises(RadioError, match=f"agent_0: fake://0: it answers, but its {what} did not come"):
        swarm.connect()


def test_parameters_are_waited_for_where_some_are_set(air):
    class Deaf(type(air["fake://0"])):
        def _param(self, channel, data):
            return [] if channel == 1 else super()._param(channel, data)

    air["fake://0"].__class__ = Deaf
    with plain(air) as swarm:
        assert swarm[0].is_connected
    with pytest.raises(RadioError, match="values of all parameters did not come"):
        plain(air, RadioHandlerFPQR, connect_timeout_s=0.2).connect()


def test_some_may_be_missing(air):
    swarm = plain(air, RadioHandlerVel, count=3)
    air["fake://1"].is_reachable = False
    swarm.connect(all_or_none=False)
    assert [drone.is_connected for drone in swarm] == [True, False, True]
    assert swarm.command_all(0.1, 0, 0) == {"agent_0": True, "agent_1": False, "agent_2": True}
    swarm.close()


def test_a_lost_drone_is_called_again(air, eventually):
    states = []
    swarm = plain(air, RadioHandlerVel, count=2, reconnect=AT_ONCE)
    swarm.on_state = lambda agent, state, reason: states.append((agent, str(state), reason))
    with swarm:
        states.clear()
        old = swarm[0].cf
        air["fake://0"].break_link("gone away")
        eventually(lambda: len(air["fake://0"].links) == 2 and swarm[0].is_connected)
        assert states == [
            ("agent_0", "lost", "gone away"),
            ("agent_0", "reconnecting", "attempt 1"),
            ("agent_0", "connected", ""),
        ]
        assert swarm[0].cf is not old
        assert swarm[0].losses == 1
        assert swarm[1].is_connected
        # it may lie on the floor
        assert swarm[0].mode is Mode.LOST
        assert not swarm.command(0, 0.1, 0, 0)
        assert swarm.command(1, 0.1, 0, 0)
        swarm.resume(0)
        assert swarm.command(0, 0.1, 0, 0)


def test_parameters_and_logs_come_back_but_nothing_that_disturbs_a_flight(air, eventually):
    swarm = plain(air, RadioHandlerXYZ, reconnect=AT_ONCE, logger=True, reset_estimator=True)
    with swarm:
        drone = air["fake://0"]
        assert ("kalman.resetEstimation", 1) in drone.writes
        drone.writes.clear()
        drone.packets.clear()
        drone.bits |= 1 << 4  # it flies by its planner
        drone.break_link()
        eventually(lambda: swarm[0].is_connected and len(drone.links) == 2)
        assert {name for name, _ in drone.writes} == {"stabilizer.estimator", "locSrv.extQuatStdDev"}
        assert drone.flown == []
        assert len(drone.blocks) == 1


def test_thrust_is_locked_again_after_a_loss(air, eventually):
    with plain(air, RadioHandlerFPQR, reconnect=AT_ONCE) as swarm:
        swarm.takeoff()
        air["fake://0"].break_link()
        eventually(lambda: swarm[0].losses == 1 and swarm[0].is_connected)
        swarm.resume()
        assert not swarm.command(0, 0.3, 0, 0, 0)
        swarm.takeoff()
        assert swarm.command(0, 0.3, 0, 0, 0)


def test_commands_go_on_by_themselves_where_wanted(air, eventually):
    with plain(air, RadioHandlerVel, reconnect=ReconnectPolicy(3, 0.0, resumes=True)) as swarm:
        air["fake://0"].break_link()
        eventually(lambda: swarm[0].losses == 1 and swarm[0].is_connected)
        assert swarm.command(0, 0.1, 0, 0)


def test_a_stopped_drone_stays_stopped_through_a_loss(air, eventually):
    with plain(air, RadioHandlerVel, reconnect=AT_ONCE) as swarm:
        swarm.stop()
        air["fake://0"].break_link()
        eventually(lambda: swarm[0].losses == 1 and swarm[0].is_connected)
        assert swarm[0].is_stopped
        assert not swarm.command(0, 0.1, 0, 0)


def test_an_emergency_stop_reaches_a_drone_that_was_out_of_reach(air, eventually):
    drone = air["fake://0"]
    with plain(air, RadioHandlerVel, reconnect=ReconnectPolicy(100, 0.01, 1.0)) as swarm:
        drone.is_reachable = False
        drone.break_link()
        eventually(lambda: not swarm[0].is_connected)
        drone.packets.clear()
        swarm.emergency_stop()
        swarm.resume()
        drone.is_reachable = True
        eventually(lambda: (9, 1, "03") in drone.flown)
        swarm.stop()  # whose packets come behind everything else
        eventually(lambda: (7, 0, "00") in drone.flown)
        assert drone.flown.count((9, 1, "03")) == 1


def test_nothing_is_armed_behind_the_back_of_its_user(air, eventually):
    near, far = air["fake://0"], air["fake://1"]
    with plain(air, RadioHandlerVel, count=2, reconnect=ReconnectPolicy(100, 0.01, 1.0)) as swarm:
        far.is_reachable = False
        far.break_link()
        eventually(lambda: not swarm[1].is_connected)
        for call, packet in ((swarm.arm, "01 01"), (swarm.recover, "02")):
            with pytest.raises(RadioError, match=r"agent_1 \(fake://1\): not connected"):
                call()
            eventually(lambda packet=packet: (9, 1, packet) in near.flown)
        far.is_reachable = True
        eventually(lambda: swarm[1].is_connected)
        far.packets.clear()
        swarm.stop()
        eventually(lambda: (7, 0, "00") in far.flown)
        assert (9, 1, "01 01") not in far.flown


def test_a_drone_that_does_not_come_back_is_given_up(air, eventually):
    with plain(air, RadioHandlerVel, count=2, reconnect=AT_ONCE) as swarm:
        air["fake://0"].is_reachable = False
        air["fake://0"].break_link()
        eventually(lambda: swarm[0].link_state is LinkState.DISCONNECTED)
        assert not swarm.command(0, 0.1, 0, 0)
        with pytest.raises(RadioError, match="given up after 3 attempts: .*no such drone in the air"):
            _ = swarm[0].cf
        assert swarm.command(1, 0.1, 0, 0)


def test_nobody_is_called_again_against_the_users_will(air, eventually):
    with plain(air, RadioHandlerVel, reconnect=None) as swarm:
        air["fake://0"].break_link()
        eventually(lambda: swarm[0].link_state is LinkState.DISCONNECTED)
        assert len(air["fake://0"].links) == 1


def test_a_link_that_breaks_under_the_thread_that_pings(air, eventually):
    """There cflib waits for itself, and leaves its lock taken (release 0.1.34)."""

    class Breaks(type(air["fake://0"])):
        breaks = False

        def answer(self, port, channel, data):
            if self.breaks and port == 15:
                self.link.error_callback("could not send")
                return []
            return super().answer(port, channel, data)

    air["fake://0"].__class__ = Breaks
    with plain(air, RadioHandlerVel, reconnect=None) as swarm:
        cf = swarm[0].cf
        air["fake://0"].breaks = True
        eventually(lambda: swarm[0].link_state is LinkState.DISCONNECTED)
        assert not cf._send_lock.locked()


def test_waits_of_the_policy():
    assert list(ReconnectPolicy(5, 0.5, 2.0, 3.0).waits()) == [0.5, 1.0, 2.0, 3.0, 3.0]
    assert list(ReconnectPolicy(0).waits()) == []
    for wrong in ({"attempts": -1}, {"factor": 0.5}, {"first_wait_s": float("inf")}):
        with pytest.raises(RangeError):
            ReconnectPolicy(**wrong)


def test_tables_of_contents_are_kept(air, tmp_path):
    cache = tmp_path / "tables"
    with plain(air, cache=cache):
        cold = len(air["fake://0"].packets)
    assert len(list(cache.glob("*.json"))) == 2
    air["fake://0"].packets.clear()
    with plain(air, cache=cache):
        assert len(air["fake://0"].packets) < cold


def test_links_are_closed_when_a_program_fails():
    """Also those of a program that forgets them, whose threads of cflib would keep it alive."""
    program = textwrap.dedent(
        """
        import sys
        sys.path.insert(0, sys.argv[1])
        from fake_drone import FakeAir, install
        from crazychoir_fw.radio import RadioHandlerVel
        air = FakeAir()
        install(air)
        swarm = RadioHandlerVel(air.uris(2), cache=None, reset_estimator=False, on_close="stop")
        swarm.on_state = lambda agent, state, reason: sys.stdout.write(f"{agent} {state}\\n")
        swarm.connect()
        swarm.command(0, 0, 0, 0.5)
        raise SystemError("the program fails")
        """
    )
    run = subprocess.run(
        [sys.executable, "-c", program, str(Path(__file__).parent)], capture_output=True, text=True, timeout=60
    )
    assert run.returncode == 1
    assert "the program fails" in run.stderr
    assert {"agent_0 closed", "agent_1 closed"} <= set(run.stdout.splitlines())


def test_callbacks_may_fail(air, eventually, caplog):
    swarm = plain(air, RadioHandlerVel)
    swarm.on_state = lambda *_: 1 / 0
    with swarm:
        assert swarm[0].is_connected
    assert "ZeroDivisionError" in caplog.text


def test_without_cflib_the_error_says_what_to_install():
    program = "import sys; sys.modules['cflib'] = None; import crazychoir_fw.radio"
    run = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    said = "MissingLibraryError: the radio layer needs cflib, 0.1.32 or newer: run pip install 'crazychoir-fw[radio]'"
    assert said in run.stderr
