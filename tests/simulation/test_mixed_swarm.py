"""Worlds whose drones have different providers: built-in ones, and libraries that were loaded at run time."""

import platform
import threading

import mujoco
import numpy as np
import pytest
from toy_library import load_toy

from crazychoir_fw.common.errors import RangeError, StateError, UnknownNameError
from crazychoir_fw.simulation import DroneConfig, Episodes, FlightRecorder, World
from crazychoir_fw.simulation.swarm_views import swarm_parts, swarm_views

LONG = "TOY_PADDING=20000"


@pytest.fixture(autouse=True)
def toys():
    """The libraries that drones of this file ask for."""
    load_toy(name="toy")
    load_toy(LONG, name="long-toy")


def make_mixed_world(providers, **options):
    drones = [DroneConfig(f"cf{i + 1}", (0.5 * i, 0.0), provider=word) for i, word in enumerate(providers)]
    return World(drones, seed=5, **options)


def take_off(world, seconds):
    world.wait_until_ready()
    for drone in world.drones:
        drone.high_level_commander.takeoff(0.5, 1.0)
    world.run(seconds)


MIXED = ["builtin", "toy", "builtin", "long-toy", "toy", "toy", "long-toy", "builtin", "toy"]


def test_a_library_flies_as_what_it_is_made_of():
    """The toy wraps the built-in algorithms, so that its drone does the same to the last bit."""
    alone, other = make_mixed_world(["builtin", "builtin"]), make_mixed_world(["toy", "long-toy"])
    for world in (alone, other):
        take_off(world, 1.0)
    np.testing.assert_array_equal(alone.data.qpos, other.data.qpos)
    assert other["cf1"].log["toy.calls"] == other["cf2"].log["toy.calls"] > 1000
    assert other["cf1"].log["toy.battery"] == pytest.approx(412, abs=10)  # looked up in the drone's log
    assert other["cf1"].console.startswith("TOY: hello\nCONTROLLER: Using PID (1) controller\n")


def test_a_mixed_swarm_flies_the_same_with_any_number_of_threads():
    flights = []
    for threads in (1, 2, 3):
        world = make_mixed_world(MIXED, threads=threads)
        world["cf2"].param["toy.gain"] = 0.97
        take_off(world, 0.5)
        flights.append(world.snapshot())
        assert all(drone.failure is None for drone in world.drones)
    for flight in flights[1:]:
        np.testing.assert_array_equal(flight, flights[0])


