"""Scenes in YAML: what stands where, and what is refused."""

import mujoco
import numpy as np
import pytest

from crazychoir_fw.common.errors import CrazychoirError, MissionError
from crazychoir_fw.flight import fly
from crazychoir_fw.mission import load_mission
from crazychoir_fw.recording.flight_log import FlightLog
from crazychoir_fw.simulation import DroneConfig, World, replay
from crazychoir_fw.simulation.stage import stage_of

YARD = """
light: 0.5
boxes: {crate: {position: [1.0, 0.5], size: [0.4, 0.2, 0.3], yaw_deg: 90, color: [1, 0, 0]}}
walls: {north: {from: [-2, 2], to: [2, 2], height: 1.5, thickness: 0.1}}
pillars: {tree: {position: [-1, 0], radius: 0.1, height: 2.0}}
gates: {first: {position: [0.0, 1.0, 1.0], yaw_deg: 90, size: 0.6}}
"""
FLIGHT = "\nflight: [{takeoff: {height: 1.0}}, {hover: {duration: 1.0}}, {land: {}}]\n"


def yard(tmp_path, text=YARD):
    (tmp_path / "yard.yaml").write_text(text)
    return tmp_path / "yard.yaml"


def distance(world, start, direction):
    """Return how far a ray goes until it hits a geom, and the name of that."""
    mujoco.mj_forward(world.model, world.data)
    geom = np.zeros(1, np.int32)
    far = mujoco.mj_ray(
        world.model, world.data, np.array(start, float), np.array(direction, float), None, 1, -1, geom, None
    )
    return far, mujoco.mj_id2name(world.model, mujoco.mjtObj.mjOBJ_GEOM, geom[0])


def test_objects_stand_where_the_file_says(tmp_path):
    world = World([DroneConfig("cf1", (0, -1.0))], scene=yard(tmp_path))
    for start, direction, far, name in (
        ([1.0, 0.5, 1.0], [0, 0, -1], 0.7, "crate"),  # upper side at 0.3 m
        ([0.0, 0.5, 0.1], [1, 0, 0], 0.9, "crate"),  # turned: 0.2 m along x
        ([1.5, 0.0, 0.5], [0, 1, 0], 1.95, "north"),
        ([-1.0, -1.0, 1.9], [0, 1, 0], 0.9, "tree"),
        ([0.0, 1.0, 1.0], [0, 0, 1], 0.3, "first_top"),
        ([0.0, 1.0, 1.0], [1, 0, 0], 0.3, "first_right"),
    ):
        found, what = distance(world, start, direction)
        assert (what, found) == (name, pytest.approx(far, abs=1e-6))
    through, what = distance(world, [0.0, 0.0, 1.0], [0, 1, 0])
    assert (what, through) == ("north", pytest.approx(1.95))  # nothing within the gate


def test_light_is_a_factor(tmp_path):
    half = World([DroneConfig("cf1", (0, 0))], scene=yard(tmp_path, "light: 0.5\n")).model
    whole = World([DroneConfig("cf1", (0, 0))], scene="arena").model
    np.testing.assert_allclose(half.light_diffuse, 0.5 * whole.light_diffuse, rtol=1e-6)


def test_a_drone_that_takes_off_below_a_box_hits_it_by_its_name(tmp_path):
    yard(tmp_path, "boxes: {lid: {position: [0, 0, 0.6], size: [1, 1, 0.1]}}\n")
    (tmp_path / "m.yaml").write_text("scene: yard.yaml\ndrones: {count: 1}" + FLIGHT)
    result = fly(load_mission(tmp_path / "m.yaml"))
    assert not result.success
    assert any(event["details"].get("other") == "lid" for event in result.log.events if event["kind"] == "collision")


