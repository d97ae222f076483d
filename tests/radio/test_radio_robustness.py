"""Bad moments: stops while something else is under way, links that break, packets that cannot be made."""

import threading

import pytest

from crazychoir_fw.common.errors import RadioError, RangeError, StateError
from crazychoir_fw.radio import Mode, RadioHandler, RadioHandlerFPQR, RadioHandlerVel, RadioHandlerXYZ, ReconnectPolicy
from crazychoir_fw.radio.sender import Outbox

STOP = (7, 0, "00")
SOON = ReconnectPolicy(attempts=1000, first_wait_s=0.0, factor=1.0)


@pytest.fixture
def threaded(air):
    """Make a connected handler with threads, and close it in the end."""
    handlers = []

    def make(handler_class, **options):
        chosen = {"logger": False, "cache": None, "reset_estimator": False, "on_close": "leave", **options}
        handlers.append(handler_class(air.uris(1), **chosen))
        return handlers[-1].connect()

    yield make
    for handler in handlers:
        handler.close()


def test_a_stop_reaches_a_drone_whose_link_broke_before_it_left(threaded, air, eventually):
    swarm = threaded(RadioHandlerXYZ, reconnect=SOON)
    swarm.command(0, 0, 0, 1, 1)
    air["fake://0"].is_reachable = False
    air["fake://0"].break_link()
    eventually(lambda: swarm[0].losses == 1)
    swarm.stop()
    # attempts fail meanwhile
    heard = []
    swarm.on_state = lambda agent, state, reason: heard.append(str(state))
    eventually(lambda: heard.count("lost") >= 2)
    air["fake://0"].packets.clear()
    air["fake://0"].is_reachable = True
    eventually(lambda: swarm[0].is_connected)
    eventually(lambda: STOP in air["fake://0"].flown)
    assert swarm[0].is_stopped


@pytest.mark.parametrize("handler", [RadioHandlerVel, RadioHandlerFPQR])
def test_a_stop_ends_a_takeoff_that_waits(threaded, air, eventually, handler):
    air["fake://0"].bits = 0  # not ready yet
    swarm = threaded(handler)
    errors = []

    def take_off():
        try:
            swarm.takeoff(0.5)
        except StateError as error:
            errors.append(str(error))

    waiting = threading.Thread(target=take_off)
    waiting.start()
    eventually(lambda: (9, 0, b"\x0c") in air["fake://0"].packets)
    swarm.stop()
    air["fake://0"].bits = 0b1110
    waiting.join()
    assert errors == ["agent_0 (fake://0): takeoff: it was stopped meanwhile"]
    assert swarm[0].mode is Mode.STOPPED
    assert not [packet for packet in air["fake://0"].flown if packet[0] == 8 and packet[2][:2] != "03"]


def test_a_defect_while_a_drone_is_set_up_again_ends_no_attempts(threaded, air, eventually, monkeypatch):
    swarm = threaded(RadioHandler, reconnect=SOON)
    set_up, attempts = swarm[0]._link._set_up, []

    def fail_once(cf, is_first):
        attempts.append(is_first)
        if len(attempts) == 1:
            raise AttributeError("a defect")
        set_up(cf, is_first)

    monkeypatch.setattr(swarm[0]._link, "_set_up", fail_once)
    air["fake://0"].break_link()
    eventually(lambda: swarm[0].is_connected and len(attempts) == 2)
    assert attempts == [False, False]


def test_closing_ends_a_connection_attempt(air, eventually):
    air["fake://0"].is_silent = True
    swarm = RadioHandler(air.uris(1), logger=False, cache=None, answer_timeout_s=1000.0, connect_timeout_s=1000.0)
    errors = []

    def connect():
        try:
            swarm.connect()
        except RadioError as error:
            errors.append(str(error))

    calling = threading.Thread(target=connect, daemon=True)
    calling.start()
    eventually(lambda: air["fake://0"].links)
    swarm.close()
    eventually(lambda: not calling.is_alive())
    assert errors == ["agent_0: fake://0: closed"]


@pytest.mark.parametrize("number", [1e39, -1e300])
def test_numbers_that_no_packet_holds_are_refused(fly, air, number):
    swarm = fly(RadioHandlerXYZ)
    with pytest.raises(RangeError, match="x is"):
        swarm.command(0, number, 0, 1, 1)
    with pytest.raises(RangeError, match="height is"):
        swarm.takeoff(number)
    assert not swarm.external_pose(0, (0, 0, number), (0, 0, 0, 1))
    assert swarm.command(0, 1, 0, 1, 1)


def test_what_fails_to_leave_ends_no_outbox(eventually, caplog):
    done = []
    outbox = Outbox("test", lambda now: now + 1000.0, lambda: 0.0, threaded=True)
    outbox.begin()
    outbox.post(lambda: 1 / 0, lambda: 1 / 0, lambda: done.append(1))
    eventually(lambda: done)
    outbox.end()
    assert caplog.text.count("not sent") == 1  # the log has the same error once


def test_a_tick_that_fails_is_called_again(eventually):
    calls = []

    def tick(now):
        calls.append(now)
        if len(calls) == 1:
            raise OverflowError
        return now + 1000.0

    outbox = Outbox("test", tick, lambda: 0.0, threaded=True)
    outbox.begin()
    eventually(lambda: len(calls) == 2)
    outbox.end()
    assert calls == [0.0, 0.0]


def test_an_outbox_begins_again_while_its_old_thread_is_busy(eventually):
    done, is_busy, may_go_on = [], threading.Event(), threading.Event()
    outbox = Outbox("test", lambda now: now + 1000.0, lambda: 0.0, threaded=True)

    def work():
        is_busy.set()
        may_go_on.wait()

    outbox.begin()
    outbox.post(work)
    is_busy.wait()
    outbox.end()
    outbox.begin()
    may_go_on.set()
    outbox.post(lambda: done.append(1))
    eventually(lambda: done)
    outbox.end()
    assert done == [1]