def test_two_worlds_fly_in_two_threads():
    def fly(results, slot):
        world = make_mixed_world(["toy", "builtin", "toy"])
        world["cf1"].param["toy.gain"] = 0.9 + 0.05 * slot
        take_off(world, 0.5)
        results[slot] = world.snapshot()

    alone, together = [None, None], [None, None]
    for slot in (0, 1):
        fly(alone, slot)
    workers = [threading.Thread(target=fly, args=(together, slot)) for slot in (0, 1)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    for slot in (0, 1):
        np.testing.assert_array_equal(alone[slot], together[slot])
    assert not np.array_equal(alone[0], alone[1])


def test_begin_and_end_surround_every_tick():
    world = make_mixed_world(["toy"])
    world.run(0.25)
    assert world["cf1"].log["toy.ticks"] == world["cf1"].log["toy.ended"] == 250


# ---- boots, snapshots ----


def test_snapshots_and_reset_carry_what_a_library_remembers():
    world = make_mixed_world(MIXED)
    start = world.snapshot()
    take_off(world, 0.2)
    middle = world.snapshot()
    world.run(0.3)
    end = world.snapshot()
    world.restore(middle)
    world.run(0.3)
    np.testing.assert_array_equal(world.snapshot(), end)
    world.reset()
    np.testing.assert_array_equal(world.snapshot(), start)


def test_the_snapshot_of_one_drone_may_be_given_to_it_again():
    world = make_mixed_world(["long-toy", "builtin"])
    drone = world["cf1"]
    drone.param["toy.gain"] = 0.75
    kept = drone.snapshot()
    drone.param["toy.gain"] = 0.5
    drone.restore(kept)
    assert drone.param["toy.gain"] == 0.75
    assert drone.memory.nbytes > world["cf2"].memory.nbytes


def test_a_reboot_begins_anew():
    world = make_mixed_world(["toy"])
    drone = world["cf1"]
    drone.param["toy.gain"] = 0.5
    world.run(1.8)
    drone.reboot()
    assert (drone.param["toy.gain"], drone.log["toy.calls"], drone.log["toy.ticks"]) == (1.0, 0, 0)
    world.run(1.8)
    assert drone.log["toy.calls"] > 200


def test_a_drone_keeps_its_library_until_another_world_asks():
    load_toy(name="renewed")
    world = make_mixed_world(["renewed"])
    old = world["cf1"].provider_number
    new = load_toy("TOY_GAIN=0.5f", name="renewed")
    world.reset()
    assert world["cf1"].param["toy.gain"] == 1.0
    other = make_mixed_world(["renewed"])
    assert other["cf1"].param["toy.gain"] == 0.5
    assert (world["cf1"].provider_number, other["cf1"].provider_number) == (old, new)


def test_a_model_does_not_outlive_a_library_of_another_size():
    load_toy(name="grown")
    world = make_mixed_world(["grown"])
    load_toy(LONG, name="grown")
    with pytest.raises(mujoco.FatalError, match="cf1: provider 'grown' was built again.*compile the model again"):
        mujoco.MjData(world.model)


def test_a_provider_that_cannot_boot_is_told(monkeypatch):
    monkeypatch.setenv("TOY_FAILS_AT_BOOT", "1")
    with pytest.raises(RangeError, match="crazyflie cf1: provider 'toy' cannot boot: no parts left"):
        make_mixed_world(["toy"])


def test_a_provider_that_fails_at_a_later_boot_stops_its_drone(monkeypatch):
    world = make_mixed_world(["toy", "builtin"])
    take_off(world, 0.5)
    monkeypatch.setenv("TOY_FAILS_AT_BOOT", "1")
    world["cf1"].reboot()
    world.run(0.1)
    assert world["cf1"].failure == "cf1: the onboard software failed: no parts left (at 0.000 s)"
    assert world["cf1"].is_locked
    assert world["cf2"].failure is None
    monkeypatch.delenv("TOY_FAILS_AT_BOOT")
    world["cf1"].reboot()
    assert world["cf1"].failure is None


# ---- failures ----

MISHAPS = {
    1: "assertion failed: thrust >= 0 (my_controller.c:12)",
    2: "crashed in controllerOutOfTree",  # reads address 0
    3: "crashed in controllerOutOfTree",  # divides by zero
    4: "crashed in controllerOutOfTree",  # runs out of stack
}


@pytest.mark.parametrize(("mishap", "threads"), [(1, 1), (2, 1), (3, 1), (4, 1), (2, 2), (4, 2)])
def test_a_drone_whose_software_fails_stops_and_the_others_fly_on(mishap, threads):
    if mishap == 3 and platform.machine() != "x86_64":
        pytest.skip("this processor divides by zero without complaint")
    world = make_mixed_world(["builtin", "toy", "toy", "builtin"] * 2, threads=threads)
    take_off(world, 1.5)
    failing = world["cf2"]
    failing.param["toy.mishap"] = mishap
    failed_at = world.time + 0.001
    world.run(1.0)
    assert failing.failure == f"cf2: the onboard software failed: {MISHAPS[mishap]} (at {failed_at:.3f} s)"
    assert failing.console.endswith(f"SYS: Stopped, the onboard software failed\nSYS: {MISHAPS[mishap]}\n")
    assert list(failing.struct.onboard.motors.list) == [0, 0, 0, 0]
    assert failing.is_locked
    assert failing.log["toy.ticks"] * 1e-3 < failed_at + 0.01  # the core does not call it any more
    for drone in world.drones:
        if drone is not failing:
            assert drone.failure is None
            assert drone.true_position[2] == pytest.approx(0.5, abs=0.1)
    with pytest.raises(StateError):
        failing.high_level_commander.takeoff(0.5, 1.0)
    failing.reboot()
    assert failing.failure is None


def test_output_that_is_no_number_is_an_ordinary_fault():
    world = make_mixed_world(["toy"])
    take_off(world, 0.5)
    world["cf1"].param["toy.mishap"] = 5
    world.run(0.01)
    assert "the controller's output is not a number" in world["cf1"].failure


# ---- parameters and log variables ----


def test_a_library_hears_of_parameters_and_computes_logs_when_asked():
    world = make_mixed_world(["toy", "builtin"])
    drone = world["cf1"]
    drone.param["toy.gain"] = 0.9
    drone.param.set_value("toy.gain", "0.8")
    drone.param["kalman.resetEstimation"] = 1
    assert drone.log["toy.written"] == 2
    world.run(1.8)
    assert drone.log["toy.refreshed"] == 2 * drone.log["toy.calls"] > 0
    with pytest.raises(UnknownNameError, match="no parameter named 'toy.gain'"):
        world["cf2"].param["toy.gain"] = 1.0


def test_parameters_of_the_configuration_may_be_those_of_a_library():
    world = World([DroneConfig("a", provider="toy", parameters={"toy.gain": 0.25})])
    assert world["a"].param["toy.gain"] == 0.25
    assert world["a"].log["toy.written"] == 1


# ---- out of tree ----


def test_users_own_controller_flies_and_reads_back_as_number_6():
    world = World([DroneConfig("a", provider="toy", controller="out_of_tree")])
    take_off(world, 1.5)
    drone = world["a"]
    assert drone.param["stabilizer.controller"] == 6
    assert "CONTROLLER: Using OutOfTree (6) controller\n" in drone.console
    assert drone.true_position[2] == pytest.approx(0.5, abs=0.1)
    drone.param["stabilizer.controller"] = 1
    world.run(0.01)
    assert drone.param["stabilizer.controller"] == 1
    drone.param["stabilizer.controller"] = 6
    world.run(0.01)
    assert drone.param["stabilizer.controller"] == 6


def test_users_own_estimator_gets_the_queue_every_millisecond():
    world = World([DroneConfig("a", (0.25, 0.0), provider="toy", estimator="out_of_tree")])
    world.run(2.0)
    drone = world["a"]
    assert drone.param["stabilizer.estimator"] == 3
    assert drone.log["toy.measurements"] > 2 * 400  # gyroscope and accelerometer
    assert drone.estimated_position == pytest.approx([0.25, 0.0, drone.true_position[2]], abs=0.02)
    drone.param["stabilizer.estimator"] = 2
    world.run(0.01)
    drone.param["stabilizer.estimator"] = 3
    world.run(0.01)
    assert (drone.param["stabilizer.estimator"], drone.log["toy.measurements"] < 50) == (3, True)


@pytest.mark.parametrize("kind", ["controller", "estimator"])
def test_a_provider_without_refuses(kind):
    sentence = rf"cf1: {kind} is 'out_of_tree', but provider 'builtin' has none of that name, allowed: auto \| \w+"
    with pytest.raises(RangeError, match=sentence):
        World([DroneConfig("cf1", **{kind: "out_of_tree"})])
    world = World([DroneConfig("cf1")])
    world.wait_until_ready()
    name = f"stabilizer.{kind}"
    before = world["cf1"].param[name]
    world["cf1"].param[name] = {"controller": 6, "estimator": 3}[kind]
    world.run(0.01)
    assert world["cf1"].param[name] == before


# ---- which provider ----


def test_a_model_of_ones_own_names_a_provider():
    text = """
<mujoco><extension><plugin plugin="crazychoir.crazyflie"><instance name="a">
<config key="provider" value="PROVIDER"/></instance></plugin></extension>
<worldbody><body name="cf1"><freejoint/><geom size="0.05"/><plugin instance="a"/></body></worldbody></mujoco>"""
    assert mujoco.MjModel.from_xml_string(text.replace("PROVIDER", "toy")).nplugin == 1
    load_toy(name="brushless-toy", platform="cf21bl")
    with pytest.raises(ValueError, match=r"crazyflie cf1: provider is 'brushless-toy', allowed: builtin \| "):
        mujoco.MjModel.from_xml_string(text.replace("PROVIDER", "brushless-toy"))


def test_an_unknown_word_says_which_there_are():
    with pytest.raises(UnknownNameError, match="'bitkraze'.*builtin.*toy"):
        make_mixed_world(["bitkraze"])


# ---- recording ----


def test_a_mixed_swarm_falls_into_parts_at_equal_distances():
    world = make_mixed_world(MIXED)
    parts = swarm_parts(world)
    assert sorted(number for part in parts for number in part.numbers) == list(range(len(MIXED)))
    world.run(1.8)
    for part in parts:
        part.refresh()
        for column, number in enumerate(part.numbers):
            log = world.drones[number].log
            assert set(part.views) == set(log)
            for name in ("stateEstimate.z", "pm.vbat", "supervisor.info", *(n for n in log if n.startswith("toy."))):
                assert part.views[name][column] == log[name]
    with pytest.raises(RangeError, match="different providers"):
        swarm_views(world)
    assert len(swarm_parts(make_mixed_world(["toy"] * 5))) == 1


def test_the_log_of_a_mixed_swarm_has_gaps_where_a_drone_lacks_a_signal():
    world = make_mixed_world(MIXED)
    recorder = FlightRecorder(world)
    recorder.run(1.8)
    log = recorder.finish()
    has_toy = np.array([word != "builtin" for word in MIXED])
    calls = log.signals["toy.calls"]
    assert calls.shape == (180, len(MIXED))
    assert calls.dtype == np.float64  # 32 bits and NaN
    assert log.signals["toy.battery"].dtype == np.float32  # 16 bits
    assert np.isnan(calls[:, ~has_toy]).all()
    assert [calls[-1, i] for i in np.flatnonzero(has_toy)] == [
        world.drones[i].log["toy.calls"] for i in np.flatnonzero(has_toy)
    ]
    np.testing.assert_array_equal(log.signals["toy.refreshed"][:, has_toy], 2 * calls[:, has_toy])
    # what all have is as it was
    assert log.signals["supervisor.info"].dtype == np.uint16
    assert log.signals["stateEstimate.z"][-1] == pytest.approx([d.log["stateEstimate.z"] for d in world.drones])
    assert [provider["provider"] for provider in log.metadata["providers"]] == ["builtin", "toy", "long-toy"]
    assert log.metadata["drones"]["cf4"] == {"provider": "long-toy", "platform": "cf2"}


def test_forks_and_episodes_carry_what_a_library_remembers():
    """In threads that Python and MuJoCo started, each with a copy of the library of its own."""
    pytest.importorskip("mujoco.batch", reason="this MuJoCo has no batches")
    world = make_mixed_world(["toy", "builtin", "long-toy"])
    take_off(world, 0.3)
    episodes = Episodes(world, 4, 2)
    forks = world.fork(2)
    threads = [threading.Thread(target=fork.run, args=(0.3,)) for fork in forks]
    for thread in threads:
        thread.start()
    episodes.run(0.3)
    for thread in threads:
        thread.join()
    world.run(0.3)
    end = world.snapshot().tobytes()
    assert [fork.snapshot().tobytes() for fork in forks] == [end] * 2
    assert [episodes.snapshot(i).tobytes() for i in range(4)] == [end] * 4