def test_a_crash_lets_the_drone_fall_and_the_others_fly_to_the_end(tmp_path):
    yard(tmp_path, "walls: {wall: {from: [0.4, -0.5], to: [0.4, 0.5], height: 1.5}}\n")
    (tmp_path / "m.yaml").write_text(
        "scene: yard.yaml\n"
        # with these deviations it falls flat; with other ones it may lean against the wall
        "defaults: {parameters: {locSrv.extPosStdDev: 0.01, locSrv.extQuatStdDev: 4.5e-3}}\n"
        "drones: [{id: a, position: [0, 0]}, {id: b, position: [0, 2]}]\n"
        "flight: [{takeoff: {height: 0.8}}, {go_to: {offset: [0.8, 0, 0], duration: 1.0}}, {hover: {duration: 2.0}},"
        " {land: {}}]\n"
    )
    result = fly(load_mission(tmp_path / "m.yaml"))
    assert [sentence[:2] for sentence in result.failures] == ["a:"]
    assert "hit wall" in result.failures[0]
    np.testing.assert_allclose(result.log.signals["sim.z"][-1], 0.0, atol=0.05)  # one fell, the other has landed
    assert result.log.signals["sim.x"][-1, 1] == pytest.approx(0.8, abs=0.1)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("boxes: {a: {position: [0, 0], size: [1, 1, -1]}}", r"boxes.a.size\[2\] is -1, but must be greater than 0"),
        ("boxes: {a: {position: [0, 0]}}", "boxes.a.size is missing"),
        ("gates: {g: {position: [0, 0, 1], yaw: 3}}", "there is no key gates.g.yaw"),
        ("light: 9", "light is 9, but must be less than or equal to 2"),
        ("houses: {}", "there is no key houses"),
        ("boxes: [", r"yard\.yaml"),
        ("- 1", "the file is"),
    ],
)
def test_what_does_not_fit_is_one_sentence(tmp_path, text, says):
    yard(tmp_path, text)
    (tmp_path / "m.yaml").write_text("scene: yard.yaml\ndrones: {count: 1}" + FLIGHT)
    with pytest.raises(MissionError, match=says) as caught:
        load_mission(tmp_path / "m.yaml")
    assert "\n" not in str(caught.value)


INLINE = YARD.replace("\n", "\n  ")


def test_a_scene_may_stand_in_the_mission(tmp_path):
    (tmp_path / "m.yaml").write_text(f"scene:{INLINE}\ndrones: [{{id: a, position: [0, -1]}}]" + FLIGHT)
    result = fly(load_mission(tmp_path / "m.yaml"))
    assert result.success, result.failures
    twin = World([DroneConfig("a", (0, -1.0))], scene=yard(tmp_path)).model
    assert mujoco.mj_sizeModel(twin) == mujoco.mj_sizeModel(
        World([DroneConfig("a", (0, -1.0))], result.world.scene).model
    )
    result.log.save(tmp_path / "log.npz")
    (tmp_path / "m.yaml").unlink()
    (tmp_path / "yard.yaml").unlink()
    log = FlightLog.load(tmp_path / "log.npz")
    assert replay(log).deviation is None  # from the log alone
    assert stage_of(log).model.body("crate").id > 0


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("{boxes: {a: {position: [0, 0], size: [1, 1, -1]}}}", r"scene.boxes.a.size\[2\] is -1, but must be greater"),
        ("{gates: {g: {position: [0, 0, 1], yaw: 3}}}", "there is no key gates.g.yaw"),
        ("{houses: {}}", "there is no key houses"),
        ("{boxes: {a: {position: [.nan, 0], size: [1, 1, 1]}}}", "boxes.a.position"),
        ("[arena]", "scene"),
        ("'{'", "scene of the mission cannot be read"),
    ],
)
def test_a_scene_of_the_mission_that_does_not_fit_is_one_sentence(tmp_path, text, says):
    (tmp_path / "m.yaml").write_text(f"scene: {text}\ndrones: {{count: 1}}" + FLIGHT)
    with pytest.raises(CrazychoirError, match=says) as caught:
        load_mission(tmp_path / "m.yaml")
    assert "\n" not in str(caught.value) and "m.yaml" in str(caught.value)


def test_a_scene_file_is_read_within_limits(tmp_path):
    bomb = "a: &a [x, x, x, x, x, x, x, x, x, x]\n" + "".join(
        f"{new}: &{new} [{', '.join([f'*{old}'] * 10)}]\n" for old, new in zip("abcdefg", "bcdefgh", strict=True)
    )
    yard(tmp_path, bomb)
    (tmp_path / "m.yaml").write_text("scene: yard.yaml\ndrones: {count: 1}" + FLIGHT)
    with pytest.raises(MissionError, match="300000|allowed"):
        load_mission(tmp_path / "m.yaml")
