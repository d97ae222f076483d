import gc
from concurrent.futures import ThreadPoolExecutor
from contextlib import nullcontext

import numpy as np
import pytest

from crazychoir_fw.common.errors import RangeError, StateError, UnknownNameError
from crazychoir_fw.recording.opengl import RenderingError, rendering_available
from crazychoir_fw.simulation import DroneConfig, World

WALL_AT = 2.0
ROOM = f"""
<mujoco>
  <option timestep="0.001"/>
  <visual> <quality shadowsize="256" offsamples="0"/> <map zfar="10"/> </visual>
  <statistic extent="4" center="0 0 1"/>
  <worldbody>
    <light directional="true" pos="0 0 4" dir="0 0 -1"/>
    <geom name="floor" type="plane" size="8 8 1" rgba="0.4 0.4 0.4 1"/>
    <geom name="wall" type="box" pos="{WALL_AT + 0.1} 0 0" size="0.1 3 3" rgba="0.9 0.1 0.1 1"/>
    <camera name="west" pos="-2 0 1" xyaxes="0 -1 0 0 0 1" fovy="50"/>
  </worldbody>
</mujoco>
"""


@pytest.fixture
def drawing():
    return nullcontext() if rendering_available() is None else pytest.raises(RenderingError, match="no rendering")


@pytest.fixture
def room(tmp_path):
    path = tmp_path / "room.xml"
    path.write_text(ROOM)
    return path


def redness(image: np.ndarray) -> float:
    red, green, blue = np.moveaxis(image.astype(int), -1, 0)
    return float(((red > 2 * green) & (red > 2 * blue)).mean())


def lone_drone(room, **options) -> World:
    return World([DroneConfig("cf1", (0.0, 0.0, 0.6), color=(0.0, 0.0, 1.0), **options)], scene=room)


def test_the_onboard_camera_sees_what_is_ahead(room, drawing):
    world = lone_drone(room)
    camera = world["cf1"].camera()
    with drawing:
        image = camera.image()
        assert image.shape == (244, 324, 3) and image.dtype == np.uint8
        assert redness(image) > 0.4
        # straight ahead is in the middle, the floor below it
        assert redness(image[100:122, 150:170]) == 1.0
        assert redness(image[-20:]) == 0.0
        world["cf1"].place((0.0, 0.0, 0.6), yaw_deg=180.0)
        assert redness(camera.image()) == 0.0


def test_the_onboard_camera_rolls_with_its_drone(room, drawing):
    world = lone_drone(room)
    with drawing:
        half = np.radians(90.0) / 2.0
        world.data.qpos[3:7] = np.cos(half), np.sin(half), 0.0, 0.0
        image = world["cf1"].camera(width=120, height=120, fov_deg=80.0).image()
        # the right side is down: the floor is on the left edge of the picture or the right one, as the drone rolled
        assert redness(image[:, :8]) > 0.9 and redness(image[:, -8:]) == 0.0


def test_tilt_and_field_of_view_are_choosable(room, drawing):
    drone = lone_drone(room)["cf1"]
    with drawing:
        assert redness(drone.camera(tilt_deg=-90.0, fov_deg=30.0).image()) == 0.0
        wide, narrow = (redness(drone.camera(fov_deg=fov).image()) for fov in (110.0, 20.0))
        assert narrow == 1.0 and wide < 0.8


def test_depth_is_distance_along_the_view(room, drawing):
    world = lone_drone(room)
    camera = world["cf1"].camera(width=64, height=48)
    with drawing:
        lens = 0.032
        assert camera.depth()[20, 32] == pytest.approx(WALL_AT - lens, abs=2e-3)
        world["cf1"].place((1.0, 0.5, 1.2))
        depth = camera.depth()
        assert depth.shape == (48, 64)
        # a plane at a right angle to the view is equally far in all pixels
        np.testing.assert_allclose(depth[:20], WALL_AT - 1.0 - lens, atol=2e-3)
        world["cf1"].place((0.0, 0.0, 0.6), yaw_deg=180.0)
        assert np.isinf(camera.depth()[0]).all()


def test_segmentation_names_geoms(room, drawing):
    world = lone_drone(room)
    with drawing:
        geoms = world["cf1"].camera(width=64, height=48).segmentation()
        wall, floor = (world.model.geom(name).id for name in ("wall", "floor"))
        assert geoms[20, 32] == wall and geoms[-1, 32] == floor
        assert set(np.unique(geoms)) == {wall, floor}
        world["cf1"].place((0.0, 0.0, 0.6), yaw_deg=180.0)
        assert world["cf1"].camera(width=64, height=48).segmentation()[0, 0] == -1


