"""A user's own C: built, carried by drones with a state of their own, switched, crashed, built again."""

from pathlib import Path

import numpy as np
import pytest

from crazychoir_fw.common.errors import BuildError, CompileError, LinkError, RangeError, UnknownNameError
from crazychoir_fw.firmware.apps import app_files, build_app
from crazychoir_fw.firmware.library import BUILD_LOG
from crazychoir_fw.simulation import DroneConfig, FlightRecorder, World

APPS = Path(__file__).parent / "apps"
COUNTING, FOLLOWING, CRASHING = APPS / "counting.c", APPS / "following.c", APPS / "crashing.c"

HOOKS = """
#include "controller.h"
void controllerOutOfTreeInit(void) {}
bool controllerOutOfTreeTest(void) { return true; }
void controllerOutOfTree(control_t *control, const setpoint_t *setpoint, const sensorData_t *sensors,
                         const state_t *state, const stabilizerStep_t stabilizerStep) {
  (void)setpoint, (void)sensors, (void)state, (void)stabilizerStep;
  control->thrust = thrust();
}
"""


def write(path, text):
    path.write_text(text)
    return path


def airborne(*configs, **settings):
    """Return a world whose drones are on their way up to 0.5 m."""
    world = World(configs, seed=1, visuals=False, **settings)
    world.wait_until_ready()
    for drone in world.drones:
        drone.high_level_commander.takeoff(absolute_height_m=0.5, duration_s=1.5)
    world.run(1.5)
    return world


# -- building ------------------------------------------------------------------------------------------------------


def test_app_says_what_it_brings():
    app = build_app(COUNTING)
    assert app.library.name == "builtin+counting"
    assert app.hooks == ("controller",)
    assert app.groups == {"count"}
    assert app.warnings == ""
    # four words of 4 bytes, a pointer, and one word within a function
    assert app.state_bytes == 28
    assert build_app(FOLLOWING).hooks == ("estimator",)


def test_app_of_two_files_finds_headers_beside_them(tmp_path):
    write(tmp_path / "gain.h", "float thrust(void);\n")
    helper = write(tmp_path / "gain.c", '#include "gain.h"\nfloat thrust(void) { return 7.0f; }\n')
    main = write(tmp_path / "main.c", '#include "gain.h"\n' + HOOKS)
    app = build_app([main, helper])
    assert app.library.name == "builtin+main+gain"
    assert app.hooks == ("controller",)


def test_warnings_of_the_compiler_are_kept(tmp_path):
    path = write(tmp_path / "sloppy.c", "static int unused;\nstatic float thrust(void) { return 1.0f; }\n" + HOOKS)
    assert f"{path}:1:12: warning: " in build_app(path).warnings


def test_missing_file_and_wrong_suffix_are_refused(tmp_path):
    with pytest.raises(BuildError, match=r"gone\.c does not exist"):
        app_files(tmp_path / "gone.c")
    with pytest.raises(BuildError, match=r"notes\.txt is no C source: the name of an app ends with \.c"):
        app_files([write(tmp_path / "notes.txt", "")])


def test_file_without_a_hook_is_told_which_functions_are_expected(tmp_path):
    path = write(tmp_path / "idle.c", "void appMain(void);\nvoid appMain(void) {}\n")
    with pytest.raises(BuildError, match=r"^idle\.c has nothing .*controllerOutOfTreeInit.*estimatorOutOfTree "):
        build_app(path)


def test_half_a_hook_is_told_what_is_missing(tmp_path):
    text = HOOKS.replace("bool controllerOutOfTreeTest(void) { return true; }", "")
    path = write(tmp_path / "half.c", "static float thrust(void) { return 1.0f; }\n" + text)
    with pytest.raises(BuildError, match="half.c defines controllerOutOfTreeInit, but not controllerOutOfTreeTest"):
        build_app(path)


