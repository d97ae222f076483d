import numpy as np
import pytest
from worlds import make_world

from crazychoir_fw.common.errors import RangeError, StateError, UnknownNameError
from crazychoir_fw.recording.opengl import RenderingError, rendering_available
from crazychoir_fw.simulation import DroneConfig, World, set_threads


def test_drones_stand_on_the_floor_at_first():
    world = make_world(2)
    world.run(0.5)
    assert world.drones[0].true_position == pytest.approx([0.0, 0.0, 0.0145], abs=1e-3)
    assert world.drones[1].true_position == pytest.approx([0.5, 0.0, 0.0145], abs=1e-3)


def test_yaw_and_height_of_the_start_are_taken():
    world = World([DroneConfig("a", (1.0, 2.0, 0.5), yaw_deg=90.0)])
    assert world["a"].true_position == pytest.approx([1.0, 2.0, 0.5])
    assert world["a"].true_quat_wxyz == pytest.approx([np.sqrt(0.5), 0, 0, np.sqrt(0.5)])


def test_drone_at_an_odd_heading_knows_it():
    world = World([DroneConfig("a", (3.0, -2.0), yaw_deg=175.0)])
    world.wait_until_ready()
    assert world["a"].log["stateEstimate.yaw"] == pytest.approx(175.0, abs=1.0)
    assert world["a"].estimated_position == pytest.approx([3.0, -2.0, 0.0145], abs=0.01)


def test_brushed_drone_is_ready_by_itself_and_brushless_after_arming():
    world = World([DroneConfig("a", (0, 0)), DroneConfig("b", (1, 0), platform="cf21bl")])
    world.run(2.0)
    assert world["a"].can_fly
    assert not world["b"].can_fly
    assert world["b"].can_arm
    world["b"].arm()
    world.run(0.1)
    assert world["b"].can_fly


def test_mass_of_a_drone_may_be_chosen():
    world = World([DroneConfig("a", (0, 0), mass=0.035)])
    body = world.model.body("a")
    assert body.mass[0] == pytest.approx(0.035)
    assert body.inertia[0] == pytest.approx(16.571710e-6 * 0.035 / 0.029, rel=1e-4)


def test_drones_are_found_by_name():
    world = make_world(2)
    assert world["cf2"] is world.drones[1]
    with pytest.raises(UnknownNameError, match="cf9.*there are: cf1, cf2"):
        world["cf9"]


def config(**changes):
    return [DroneConfig(**{"id": "cf1", "position": (0.0, 0.0), **changes})]


@pytest.mark.parametrize(
    ("drones", "options", "sentence"),
    [
        ([], {}, "drones.*empty.*at least 1"),
        (config() + config(), {}, "'cf1' is used twice"),
        (config(mass=-0.03), {}, "cf1: mass is -0.03, allowed: 0.005 to 0.5 kg"),
        (config(mass=float("nan")), {}, "cf1: mass is nan, allowed: 0.005 to 0.5 kg"),
        (config(position=(0.0, float("nan"))), {}, "cf1: position is .*nan.*finite"),
        (config(position="ab"), {}, "cf1: position is ab, allowed: finite"),
        (config(id=3), {}, "drones: id is 3, allowed: text"),
        (config(decks="multiranger"), {}, "cf1: decks is 'multiranger', allowed: a list of multiranger, zranger"),
        (config(motor_ctrl=3), {}, "cf1: motor_ctrl is 3, allowed: a class or its name"),
        (config(vehicle={"mass": float("nan")}), {}, "^cf1: mass is 'nan', allowed: 0.005 to 0.5 kg"),
        (config(), {"scene": 3}, "scene is 3, allowed: the path"),
        (config(), {"faults": [3]}, "add_fault.3.: allowed: a Fault"),
        (config(platform="cf3"), {}, "cf1: platform is 'cf3', allowed: cf2, cf21bl"),
        (config(controller="fuzzy"), {}, r"crazyflie cf1: controller is 'fuzzy', allowed: auto \| pid"),
        (config(estimator="ukf"), {}, r"crazyflie cf1: estimator is 'ukf', allowed: auto \| complementary \| kalman"),
        (config(provider="none"), {}, "no provider named 'none' for cf2, there are "),
        (config(positioning="gps"), {}, r"crazyflie cf1: positioning is 'gps', allowed: none \| mocap \| flow"),
        (config(battery=1.5), {}, "crazyflie cf1: battery is '1.5', allowed: 0 to 1"),
        (config(noise=-1.0), {}, "crazyflie cf1: noise is '-1.0', allowed: 0 to 100"),
        (config(attributes={"mocap_rate": 2000}), {}, "mocap_rate is '2000', allowed: whole number 0 to 1000"),
        (config(attributes={"rocket": 1}), {}, "rocket"),
        (config(), {"seed": -1}, "seed is -1, allowed: a whole number from 0"),
        (
            config(),
            {"scene": "moon"},
            "scene 'moon' is neither a file nor one of: arena, .*, room",
        ),
        (config(), {"threads": 0}, "threads is 0, allowed: 1 to 64"),
    ],
)
def test_bad_input_ends_in_one_sentence(drones, options, sentence):
    with pytest.raises((RangeError, UnknownNameError), match=sentence) as caught:
        World(drones, **options)
    assert "\n" not in str(caught.value)


