"""What clients look for beside flying: console, battery, self-tests, identity, callbacks of parameters."""

import numpy as np
import pytest
from worlds import make_world

from crazychoir_fw.common.errors import RangeError, StateError, UnknownNameError

# clients fail when one of these is missing (docs/reference/crtp-cflib.md#20)
PARAMETERS = [
    "system.selftestPassed",
    "firmware.revision0",
    "firmware.revision1",
    "firmware.modified",
    "cpu.flash",
    "cpu.id0",
    "cpu.id1",
    "cpu.id2",
    "imu_sensors.BMP3XX",
    "led.bitmask",
    "ring.effect",
    "ring.solidRed",
    "ring.solidGreen",
    "ring.solidBlue",
    "ring.headlightEnable",
    "ring.fadeColor",
    "ring.fadeTime",
    "sound.effect",
    "memTst.resetW",
    "activeMarker.front",
    "activeMarker.mode",
    "usd.canLog",
    "deck.bcActiveMarker",
    "health.startPropTest",
    "health.startBatTest",
    "pm.lowVoltage",
    "kalman.resetEstimation",
    "commander.enHighLevel",
    "stabilizer.controller",
    "stabilizer.estimator",
    "motorPowerSet.enable",
    "motorPowerSet.m1",
    "locSrv.extPosStdDev",
    "supervisor.infdmp",
]
LOGS = [
    "pm.vbat",
    "pm.vbatMV",
    "pm.state",
    "pm.batteryLevel",
    "radio.rssi",
    "radio.isConnected",
    "radio.numRxBc",
    "radio.numRxUc",
    "crtp.rxRate",
    "crtp.txRate",
    "memTst.errCntW",
    "usd.spiWrBps",
    "sys.canfly",
    "supervisor.info",
    "motor.m1",
    "stabilizer.thrust",
]


@pytest.fixture
def world():
    world = make_world(2)
    world.wait_until_ready()
    return world


def test_variables_that_clients_look_for_exist(world):
    drone = world.drones[0]
    assert [name for name in PARAMETERS if name not in drone.param] == []
    assert [name for name in LOGS if name not in drone.log] == []


@pytest.mark.parametrize("name", ["system.selftestPassed", "cpu.id0", "firmware.revision0", "ring.neffect"])
def test_identity_is_read_only(world, name):
    with pytest.raises(StateError, match=f"{name} is read-only"):
        world.drones[0].param[name] = 1


def test_drones_have_processors_of_their_own(world):
    assert world.drones[0].param["cpu.id2"] != world.drones[1].param["cpu.id2"]


def test_console_tells_what_happened(world):
    drone = world.drones[0]
    assert drone.console.startswith("CONTROLLER: Using PID (1) controller\n")
    drone.emergency_stop()
    world.run(0.2)
    assert drone.console.endswith("SUP: Locked, reboot required\n")
    drone.reboot()
    assert drone.console == "CONTROLLER: Using PID (1) controller\n"


def test_supervisor_prints_its_state_when_asked(world):
    drone = world.drones[0]
    drone.param["supervisor.infdmp"] = 1
    world.run(0.05)
    assert "SUP: state: Ready to fly\nSUP: [x] armed\nSUP: [ ] isFlying\n" in drone.console
    assert drone.param["supervisor.infdmp"] == 0


def test_a_stopped_drone_says_why_on_its_console(world):
    world.data.qvel[0] = np.nan
    world.step()
    assert "SYS: Stopped, the simulated motion is not finite\n" in world.drones[0].console


def test_health_tests_measure_the_simulated_drone(world):
    drone = world.drones[0]
    drone.param["health.startPropTest"] = 1
    world.run(4.1)
    assert drone.log["health.motorPass"] == 0b1111
    assert drone.log["health.motorTestCount"] == 1
    assert all(drone.log[f"health.motorVarXM{i}"] > 0 for i in range(1, 5))

    drone.param["health.startBatTest"] = 1
    world.run(1.1)
    assert 0.05 < drone.log["health.batterySag"] < 0.95
    assert drone.log["health.batteryPass"] == 1
    assert drone.param["health.startBatTest"] == 0


def test_battery_state_follows_the_voltage(world):
    drone = world.drones[0]
    assert (drone.log["pm.state"], drone.log["pm.batteryLevel"]) == (0, 90)
    assert drone.log["pm.vbatMV"] == pytest.approx(1000 * drone.log["pm.vbat"], abs=1)
    drone.param["pm.lowVoltage"] = 4.5
    world.run(5.2)
    assert drone.log["pm.state"] == 3


def test_requests_clear_themselves(world):
    drone = world.drones[0]
    requests = ["system.taskDump", "system.storageStats", "system.assertInfo", "memTst.resetW"]
    for name in requests:
        drone.param[name] = 1
    world.run(0.05)
    assert [drone.param[name] for name in requests] == [0, 0, 0, 0]


# ------------------------------------------------------------------------- callbacks of parameters


@pytest.fixture
def heard():
    return []


@pytest.fixture
def listen(heard):
    return lambda name, value: heard.append((name, value))


def test_callback_hears_writes(world, heard, listen):
    param = world.drones[0].param
    param.add_update_callback("pid_rate", "roll_kp", listen)
    param["pid_rate.roll_kp"] = 200
    param.set_value("pid_rate.roll_kp", "210.5")
    param["pid_rate.pitch_kp"] = 1
    world.drones[1].param["pid_rate.roll_kp"] = 1
    assert heard == [("pid_rate.roll_kp", "200.0"), ("pid_rate.roll_kp", "210.5")]


def test_callback_hears_what_the_drone_changes_itself(world, heard, listen):
    param = world.drones[0].param
    param.add_update_callback("supervisor", cb=listen)
    param["supervisor.infdmp"] = 1
    world.run(0.1)
    world.run(0.1)
    assert heard == [("supervisor.infdmp", "1"), ("supervisor.infdmp", "0")]


def test_callback_for_everything(world, heard, listen):
    param = world.drones[0].param
    param.add_update_callback(cb=listen)
    param["ring.effect"] = 7
    param["led.bitmask"] = 128
    assert heard == [("ring.effect", "7"), ("led.bitmask", "128")]


def test_removed_callback_is_silent(world, heard, listen):
    param = world.drones[0].param
    other = []
    param.add_update_callback("ring", "effect", listen)
    param.add_update_callback("ring", "effect", lambda name, value: other.append(value))
    param.remove_update_callback("ring", "effect", listen)
    param["ring.effect"] = 3
    assert (heard, other) == ([], ["3"])
    param.remove_update_callback("ring")
    param["ring.effect"] = 4
    world.run(0.05)
    assert (heard, other) == ([], ["3"])


def test_callback_may_write_and_remove_itself(world):
    param = world.drones[0].param

    def once(name, value):
        param.remove_update_callback("ring", "effect")
        param["ring.effect"] = 9

    param.add_update_callback("ring", "effect", once)
    param["ring.effect"] = 1
    world.run(0.05)
    assert param["ring.effect"] == 9


@pytest.mark.parametrize(("group", "name"), [("no_such", None), ("ring", "no_such"), ("no_such", "effect")])
def test_callback_for_an_unknown_name_is_refused(world, listen, group, name):
    with pytest.raises(UnknownNameError, match="no parameter named"):
        world.drones[0].param.add_update_callback(group, name, listen)


def test_callback_without_a_function_is_refused(world):
    with pytest.raises(RangeError, match="needs a function"):
        world.drones[0].param.add_update_callback("ring")
