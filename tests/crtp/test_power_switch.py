"""The power switch of cflib, as it is, and served drones that it switches off, on, and boots."""

import logging

import pytest
from cflib.bootloader.cloader import Cloader
from cflib.crtp import get_link_driver, init_drivers
from cflib.utils import power_switch
from cflib.utils.power_switch import PowerSwitch
from server_clients import GREETING, NULL, SOURCE, events

from crazychoir_fw.crtp.services.param import ParamService

READY = 2200
"""Ticks from power on until a drone is ready to fly, at most."""


@pytest.fixture
def switch(open_server, monkeypatch):
    """Return a server and a power switch of its first drone."""
    init_drivers()
    server = open_server()
    opened = PowerSwitch(server.uris["cf1"])
    read = opened.link.receive_packet
    opened.patience = 10.0  # on a busy machine; its own tenth of a second where nothing is to come
    opened.link.receive_packet = lambda seconds: read(max(seconds, opened.patience))
    yield server, opened
    opened.close()


@pytest.fixture
def locked(world):
    """Return a drone that was locked up, with a parameter that is not at its default."""
    drone = world["cf1"]
    world.step(READY)
    drone.emergency_stop()
    drone.param["ctrlMel.kp_xy"] = 0.7
    world.step(200)
    assert drone.is_locked
    return drone


def cycle(opened, world, monkeypatch):
    monkeypatch.setattr(power_switch.time, "sleep", lambda seconds: world.step(round(1000 * seconds)))
    opened.stm_power_cycle()


@pytest.mark.parametrize("how", ["cycle", "reboot"])
def test_a_locked_drone_is_as_after_power_on(switch, locked, world, monkeypatch, how):
    _, opened = switch
    default = world["cf2"].param["ctrlMel.kp_xy"]
    if how == "cycle":
        cycle(opened, world, monkeypatch)
    else:
        opened.reboot_to_fw()
    world.step(READY)
    assert not locked.is_locked
    assert locked.can_fly
    assert locked.failure is None
    assert locked.param["ctrlMel.kp_xy"] == default != pytest.approx(0.7)


def test_stored_parameters_come_back(switch, locked, world):
    server, opened = switch
    service = next(s for s in server._radios[0].station.services if isinstance(s, ParamService))
    service._storage.store("ctrlMel.kp_xy", 0.55)
    opened.reboot_to_fw()
    world.step(READY)
    assert locked.param["ctrlMel.kp_xy"] == pytest.approx(0.55)


def test_only_the_radio_answers_without_power(switch, connect, world):
    server, opened = switch
    client, other = connect(server), connect(server)
    client.ask(SOURCE)
    opened.stm_power_down()
    client.send(SOURCE)
    assert client.ask(NULL) == NULL  # and no greeting before
    world.step(10)
    assert "power" in [reason for _, phase, reason in events(world) if phase == "end"]
    assert world["cf1"].failure is not None
    opened.stm_power_up()
    other.send(SOURCE)
    assert other.read() == GREETING
    world.step(READY)
    assert world["cf1"].failure is None


def test_nothing_answers_when_all_is_off_until_its_button_is_pressed(switch, connect, world):
    server, opened = switch
    client = connect(server)
    opened.platform_power_down()
    opened.patience = 0.0
    client.send(NULL)
    for press in (opened.stm_power_up, opened.reboot_to_fw):
        with pytest.raises(Exception, match="Failed to connect"):
            press()
    world.step(10)
    world["cf1"].reboot()
    world.step(READY)
    assert client.ask(SOURCE) == GREETING  # the null packet was not answered
    assert world["cf1"].failure is None


def test_the_boot_loader_is_refused(switch, world, caplog):
    _, opened = switch
    opened.patience = 1.0
    with (
        caplog.at_level(logging.WARNING, logger="crazychoir_fw.crtp"),
        pytest.raises(Exception, match="Failed to connect"),
    ):
        opened.reboot_to_bootloader()
    assert "cf1: a client asked for the boot loader: refused" in caplog.text
    world.step(1)
    assert "bootloader_refused" in [event.kind for event in world.events]
    world.step(READY)
    assert world["cf1"].can_fly


def test_the_loader_of_cflib_resets_to_the_firmware(switch, locked, world, monkeypatch):
    server, _ = switch
    loader = Cloader(None)
    loader.link = get_link_driver(server.uris["cf1"])
    monkeypatch.setattr("cflib.bootloader.cloader.time.sleep", lambda seconds: world.step(READY))
    assert loader.reset_to_firmware(0xFE)
    loader.close()
    assert locked.can_fly
