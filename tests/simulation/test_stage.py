"""The stage of a recorded flight: what a log alone says about how everything looked."""

import mujoco
import numpy as np
import pytest

from crazychoir_fw.common.errors import CrazychoirError
from crazychoir_fw.recording.flight_log import FlightLog
from crazychoir_fw.simulation import DroneConfig, World
from crazychoir_fw.simulation.recorder import FlightRecorder
from crazychoir_fw.simulation.stage import footprints, stage_of

SCENE = """
<mujoco>
  <extension><plugin plugin="crazychoir.crazyflie"/></extension>
  <worldbody>
    <geom type="plane" size="0 0 0.05"/>
    <geom name="wall" type="box" pos="3 0 0.5" euler="0 0 90" size="1 0.1 0.5" rgba="1 0 0 1"/>
    <body name="ball" pos="0 1 2"><freejoint/><geom type="sphere" size="0.05"/></body>
    <body name="own" pos="1 1 0.0145">
      <freejoint/>
      <inertial pos="0 0 0" mass="0.029" diaginertia="1.6e-5 1.6e-5 2.9e-5"/>
      <geom type="box" size="0.05 0.05 0.014" contype="3" conaffinity="2"/>
      <plugin plugin="crazychoir.crazyflie"><config key="provider" value="{provider}"/></plugin>
    </body>
  </worldbody>
</mujoco>
"""


def test_everything_is_where_it_was_in_the_flight(tmp_path):
    scene = tmp_path / "scene.xml"
    scene.write_text(SCENE.format(provider="builtin"))
    loaded = DroneConfig("cf1", (0.5, -0.5, 1.0), yaw_deg=30.0, payload={"mass": 0.005, "detachable": True})
    world = World([loaded], scene=scene, seed=1, visuals=False)
    recorder = FlightRecorder(world)
    recorder.run(0.3)  # ball, drone and payload fall
    recorder.finish().save(tmp_path / "log.npz")
    log = FlightLog.load(tmp_path / "log.npz")
    stage = stage_of(log)
    assert stage.model.nplugin == 1 and sorted(stage.drones) == ["cf1", "own"]
    qpos = recorder.qpos
    np.testing.assert_allclose(stage.qpos, qpos, atol=1e-5)
    assert np.ptp(qpos, axis=0).max() > 0.3
    # what the drone carries is seen, and so is the drone, although the world that flew had neither
    assert stage.model.geom("cf1/accent").id >= 0
    # another scene: a warning names the change, and the body that moved before stands still
    scene.write_text(SCENE.format(provider="builtin").replace('<freejoint/><geom type="sphere"', '<geom type="sphere"'))
    warnings = stage_of(log).warnings
    assert "has changed since the flight" in warnings[0] and "stands still" in warnings[1]


def test_no_code_of_the_users_is_built_for_a_film(tmp_path):
    scene, trap = tmp_path / "scene.xml", tmp_path / "trap.c"
    scene.write_text(SCENE.format(provider="builtin"))
    world = World([DroneConfig("cf1", (0.5, -0.5))], scene=scene, seed=1)
    recorder = FlightRecorder(world)
    recorder.run(0.05)
    log = recorder.finish()
    trap.write_text("#error built")
    scene.write_text(SCENE.format(provider="bitcraze"))
    for entry in log.journal.recipe["drones"]:
        entry |= {"app": [str(trap)], "provider": "bitcraze", "motor_ctrl": f"{tmp_path}/trap.py:Trap"}
    stage = stage_of(log)
    assert len(stage.qpos) == len(log.time)


def test_drones_without_a_world_are_shown_from_what_they_believed():
    time = np.array([0.0, 1.0, 1.0, 2.0])
    signals = {f"stateEstimate.{axis}": np.zeros((4, 1)) for axis in ("x", "y", "z", "roll", "pitch", "yaw")}
    signals["stateEstimate.z"] = np.array([[0.5], [np.nan], [1.0], [1.5]])
    signals["stateEstimate.pitch"] = np.full((4, 1), 90.0)
    log = FlightLog(time, ["real"], signals, {"stage": {"scene": "room", "drones": [{"id": "real", "app": ["x.c"]}]}})
    stage = stage_of(log)
    assert stage.model.body("real").id and stage.times.tolist() == [0.0, 1.0, 2.0]
    np.testing.assert_allclose(stage.qpos[:, 2], [0.5, 0.5, 1.5])
    data = mujoco.MjData(stage.model)
    data.qpos[:] = stage.qpos[0]
    mujoco.mj_kinematics(stage.model, data)
    # a positive pitch of the log lifts the nose
    np.testing.assert_allclose(data.body("real").xmat.reshape(3, 3)[:, 0], [0.0, 0.0, 1.0], atol=1e-9)


@pytest.mark.parametrize(
    ("metadata", "message"),
    [
        ({"stage": {"scene": "/nowhere.xml"}}, "neither a file nor one of"),
        ({"stage": {"drones": 7}}, "does not describe its scene"),
        ({"stage": {"drones": [{"id": "a", "payload": {"mass": "x"}}]}}, "payload.mass"),
    ],
)
def test_a_log_that_describes_no_stage_is_refused(metadata, message):
    signals = {f"sim.{axis}": np.zeros((1, 1)) for axis in "xyz"}
    with pytest.raises(CrazychoirError, match=message):
        stage_of(FlightLog(np.zeros(1), ["a"], signals, metadata))
    with pytest.raises(CrazychoirError, match="neither sim.x, y, z nor stateEstimate.x, y, z"):
        stage_of(FlightLog(np.zeros(1), ["a"], {}, metadata))


def test_footprints_are_what_stands_still(tmp_path):
    scene = tmp_path / "scene.xml"
    scene.write_text(SCENE.format(provider="builtin"))
    ((corners, color),) = footprints(World([], scene=scene).model)
    np.testing.assert_allclose(corners.min(axis=0), [2.9, -1.0, 0.0], atol=1e-9)
    np.testing.assert_allclose(corners.max(axis=0), [3.1, 1.0, 1.0], atol=1e-9)
    assert color == (1.0, 0.0, 0.0)
