"""Drones that are switched off and on."""

import pytest

from crazychoir_fw.common.errors import RadioError, StateError
from crazychoir_fw.radio import RadioHandlerXYZ, connection
from crazychoir_fw.radio import drone as drone_module
from crazychoir_fw.radio.link import LinkState
from crazychoir_fw.radio.modes import Mode


@pytest.fixture
def switches(monkeypatch):
    """Power switches that write down what they are asked for."""
    pressed = []

    class Switch:
        def __init__(self, uri):
            if "nobody" in uri:
                raise OSError("no Crazyradio")
            self.uri = uri

        def stm_power_cycle(self):
            pressed.append(self.uri)

        def close(self):
            pressed.append("closed")

    monkeypatch.setattr(connection, "PowerSwitch", Switch)
    monkeypatch.setattr(drone_module, "BOOT_S", 0.0)
    return pressed


@pytest.mark.parametrize(("uri", "can"), [("radio://0/80/2M/E7E7E7E701", True), ("udp://127.0.0.1:19850", False)])
def test_only_a_radio_switches(switches, uri, can):
    assert connection.can_switch(uri) is can
    if can:
        connection.power_cycle("a", uri)
        assert switches == [uri, "closed"]
    else:
        with pytest.raises(StateError, match="a: its power can be switched over radio:// only"):
            connection.power_cycle("a", uri)
        assert switches == []


def test_what_the_client_library_raises_is_a_sentence(switches):
    with pytest.raises(RadioError, match="b: the power could not be switched: no Crazyradio"):
        connection.power_cycle("b", "radio://nobody")


def test_a_drone_is_switched_off_and_on_and_is_there_again(fly, air, switches, monkeypatch):
    monkeypatch.setattr(connection, "can_switch", lambda uri: True)
    monkeypatch.setattr(drone_module, "can_switch", lambda uri: True)
    handler = fly(RadioHandlerXYZ)
    (drone,) = handler
    drone.stop()
    before = drone.cf
    drone.reboot()
    assert switches == [drone.uri, "closed"]
    assert drone.link_state is LinkState.CONNECTED
    assert drone.cf is not before
    assert drone.mode is Mode.LOST  # until the caller resumes it
    drone.resume()
    assert drone.command(0.0, 0.0, 0.5, 1.0)


def test_a_drone_that_flies_or_cannot_be_switched_is_left_alone(fly, air, switches, monkeypatch):
    handler = fly(RadioHandlerXYZ)
    (drone,) = handler
    with pytest.raises(StateError, match="over radio:// only"):
        drone.reboot()
    monkeypatch.setattr(drone_module, "can_switch", lambda uri: True)
    air[drone.uri].bits |= 1 << 4
    with pytest.raises(StateError, match="it flies"):
        drone.reboot()
    assert switches == []
    assert drone.is_connected