def test_the_chasing_camera_sees_its_drone_from_behind_and_stays_level(room, drawing):
    world = lone_drone(room)
    camera = world["cf1"].camera("chase")
    body = world.model.body("cf1").id
    with drawing:

        def seen() -> np.ndarray:
            geoms = camera.segmentation()
            return np.argwhere((geoms >= 0) & (world.model.geom_bodyid[geoms] == body))

        pixels = seen()
        assert len(pixels) > 200
        # in the middle of the width, the wall behind
        assert abs(pixels[:, 1].mean() - 320) < 10
        assert redness(camera.image()) > 0.2
        half = np.radians(40.0) / 2.0
        world.data.qpos[3:7] = np.cos(half), np.sin(half), 0.0, 0.0
        rolled = camera.image()
        assert redness(rolled[0, :1]) == redness(rolled[0, -1:])  # the horizon is still level
        world["cf1"].place((0.0, 0.0, 0.6), yaw_deg=180.0)
        assert redness(camera.image()) < 1e-3 and len(seen()) > 200


def test_cameras_of_the_scene_and_anywhere(room, drawing):
    world = lone_drone(room)
    with drawing:
        cameras = (
            world.camera("west", 160, 120),
            world["cf1"].camera("west", 160, 120),
            world.camera("west", 160, 120, fov_deg=50.0),
            world.camera(position=(-2.0, 0.0, 1.0), look_at=(0.0, 0.0, 1.0), width=160, height=120, fov_deg=50.0),
        )
        body = world.model.body("cf1").id
        for camera in cameras:
            geoms = camera.segmentation()
            row, column = np.argwhere((geoms >= 0) & (world.model.geom_bodyid[geoms] == body)).mean(axis=0)
            # 2 m ahead and 0.4 m lower, at 120 pixels for 50 degrees
            assert row == pytest.approx(59.5 + 60.0 * 0.2 / np.tan(np.radians(25.0)), abs=2.0)
            assert column == pytest.approx(79.5, abs=1.0)
            assert redness(camera.image()) > 0.2


def test_a_picture_is_of_this_very_instant(room, drawing):
    world = lone_drone(room)
    camera = world["cf1"].camera(width=32, height=24)
    with drawing:
        for x in (0.0, 0.7):
            world["cf1"].place((x, 0.0, 1.0))
            assert camera.depth()[8, 16] == pytest.approx(WALL_AT - x - 0.032, abs=2e-3)


def test_looking_changes_no_bit_of_a_flight(room, drawing):
    def fly(look: bool) -> bytes:
        drones = [DroneConfig("cf1", (0.0, 0.0)), DroneConfig("cf2", (0.5, 0.0))]
        world = World(drones, scene=room, seed=3, threads=2)
        if look:
            for drone in world.drones:
                drone.camera(width=32, height=24).every(20, lambda _: None)
            world.camera("west", 48, 32).every(7, lambda _: None)
        world.wait_until_ready()
        world["cf1"].high_level_commander.takeoff(absolute_height_m=0.5, duration_s=1.0)
        world.run(0.5)
        return world.snapshot().tobytes()

    blind = fly(False)
    with drawing:
        assert fly(True) == blind


