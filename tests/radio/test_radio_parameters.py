"""Parameters that handlers write: their own and the user's."""

import pytest

from crazychoir_fw.common.errors import RadioError, RangeError, UnknownNameError
from crazychoir_fw.radio import (
    RadioHandler,
    RadioHandlerFPQR,
    RadioHandlerFRPY,
    RadioHandlerVel,
    RadioHandlerVelLightHouse,
    RadioHandlerXYZ,
    RadioHandlerXYZLightHouse,
)

POSITION = [("stabilizer.estimator", 2), ("locSrv.extQuatStdDev", pytest.approx(0.06))]
RESET = [("kalman.resetEstimation", 1), ("kalman.resetEstimation", 0)]


@pytest.mark.parametrize(
    ("handler", "written"),
    [
        (RadioHandler, []),
        # roll, pitch and yaw as rates
        (RadioHandlerFPQR, [(f"flightmode.stabMode{axis}", 0) for axis in ("Roll", "Pitch", "Yaw")]),
        # and as angles
        (RadioHandlerFRPY, [(f"flightmode.stabMode{axis}", 1) for axis in ("Roll", "Pitch", "Yaw")]),
        (RadioHandlerVel, POSITION + RESET),
        (RadioHandlerVelLightHouse, POSITION + RESET),
        # this firmware has no commander.enHighLevel, like the newest
        (RadioHandlerXYZ, POSITION + RESET),
        (RadioHandlerXYZLightHouse, POSITION + RESET),
    ],
)
def test_presets(fly, air, handler, written):
    fly(handler, reset_estimator=True)
    assert air["fake://0"].writes == written


def test_a_parameter_that_older_firmware_needs(fly, air):
    air["fake://0"].parameters["commander.enHighLevel"] = (0x08, 0)
    fly(RadioHandlerXYZ)
    assert ("commander.enHighLevel", 1) in air["fake://0"].writes


def test_presets_can_be_left_out(fly, air):
    fly(RadioHandlerXYZ, presets=False, reset_estimator=True)
    assert air["fake://0"].writes == []


def test_the_users_own_come_last_and_win(fly, air):
    fly(
        RadioHandlerVel,
        2,
        parameters={"stabilizer.controller": 2, "locSrv.extQuatStdDev": 0.5},
        agent_parameters={1: {"stabilizer.controller": 4}},
    )
    common = [("stabilizer.estimator", 2)]
    assert air["fake://0"].writes == [*common, ("stabilizer.controller", 2), ("locSrv.extQuatStdDev", 0.5)]
    assert air["fake://1"].writes == [*common, ("stabilizer.controller", 4), ("locSrv.extQuatStdDev", 0.5)]


@pytest.mark.parametrize(
    ("parameters", "error", "text"),
    [
        ({"stabilizer.controler": 1}, UnknownNameError, "there is no parameter 'stabilizer.controler'; do you mean"),
        ({"controller": 1}, UnknownNameError, "there is no parameter 'controller'"),
        ({"stabilizer.controller": 256}, RangeError, "is 256, allowed: a whole number in [0, 255]"),
        ({"stabilizer.controller": 1.5}, RangeError, "is 1.5, allowed: a whole number"),
        ({"stabilizer.controller": "pid"}, RangeError, "is 'pid', allowed: a whole number"),
        ({"locSrv.extQuatStdDev": float("nan")}, RangeError, "is nan, allowed: a finite number"),
        ({"deck.bcLighthouse4": 1}, RangeError, "parameter 'deck.bcLighthouse4' can only be read"),
    ],
)
def test_parameters_that_are_none(fly, air, parameters, error, text):
    with pytest.raises(error) as caught:
        fly(RadioHandler, parameters=parameters)
    assert str(caught.value).startswith("agent_0 (fake://0): ")
    assert text in str(caught.value)
    assert air["fake://0"].link.is_closed


def test_parameters_in_between(fly, air):
    swarm = fly(RadioHandlerVel, 3)
    for drone in air.drones.values():
        drone.writes.clear()
    swarm.set_parameters({"stabilizer.controller": 2})
    swarm.set_parameters({"locSrv.extQuatStdDev": 0.25}, agents=[0, 2])
    swarm[1].set_parameter("stabilizer.estimator", True)
    assert [drone.writes for drone in air.drones.values()] == [
        [("stabilizer.controller", 2), ("locSrv.extQuatStdDev", 0.25)],
        [("stabilizer.controller", 2), ("stabilizer.estimator", 1)],
        [("stabilizer.controller", 2), ("locSrv.extQuatStdDev", 0.25)],
    ]
    assert swarm[0].get_parameter("stabilizer.controller") == 2
    assert swarm[0].get_parameter("locSrv.extQuatStdDev") == 0.25
    with pytest.raises(UnknownNameError, match="there is no parameter 'a.b'"):
        swarm[0].get_parameter("a.b")


def test_a_drone_that_does_not_confirm(fly, air):
    swarm = fly(RadioHandlerVel, confirm_timeout_s=0.05)
    air["fake://0"].mute_ports = {2}
    with pytest.raises(RadioError, match="parameter 'stabilizer.controller' was not confirmed within 0.05 s"):
        swarm[0].set_parameter("stabilizer.controller", 2)