def test_compiler_errors_are_those_of_the_compiler(tmp_path):
    path = write(tmp_path / "broken.c", "\nint x = ;\n" + HOOKS)
    with pytest.raises(CompileError) as caught:
        build_app(path)
    lines = str(caught.value).splitlines()
    assert lines[0] == "1 file does not compile:"
    assert lines[1].startswith(f"{path}:2:9: error: ")
    assert lines[2].strip().endswith("int x = ;")


def test_undefined_symbol_names_who_needs_it(tmp_path):
    path = write(tmp_path / "lonely.c", "float thrust(void);\n" + HOOKS)
    with pytest.raises(LinkError, match=rf"undefined symbol thrust, needed by {path}"):
        build_app(path)


def test_an_edit_compiles_one_file(tmp_path):
    text = COUNTING.read_text()
    path = write(tmp_path / "edited.c", text)
    first = build_app(path)
    assert build_app(path).library.path == first.library.path
    write(path, text.replace("= 1.0f;", "= 2.0f;"))
    second = build_app(path)
    assert second.library.path != first.library.path
    log = (second.library.path.parent / BUILD_LOG).read_text()
    commands = log.partition("\ncommands:\n")[2].splitlines()
    compiled = [line.split()[-1] for line in commands if line.startswith("  ")]
    assert compiled == [str(path)]


# -- flying --------------------------------------------------------------------------------------------------------


def test_drone_is_flown_by_what_its_app_brings():
    world = airborne(DroneConfig("cf1", app=COUNTING), DroneConfig("cf2", (1.0, 0.0)))
    drone, stock = world.drones
    assert drone.config.provider == "builtin+counting"
    assert drone.config.controller == "out_of_tree"
    assert drone.param["stabilizer.controller"] == 6
    assert stock.param["stabilizer.controller"] == 1
    assert "count.scale" not in stock.param
    assert drone.true_position[2] > 0.3
    # the stock PID by another name: the same numbers
    assert drone.true_position[2] == pytest.approx(stock.true_position[2], abs=0.02)
    assert "COUNT: started 1 times" in drone.console


def test_parameters_and_logs_are_those_of_the_drone():
    world = airborne(DroneConfig("cf1", app=COUNTING, parameters={"count.scale": 0.5}))
    drone = world["cf1"]
    recorder = FlightRecorder(world)
    recorder.run(0.1)
    log = recorder.finish()
    assert drone.param["count.scale"] == 0.5
    np.testing.assert_array_equal(np.diff(log.signals["count.calls"][:, 0]), 10)
    drone.param["count.scale"] = 2.0
    world.step()
    assert drone.log["count.thrust"] == pytest.approx(2.0 * drone.log["stabilizer.thrust"])
    with pytest.raises(UnknownNameError, match=r"count\.scales.*did you mean count\.scale"):
        drone.param["count.scales"] = 1
    with pytest.raises(RangeError, match=r"count\.scale is 'fast', allowed: a finite number"):
        drone.param["count.scale"] = "fast"


def test_file_scope_state_is_that_of_each_drone():
    world = World([DroneConfig(f"cf{i}", (i, 0.0), app=COUNTING) for i in range(3)], seed=1, visuals=False)
    world.run(2.0)
    world["cf1"].reboot()
    world.run(2.0)
    first, second, third = (drone.log["count.calls"] for drone in world.drones)
    assert first == third == second + 2000
    assert [drone.param["count.inits"] for drone in world.drones] == [1, 1, 1]
    kept = world["cf2"].snapshot()
    world.run(0.1)
    world["cf2"].restore(kept)
    world.step()
    assert world["cf2"].log["count.calls"] == third + 1
    assert world["cf0"].log["count.calls"] == first + 101


def test_two_apps_fly_in_one_swarm(tmp_path):
    other = write(tmp_path / "other.c", COUNTING.read_text().replace("count)", "other)"))
    world = airborne(DroneConfig("cf1", app=COUNTING), DroneConfig("cf2", (1.0, 0.0), app=other))
    assert "count.calls" in world["cf1"].log and "other.calls" not in world["cf1"].log
    assert "other.calls" in world["cf2"].log and "count.calls" not in world["cf2"].log
    assert [drone.is_flying for drone in world.drones] == [True, True]
    recorder = FlightRecorder(world)
    recorder.run(0.02)
    assert {"count.calls", "other.calls"} <= set(recorder.finish().signals)


