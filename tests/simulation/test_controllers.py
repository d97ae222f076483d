"""Which controller flies: words before boot, numbers of the firmware at run time.

docs/reference/control-geometric.md#3.4.
"""

import numpy as np
import pytest

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.onboard.core import choices
from crazychoir_fw.onboard.installation import info
from crazychoir_fw.simulation import DroneConfig, World

NUMBERS = {"pid": 1, "mellinger": 2, "indi": 3, "brescianini": 4, "lee": 5}
NAMES = {1: "PID", 2: "Mellinger", 3: "INDI", 4: "Brescianini", 5: "Lee"}


def hovering(controller=None):
    world = World([DroneConfig("cf1", controller=controller)], seed=1)
    world.wait_until_ready()
    world.drones[0].high_level_commander.takeoff(1.0, 2.0)
    world.run(5.0)
    return world, world.drones[0]


def test_words_are_those_of_the_info():
    assert choices("controller") == info()["controllers"] == [*NUMBERS, "out_of_tree"]


@pytest.mark.parametrize(("word", "number"), NUMBERS.items())
def test_word_boots_its_controller(word, number):
    world = World([DroneConfig("cf1", controller=word)])
    assert world.drones[0].param["stabilizer.controller"] == number
    world.wait_until_ready()
    assert world.drones[0].param["stabilizer.controller"] == number


@pytest.mark.parametrize(("number", "name"), NAMES.items())
def test_provider_names_its_controllers_as_the_firmware_does(number, name):
    assert ffi.string(lib.cf_provider(0).controller_name(number)).decode() == name


@pytest.mark.parametrize("number", [0, 6, 99, -1])
def test_provider_has_no_name_for_other_numbers(number):
    assert lib.cf_provider(0).controller_name(number) == ffi.NULL


def test_unknown_word_is_refused_with_the_words_there_are():
    with pytest.raises(RangeError, match=r"controller is 'lqr', allowed: auto \| pid \| mellinger \| indi"):
        World([DroneConfig("cf1", controller="lqr")])


@pytest.mark.parametrize("start", ["pid", "indi"])
@pytest.mark.parametrize("number", NUMBERS.values())
def test_a_number_selects_in_flight_and_the_drone_flies_on(start, number):
    world, drone = hovering(start)
    drone.param["stabilizer.controller"] = number
    world.run(0.001)
    assert drone.param["stabilizer.controller"] == number
    deviations = []
    for _ in range(60):
        world.run(0.1)
        deviations.append(np.linalg.norm(drone.true_position - [0, 0, 1]))
    assert max(deviations) < 0.15
    assert deviations[-1] < 0.05
    assert drone.is_flying
    assert drone.failure is None


@pytest.mark.parametrize(("number", "name"), list(NAMES.items())[1:])
def test_console_names_the_controller_that_took_over(number, name):
    world = World([DroneConfig("cf1")])
    world.wait_until_ready()
    world.drones[0].param["stabilizer.controller"] = number
    world.run(0.001)
    assert world.drones[0].console.splitlines()[-1] == f"CONTROLLER: Using {name} ({number}) controller"


@pytest.mark.parametrize("number", [99, 255])
@pytest.mark.parametrize("start", ["pid", "indi", "brescianini"])
def test_unknown_number_reads_back_as_the_active_one(start, number):
    world, drone = hovering(start)
    drone.param["stabilizer.controller"] = number
    world.run(0.001)
    assert drone.param["stabilizer.controller"] == NUMBERS[start]
    world.run(2.0)
    assert np.linalg.norm(drone.true_position - [0, 0, 1]) < 0.06
    assert drone.is_flying


@pytest.mark.parametrize("start", ["pid", "indi", "brescianini"])
def test_automatic_choice_is_the_pid(start):
    world, drone = hovering(start)
    drone.param["stabilizer.controller"] = 0
    world.run(0.001)
    assert drone.param["stabilizer.controller"] == 1
    world.run(4.0)
    assert np.linalg.norm(drone.true_position - [0, 0, 1]) < 0.05
    assert drone.log["controller.actuatorThrust"] == drone.log["stabilizer.thrust"]


def test_changing_hands_again_and_again_keeps_flying():
    world, drone = hovering()
    for number in (3, 4, 1, 4, 3, 1) * 3:
        drone.param["stabilizer.controller"] = number
        world.run(0.7)
        assert np.linalg.norm(drone.true_position - [0, 0, 1]) < 0.15
    assert drone.is_flying


def test_a_controller_takes_over_as_selected_at_boot():
    """What was selected on the floor, before the motors ran, flies as if it had booted."""
    ends = []
    for word, number in (("brescianini", 4), ("pid", 4)):
        world = World([DroneConfig("cf1", controller=word)], seed=1)
        drone = world.drones[0]
        drone.param["stabilizer.controller"] = number
        world.wait_until_ready()
        drone.high_level_commander.takeoff(1.0, 2.0)
        world.run(3.0)
        ends.append(drone.true_position)
    assert np.array_equal(ends[0], ends[1])


def test_logs_of_the_controllers_show_the_one_that_flies():
    world, drone = hovering("indi")
    assert drone.log["ctrlINDI.cmd_thrust"] == drone.log["stabilizer.thrust"]
    assert drone.log["posCtrlIndi.T_incremented"] == drone.log["ctrlINDI.cmd_thrust"]
    assert drone.log["posCtrlIndi.posRef_z"] == pytest.approx(-1.0, abs=1e-5)
    drone.param["ctrlINDI.thrust_threshold"] = 400
    drone.param["posCtrlIndi.K_xi_x"] = 1.5
    drone.param["ctrlAtt.tau_xy"] = 0.4
    world.run(1.0)
    assert drone.is_flying
