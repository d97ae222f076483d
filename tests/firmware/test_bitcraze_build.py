"""A whole checkout, the miniature one: from its folder to drones that fly it."""

import json
import shutil

import pytest
from miniature import RELEASES, SETUP_PY, lay_out
from typer.testing import CliRunner

from crazychoir_fw.cli import app
from crazychoir_fw.common.errors import CheckoutError, CompileError, LinkError, UnknownNameError
from crazychoir_fw.firmware import providers
from crazychoir_fw.firmware.build import build_provider
from crazychoir_fw.firmware.checkout import open_checkout
from crazychoir_fw.firmware.recipe import bitcraze_recipe
from crazychoir_fw.onboard import core
from crazychoir_fw.simulation import DroneConfig, World


def climb(world):
    world.wait_until_ready()
    for drone in world.drones:
        drone.high_level_commander.takeoff(absolute_height_m=0.5, duration_s=1.5)
    world.run(2.5)
    return [drone.log["stateEstimate.z"] for drone in world.drones]


def test_identity(bitcraze_library, miniature):
    identity = bitcraze_library.identity
    assert bitcraze_library.name == identity["provider"] == "bitcraze"
    assert identity["version"] == "2026.08"
    assert identity["checkout"] == str(miniature)
    assert {"plan_go_to_linear", "setpoint_jerk"} <= set(identity["features"])
    assert "src/modules/src/kalman_core/mm_pose.c" in identity["extra_sources"]
    assert identity["configuration"]["CONFIG_PLATFORM_CF2"] == "1"
    assert identity["notes"] == []
    assert "-O3 -O1 " in identity["flags"]  # the checkout chooses
    json.dumps(identity)


def test_it_flies_beside_the_builtin_provider(bitcraze_library, miniature, monkeypatch):
    # where the word has been said before, it means the checkout and not what is loaded
    monkeypatch.setenv("CRAZYFLIE_FIRMWARE", str(miniature))
    number = core.load_library(bitcraze_library)
    assert core.provider_identity(number)["version"] == "2026.08"
    drones = [DroneConfig("a", (0.0, 0.0), provider="bitcraze"), DroneConfig("b", (0.5, 0.0))]
    assert climb(World(drones, seed=1)) == pytest.approx([0.5, 0.5], abs=0.05)


@pytest.mark.parametrize("setup_py", SETUP_PY)
def test_forms_of_setup_py_say_the_same(tmp_path, setup_py, miniature):
    root = lay_out(tmp_path / "checkout", setup_py=setup_py)
    recipe = bitcraze_recipe(open_checkout(root), "cf2")
    expected = bitcraze_recipe(open_checkout(miniature), "cf2")
    assert recipe.notes == ()
    assert {path.relative_to(root) for path in recipe.sources} == {p.relative_to(miniature) for p in expected.sources}
    assert recipe.flags == expected.flags
    assert recipe.generated == expected.generated


@pytest.mark.parametrize("release", RELEASES)
def test_every_release_is_understood(tmp_path, release):
    root = lay_out(tmp_path / "checkout", release=release)
    platform = "cf21bl" if release >= "2025.02" else "cf2"
    assert bitcraze_recipe(open_checkout(root), platform).notes == ()


@pytest.mark.parametrize("platform", ["cf2", "cf21bl", "bolt"])
def test_every_platform_has_a_configuration(miniature, platform):
    settings = bitcraze_recipe(open_checkout(miniature), platform).settings
    assert settings[f"CONFIG_PLATFORM_{platform.upper()}"] == "1"


def test_without_cmsis_the_builtin_provider_keeps_flying(tmp_path, monkeypatch):
    root = lay_out(tmp_path / "checkout", cmsis=False)
    monkeypatch.setenv("CRAZYFLIE_FIRMWARE", str(root))
    monkeypatch.setattr(core, "find_provider", lambda word, platform: None)
    with pytest.raises(CheckoutError, match="submodule update --init vendor/CMSIS`$"):
        providers.load("bitcraze", "cf2")
    assert providers.load("builtin", "cf2") == 0
    assert climb(World([DroneConfig("a", (0.0, 0.0))], seed=1)) == pytest.approx([0.5], abs=0.05)


def test_nothing_is_written_into_the_checkout(tmp_path, lasting_cache, photograph):
    root = lay_out(tmp_path / "checkout", git=True)
    shutil.rmtree(root / "src" / "modules" / "src" / "kalman_core")
    broken = root / "src" / "modules" / "src" / "planner.c"
    broken.write_text("#error stop here\n")
    # one source is enough, and one that fails is the worst that can happen
    setup = root / "bindings" / "setup.py"
    setup.write_text('Extension("_cffirmware", sources=["src/modules/src/planner.c", "src/utils/src/num.c"])')
    for path in [root, *root.rglob("*")]:
        path.chmod(path.stat().st_mode & ~0o222)
    before = photograph(root)
    with pytest.raises(CompileError, match=r"planner\.c:1:2: error: #error stop here"):
        build_provider(root)
    open_checkout(root).version()
    assert photograph(root) == before