@pytest.mark.parametrize("rate", [1, 3, 25, 30, 60, 1000])
def test_pictures_come_at_their_own_rate(room, monkeypatch, rate):
    from crazychoir_fw.simulation.cameras import Camera

    world = lone_drone(room)
    camera, ticks = world["cf1"].camera(), []
    monkeypatch.setattr(Camera, "image", lambda _: world.tick)
    cancel = camera.every(rate, ticks.append)
    world.step(1000)
    assert ticks == [(k + 1) * 1000 // rate for k in range(rate)]
    cancel()
    world.step(1000)
    assert len(ticks) == rate


def test_pictures_come_again_after_a_restore(room, monkeypatch):
    from crazychoir_fw.simulation.cameras import Camera

    world = lone_drone(room)
    camera, ticks = world["cf1"].camera(), []
    monkeypatch.setattr(Camera, "image", lambda _: world.tick)
    camera.every(30, ticks.append)
    start = world.snapshot()
    world.step(100)
    world.restore(start)
    world.step(100)
    assert ticks == [33, 66, 100] * 2


def test_sizes_follow_one_another_in_one_renderer(room, drawing):
    world = lone_drone(room)
    with drawing:
        first = world["cf1"].camera(width=80, height=60)
        before = first.image().copy()
        assert world["cf1"].camera("chase", 200, 100).image().shape == (100, 200, 3)
        np.testing.assert_array_equal(first.image(), before)


def test_a_world_that_is_forgotten_does_not_disturb_the_next_one(room, drawing, monkeypatch):
    """Garbage collection may come between two commands to the driver."""
    from crazychoir_fw.recording import renderer

    def forget(then=lambda: None):
        gc.collect()
        return then()

    def seen(**options):
        world = lone_drone(room, **options)
        # a circle of references, which only garbage collection finds
        world.itself = world  # type: ignore[attr-defined]
        return world["cf1"].camera(width=80, height=60).image()

    with drawing:
        alone = seen()
        opened = len(renderer._open)
        is_software = renderer.is_software
        monkeypatch.setattr(renderer, "is_software", lambda: forget(is_software))
        np.testing.assert_array_equal(seen(), alone)
        with ThreadPoolExecutor(1) as pool:
            seen()
            pool.submit(gc.collect).result()
            np.testing.assert_array_equal(seen(), alone)
        assert len(renderer._open) <= opened + 1


@pytest.mark.parametrize(
    ("ask", "error", "message"),
    [
        (lambda w: w["cf1"].camera("eye"), UnknownNameError, "no camera named 'eye', there are: fpv, chase, west"),
        (lambda w: w.camera("eye"), UnknownNameError, "there are: west"),
        (lambda w: w.camera(), RangeError, "either the name of a camera of the scene or a position"),
        (lambda w: w.camera("west", position=(0, 0, 1)), RangeError, "either the name"),
        (lambda w: w.camera(position=(0, 0, 1), look_at=(0, 0, 1)), RangeError, "looks at itself"),
        (lambda w: w.camera(position=(0, 0, np.nan)), RangeError, "allowed: two points"),
        (lambda w: w["cf1"].camera(width=0, height=5000), RangeError, "height is 5000, allowed: 1 to 4096 pixels"),
        (lambda w: w["cf1"].camera(width=-1), RangeError, "width is -1, allowed: 1 to 4096 pixels"),
        (lambda w: w["cf1"].camera(fov_deg=180.0), RangeError, "fov_deg is 180.0, allowed: 1 to 170"),
        (lambda w: w["cf1"].camera(tilt_deg=np.nan), RangeError, "tilt_deg is nan, allowed: -90 to 90"),
        (lambda w: w["cf1"].camera().every(0, print), RangeError, "rate_hz is 0, allowed: a whole number"),
        (lambda w: w["cf1"].camera().every(12.5, print), RangeError, "rate_hz is 12.5"),
    ],
)
def test_what_is_impossible_is_refused(room, ask, error, message):
    with pytest.raises(error, match=message):
        ask(lone_drone(room))


def test_a_world_without_visuals_says_so(room):
    world = World([DroneConfig("cf1")], scene=room, visuals=False)
    with pytest.raises(StateError, match="built with visuals=False"):
        world["cf1"].camera().image()


def test_without_opengl_a_picture_is_a_rendering_error(room, monkeypatch):
    from crazychoir_fw.recording import opengl

    monkeypatch.setenv("MUJOCO_GL", "off")
    opengl._context_class.cache_clear()
    try:
        with pytest.raises(RenderingError, match="no rendering: MUJOCO_GL=off"):
            lone_drone(room)["cf1"].camera().image()
    finally:
        opengl._context_class.cache_clear()


def test_targets_are_where_drones_are_told_to_be(room):
    from crazychoir_fw.simulation.targets import Targets

    world = World([DroneConfig("cf1", (0.0, 0.0)), DroneConfig("cf2", (0.5, 0.0))], scene=room)
    targets = Targets(world.drones)
    assert np.isnan(targets.positions()).all()
    world.wait_until_ready()
    world["cf2"].high_level_commander.takeoff(absolute_height_m=0.5, duration_s=1.0)
    world.run(1.5)
    told = targets.positions()
    assert np.isnan(told[0]).all()
    np.testing.assert_allclose(told[1], [0.5, 0.0, 0.5], atol=0.01)
    assert told[1, 2] == world["cf2"].log["ctrltarget.z"]
