"""Snapshots hold the whole world, also in a file and for another process, and refuse what is not theirs."""

import os
import subprocess
import sys
from pathlib import Path

import mujoco
import numpy as np
import pytest
from worlds import make_world

import crazychoir_fw
from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.simulation import DroneConfig, Snapshot, World
from crazychoir_fw.simulation.snapshot import BESIDE_THE_STATE

SCENE = """
<mujoco>
  <option timestep="0.001"/>
  <worldbody>
    <geom type="plane" size="5 5 0.1"/>
    <body name="gate" mocap="true" pos="0 1 1"><geom type="box" size="0.1 0.1 0.1"/></body>
    <body name="one" pos="2 0 0.5"><freejoint/><geom size="0.05"/></body>
    <body name="two" pos="2 0.3 0.5"><freejoint/><geom size="0.05"/></body>
  </worldbody>
  <equality><weld name="tie" body1="one" body2="two"/></equality>
</mujoco>
"""


@pytest.fixture
def airborne():
    world = make_world(3, seed=4)
    world.wait_until_ready()
    for drone in world.drones:
        drone.high_level_commander.takeoff(0.5, 1.0)
    world.run(1.2)
    return world


def test_a_file_leads_to_the_same_bits(airborne, tmp_path):
    airborne.note("fault", "cf1", efficiency=0.9)
    snapshot = airborne.snapshot()
    snapshot.save(tmp_path / "here.npz")
    airborne.note("later")
    airborne.run(0.5)

    other = make_world(3, seed=4, visuals=False)
    other.restore(Snapshot.load(tmp_path / "here.npz"))
    assert other.snapshot().tobytes() == snapshot.tobytes()
    assert [event.kind for event in other.events] == ["fault"]
    assert list(other.journal) == list(snapshot.journal)
    assert [request.verb for request in other.journal][-3:] == ["cf_takeoff"] * 3
    other.run(0.5)
    assert other.snapshot().tobytes() == airborne.snapshot().tobytes()


def test_another_process_goes_on_with_the_same_bits(airborne, tmp_path):
    airborne.snapshot().save(tmp_path / "here.npz")
    script = f"""
from worlds import make_world
from crazychoir_fw.simulation import Snapshot
world = make_world(3, seed=4, threads=2)
world.restore(Snapshot.load({str(tmp_path / "here.npz")!r}))
world.drones[1].high_level_commander.go_to(0.4, 0.2, 0.7, 0.0, 0.5)
world.run(0.6)
world.snapshot().save({str(tmp_path / "there.npz")!r})
"""
    paths = [str(Path(__file__).parent), str(Path(crazychoir_fw.__file__).parents[1])]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(paths)}
    subprocess.run([sys.executable, "-c", script], check=True, timeout=60, env=environment)
    airborne.drones[1].high_level_commander.go_to(0.4, 0.2, 0.7, 0.0, 0.5)
    airborne.run(0.6)
    there = Snapshot.load(tmp_path / "there.npz")
    assert there.tobytes() == airborne.snapshot().tobytes()
    assert list(there.journal) == list(airborne.journal)


def test_equality_constraints_mocap_bodies_and_applied_forces_come_back(tmp_path):
    scene = tmp_path / "scene.xml"
    scene.write_text(SCENE)
    world = World([DroneConfig("cf1")], scene=scene)
    data = world.data
    gate = world.model.body("gate").mocapid[0]

    def set_up(tie, height, force):
        data.eq_active[0] = tie
        data.mocap_pos[gate, 2] = height
        data.xfrc_applied[world.model.body("one").id, 0] = force

    set_up(0, 1.7, 0.03)
    world.run(0.1)
    snapshot = world.snapshot()
    world.run(0.2)
    first = world.snapshot().tobytes()
    set_up(1, 0.4, 0.0)
    world.run(0.1)
    snapshot.save(tmp_path / "here.npz")
    world.restore(Snapshot.load(tmp_path / "here.npz"))
    assert data.eq_active[0] == 0
    assert data.mocap_pos[gate, 2] == 1.7
    assert data.xfrc_applied[world.model.body("one").id, 0] == 0.03
    # derived quantities are up to date right after the restore
    assert data.body("gate").xpos[2] == 1.7
    world.run(0.2)
    assert world.snapshot().tobytes() == first