def test_two_apps_of_one_name_are_refused(tmp_path):
    other = write(tmp_path / "counting.c", COUNTING.read_text())
    with pytest.raises(RangeError, match=r"cf2: .*counting\.c have one name"):
        World([DroneConfig("cf1", app=COUNTING), DroneConfig("cf2", (1.0, 0.0), app=other)], visuals=False)


def test_one_app_flies_both_airframes():
    world = airborne(DroneConfig("cf1", app=COUNTING), DroneConfig("cf2", (1.0, 0.0), app=COUNTING, platform="cf21bl"))
    assert [drone.is_flying for drone in world.drones] == [True, True]


def test_what_an_app_does_not_bring_is_refused():
    with pytest.raises(RangeError, match=r"cf1: controller is 'out_of_tree', but following\.c has no controllerOutOf"):
        World([DroneConfig("cf1", app=FOLLOWING, controller="out_of_tree")], visuals=False)


def test_controller_is_switched_in_flight():
    world = airborne(DroneConfig("cf1", app=COUNTING))
    drone = world["cf1"]
    drone.param["stabilizer.controller"] = 1
    world.run(0.3)
    calls = drone.log["count.calls"]
    world.run(0.2)
    assert drone.param["stabilizer.controller"] == 1
    assert drone.log["count.calls"] == calls
    drone.param["stabilizer.controller"] = 6
    world.run(0.5)
    assert drone.param["stabilizer.controller"] == 6
    assert drone.log["count.calls"] > calls + 400
    assert drone.param["count.inits"] == 2
    assert drone.true_position[2] == pytest.approx(0.5, abs=0.1)


def test_named_controller_beats_that_of_the_app():
    world = World([DroneConfig("cf1", app=COUNTING, controller="mellinger")], visuals=False)
    world.run(1.5)
    assert world["cf1"].param["stabilizer.controller"] == 2
    assert world["cf1"].log["count.calls"] == 0


def test_crash_stops_its_own_drone_only():
    world = airborne(DroneConfig("bad", app=CRASHING), DroneConfig("good", (1.0, 0.0), app=CRASHING))
    bad, good = world.drones
    bad.param["crash.now"] = 1
    world.run(1.0)
    assert bad.failure.startswith("bad: ")
    assert "segmentation fault in controllerOutOfTree" in bad.failure
    assert bad.is_locked
    assert max(bad.log[f"motor.m{i}"] for i in range(1, 5)) == 0
    assert good.failure is None
    assert good.true_position[2] == pytest.approx(0.5, abs=0.1)
    assert bad.true_position[2] < 0.1


def test_estimator_of_an_app_flies():
    world = airborne(DroneConfig("cf1", app=FOLLOWING))
    drone = world["cf1"]
    assert drone.config.estimator == "out_of_tree" and drone.config.controller is None
    assert drone.param["stabilizer.estimator"] == 3
    drone.high_level_commander.go_to(0.3, 0.0, 0.5, yaw=0.0, duration_s=1.5)
    world.run(3.0)
    assert drone.log["follow.poses"] > 300
    np.testing.assert_allclose(drone.true_position, [0.3, 0.0, 0.5], atol=0.05)


@pytest.mark.parametrize("threads", [2, 3])
def test_any_number_of_threads_gives_the_same_bits(threads):
    def fly(count):
        configs = [DroneConfig(f"cf{i}", (i, 0.0), app=[COUNTING, FOLLOWING][i % 2]) for i in range(6)]
        world = airborne(*configs, threads=count)
        return world.snapshot()

    try:
        np.testing.assert_array_equal(fly(threads), fly(1))
    finally:
        World([DroneConfig("cf1")], threads=1, visuals=False)