def test_number_of_threads_is_reported():
    assert set_threads(2) == 2
    assert set_threads(1) == 1


def test_run_refuses_to_go_back():
    with pytest.raises(RangeError, match="-1"):
        make_world().run(-1.0)


@pytest.mark.parametrize("timestep", [0.0005, 0.002])
def test_scene_may_have_its_own_time_step(timestep, tmp_path):
    scene = tmp_path / "scene.xml"
    scene.write_text(
        f'<mujoco><option timestep="{timestep}"/><worldbody><geom type="plane" size="9 9 1"/></worldbody></mujoco>'
    )
    world = World([DroneConfig("a", (0, 0))], scene=scene)
    world.wait_until_ready()
    world["a"].high_level_commander.takeoff(0.5, 1.5)
    world.run(4.0)
    assert world["a"].true_position[2] == pytest.approx(0.5, abs=0.06)
    assert world["a"].struct.onboard.tick == round(1000 * world.time)


def test_part_of_a_time_step_is_refused(tmp_path):
    scene = tmp_path / "scene.xml"
    scene.write_text('<mujoco><option timestep="0.002"/></mujoco>')
    world = World([DroneConfig("a", (0, 0))], scene=scene)
    with pytest.raises(RangeError, match=r"step\(3\).*multiple of 2"):
        world.step(3)


def test_waiting_for_a_drone_that_never_gets_ready_says_so():
    world = World([DroneConfig("a", (0, 0))])
    world["a"].emergency_stop()
    with pytest.raises(StateError, match="a: not ready after 3.0 s, state 'Locked'"):
        world.wait_until_ready(timeout_s=3.0)
    world["a"].reboot()
    world.wait_until_ready()


def test_snapshot_of_another_world_is_refused():
    with pytest.raises(RangeError, match="another world"):
        make_world(1).restore(make_world(2).snapshot())


def test_drone_that_is_carried_off_is_not_accelerated(ready_world):
    drone = ready_world.drones[0]
    drone.place((2.0, 1.0, 0.0145))
    ready_world.run(0.2)
    assert drone.true_position == pytest.approx([2.0, 1.0, 0.0145], abs=1e-3)
    assert drone.log["acc.z"] == pytest.approx(1.0, abs=0.05)


def test_flipped_drone_crashes_and_recovers(hovering_world):
    drone = hovering_world.drones[0]
    drone._qpos[3:7] = [0, 1, 0, 0]  # upside down
    hovering_world.run(3.0)
    assert drone.is_crashed
    assert [drone.log[f"motor.m{i}"] for i in (1, 2, 3, 4)] == [0, 0, 0, 0]
    with pytest.raises(StateError, match="cannot recover"):
        drone.recover_from_crash()
    drone.place((0.0, 0.0, 0.0145))
    hovering_world.run(1.0)
    drone.recover_from_crash()
    hovering_world.run(1.0)
    assert drone.can_fly
    drone.high_level_commander.takeoff(0.5, 1.5)
    hovering_world.run(4.0)
    assert drone.true_position[2] == pytest.approx(0.5, abs=0.1)


def test_motion_without_bounds_stops_one_drone_only():
    world = make_world(2)
    world.wait_until_ready()
    for drone in world.drones:
        drone.high_level_commander.takeoff(0.5, 1.0)
    world.run(2.0)
    broken, fine = world.drones
    broken._qvel[0] = np.nan
    world.run(1.0)
    assert "cf1" in broken.failure
    assert "not finite" in broken.failure
    assert broken.is_locked
    assert fine.is_flying
    assert fine.true_position[2] == pytest.approx(0.5, abs=0.1)
    assert np.all(np.isfinite(fine.true_position))


def test_representation_tells_what_one_holds(ready_world):
    assert "1 drones" in repr(ready_world)
    assert "Ready to fly" in repr(ready_world.drones[0])


@pytest.mark.parametrize("camera", ["follow", "overview"])
def test_world_draws_itself_or_says_why_not(ready_world, camera):
    """Without OpenGL on the machine, the promise is a clear error."""
    if rendering_available() is not None:
        with pytest.raises(RenderingError):
            ready_world.render(camera=camera)
        return
    picture = ready_world.render(320, 180, camera=camera)
    assert picture.shape == (180, 320, 3)
    assert picture.std() > 5


def test_unknown_camera_is_refused(ready_world):
    with pytest.raises(ValueError, match="no camera 'eye'; there are follow, fpv:NAME, chase:NAME, overview, track"):
        ready_world.render(camera="eye")