def test_the_word_bitcraze_means_the_checkout_of_the_environment(bitcraze_library, miniature, monkeypatch):
    monkeypatch.setenv("CRAZYFLIE_FIRMWARE", str(miniature))
    monkeypatch.setattr(core, "find_provider", lambda word, platform: None)
    number = providers.load("bitcraze", "cf2")
    assert number > 0
    assert core.provider_identity(number)["content"] == bitcraze_library.identity["content"]
    assert providers.load("bitcraze", "cf2") == number


def test_a_library_that_was_loaded_by_hand_comes_first(bitcraze_library, monkeypatch):
    number = core.load_library(bitcraze_library)
    monkeypatch.setenv("CRAZYFLIE_FIRMWARE", "/nowhere")
    assert providers.load("bitcraze", "cf2") == number


def test_an_unknown_word_is_answered_with_the_nearest(lasting_cache):
    with pytest.raises(UnknownNameError, match=r"no provider named 'bitcrase' .*did you mean 'bitcraze'\?"):
        providers.load("bitcrase", "cf2")


APP = """
#include "controller_pid.h"
#include "param.h"
static float bias = 0.0f;
void controllerOutOfTreeInit(void) { controllerPidInit(); }
bool controllerOutOfTreeTest(void) { return true; }
void controllerOutOfTree(control_t *control, const setpoint_t *setpoint, const sensorData_t *sensors,
                         const state_t *state, const stabilizerStep_t step) {
  controllerPid(control, setpoint, sensors, state, step);
  control->thrust += bias;
}
PARAM_GROUP_START(mine)
PARAM_ADD(PARAM_FLOAT, bias, &bias)
PARAM_GROUP_STOP(mine)
"""


def test_an_app_over_the_builtin_provider(tmp_path, lasting_cache):
    path = tmp_path / "my law.c"
    path.write_text(APP)
    library = build_provider(None, apps=[path])
    assert (library.name, library.platform) == ("builtin+my_law", "cf2")
    core.load_library(library)
    world = World([DroneConfig("a", (0.0, 0.0), provider=library.name)], seed=1)
    world["a"].param["stabilizer.controller"] = 6
    assert climb(world) == pytest.approx([0.5], abs=0.05)
    assert world["a"].param["mine.bias"] == 0.0

    path.write_text(APP.replace("+= bias", "+= undeclared"))
    with pytest.raises(CompileError, match=rf"{path}:10:22: error: .*undeclared"):
        build_provider(None, apps=[path])
    path.write_text(
        APP.replace("bias;\n}", "logWhatever();\n}").replace("static", "float logWhatever(void);\nstatic", 1)
    )
    with pytest.raises(LinkError, match=f"^undefined symbol logWhatever, needed by {path}$"):
        build_provider(None, apps=[path])


def test_commands(bitcraze_library, miniature, monkeypatch):
    def run(*words):
        return CliRunner().invoke(app, ["firmware", *map(str, words)])

    built = run("build", "--path", miniature, "--verbose")
    assert built.exit_code == 0, built.stderr
    assert "bitcraze 2026.08 cf2" in built.stdout
    assert "CONFIG_PLATFORM_CF2 = 1" in built.stdout
    facts = json.loads(run("show", "--path", miniature, "--json").stdout)
    assert facts["version"] == "2026.08"
    assert str(bitcraze_library.path) in [one["path"] for one in facts["libraries"]]
    shown = run("show", "--path", miniature).stdout
    assert shown.count("bitcraze 2026.08 cf2 ") == 1, "the latest one of each platform"
    # in one piece, to be copied
    assert str(bitcraze_library.path) in shown

    monkeypatch.setenv("CRAZYFLIE_FIRMWARE", str(miniature))
    told = CliRunner().invoke(app, ["info", "--json"]).stdout
    assert bitcraze_library.identity in json.loads(told)["firmware_libraries"]
    told = CliRunner().invoke(app, ["info"]).stdout
    assert "bitcraze 2026.08 cf2" in told
    assert "kalman_predict_params" in told
    assert "-ffp-contract=off" in told

    def fail(*_, **__):
        raise CompileError("1 file does not compile:\na.c:1:1: error: [x]")

    monkeypatch.setattr("crazychoir_fw.firmware.build.build_provider", fail)
    failed = run("build", "--path", miniature)
    assert failed.exit_code == 1
    assert failed.stderr == "1 file does not compile:\na.c:1:1: error: [x]\n"