def test_every_array_beside_the_state_is_one_of_mjdata(airborne):
    assert set(airborne.snapshot().beside) == set(BESIDE_THE_STATE)
    before = {name: getattr(airborne.data, name).copy() for name in BESIDE_THE_STATE}
    snapshot = airborne.snapshot()
    for name in BESIDE_THE_STATE:
        getattr(airborne.data, name)[:] += 1
    airborne.restore(snapshot)
    for name, values in before.items():
        np.testing.assert_array_equal(getattr(airborne.data, name), values)


@pytest.mark.parametrize(
    ("other", "says"),
    [
        (lambda: make_world(2, seed=4), "it has 3 drones and .* numbers of state, this one 2 drones"),
        (lambda: make_world(3, seed=5), "configured differently or another seed"),
        (lambda: World([DroneConfig(f"x{i}", (0.5 * i, 0.0)) for i in range(3)], seed=4), "configured differently"),
        (
            lambda: World(
                [DroneConfig(f"cf{i + 1}", (0.5 * i, 0.0), motor_ctrl="MotorCtrlVel") for i in range(3)], seed=4
            ),
            "flown by other Python classes",
        ),
        (lambda: World([DroneConfig(f"cf{i + 1}", (0.5 * i, 0.1)) for i in range(3)], seed=4), "other vehicles"),
        (lambda: World([DroneConfig(f"cf{i + 1}", (0.5 * i, 0.0), mass=0.03) for i in range(3)], seed=4), "vehicles"),
    ],
)
def test_a_snapshot_of_another_world_is_refused_with_the_reason(airborne, other, says):
    with pytest.raises(RangeError, match=f"belongs to another world: .*{says}"):
        other().restore(airborne.snapshot())


def test_a_snapshot_of_another_version_is_refused(airborne):
    snapshot = airborne.snapshot()
    older = {**snapshot.fingerprint, "versions": "crazychoir_fw 0.0.9 over MuJoCo 3.1.0"}
    object.__setattr__(snapshot, "fingerprint", older)
    with pytest.raises(RangeError, match=r"was made with crazychoir_fw 0\.0\.9 over MuJoCo 3\.1\.0, this is "):
        airborne.restore(snapshot)


def test_a_snapshot_that_was_cut_is_refused_and_changes_nothing(airborne):
    before = airborne.snapshot()
    cut = airborne.snapshot()
    object.__setattr__(cut, "state", cut.state[:-1])
    with pytest.raises(RangeError, match="damaged"):
        airborne.restore(cut)
    assert airborne.snapshot().tobytes() == before.tobytes()


def test_files_that_are_no_snapshots_are_refused(airborne, tmp_path):
    text = tmp_path / "text.npz"
    text.write_text("no snapshot")
    with pytest.raises(RangeError, match="is not a snapshot"):
        Snapshot.load(text)
    with pytest.raises(FileNotFoundError):
        Snapshot.load(tmp_path / "gone.npz")
    pickled = tmp_path / "pickled.npz"
    np.savez(pickled, about=np.array([{}], dtype=object))
    with pytest.raises(RangeError, match="is not a snapshot"):
        Snapshot.load(pickled)
    whole = tmp_path / "whole.npz"
    airborne.snapshot().save(whole)
    cut = tmp_path / "cut.npz"
    cut.write_bytes(whole.read_bytes()[:-2000])
    with pytest.raises(RangeError, match="is not a snapshot"):
        Snapshot.load(cut)


def test_a_snapshot_is_the_row_that_mujoco_takes(airborne):
    snapshot = airborne.snapshot()
    row = np.asarray(snapshot)
    size = mujoco.mj_stateSize(airborne.model, mujoco.mjtState.mjSTATE_INTEGRATION)
    assert row.shape == (size,)
    assert np.array(snapshot, copy=True) is not snapshot.state
    assert repr(snapshot).startswith(f"<Snapshot at {airborne.time:.3f} s, ")
