"""The page of a swarm that is partly real: a served drone stands for the real one."""

import sys
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("cflib")
sys.path.append(str(Path(__file__).parents[1] / "flight"))
from served_drones import Served

from crazychoir_fw.flight.backends import build_world
from crazychoir_fw.flight.engine import make_experiment
from crazychoir_fw.flight.mixed_backend import MixedBackend
from crazychoir_fw.flight.sim_backend import SimBackend
from crazychoir_fw.gui.opening import open_mission
from crazychoir_fw.gui.session import Session
from crazychoir_fw.simulation.mirrored import MirroredConfig

MIXED = """
name: two
backend: mixed
drones:
  - {id: real, position: [-0.6, 0.0], uri: "udp://127.0.0.1:19850"}
  - {id: simulated, position: [0.6, 0.0]}
flight: [{takeoff: {duration: 2.0}}]
layers:
  rate: 100
  guidance: {class: SimpleGuidance, height: 0.8}
  planning: {class: Spline}
  control: {class: HierarchicalController, sender: FPQRSender, gains: mujoco}
"""


@pytest.fixture
def mixed(tmp_path):
    path = tmp_path / "two.yaml"
    path.write_text(MIXED)
    mission = open_mission(path)
    served = []

    def make(mission):
        world = build_world(mission, visuals=False, mirrored=[MirroredConfig("real")])
        world.wait_until_ready()
        served.append(Served(mission, tmp_path, ids=["real"]))
        return make_experiment(mission, MixedBackend(["real", "simulated"], SimBackend(world, "truth", 50), served))

    with Session(mission, make=make) as session:
        session.wait_until_ready()
        yield session, served[0].world_there["real"]


def test_buttons_reach_both_and_each_is_asked_where_it_is(mixed, api, until, tmp_path):
    session, real = mixed
    client = api(session, tmp_path / "drawings")
    assert client.get("/api/setting").json()["has_software"]
    answer = client.command(name="set_parameter", drones=["real"], parameter="posCtlPid.xKp", value=1.8)
    assert answer["ok"], answer
    # its radio confirms at once, and writes between two of its steps
    until(lambda: real.param["posCtlPid.xKp"] == pytest.approx(1.8))
    assert session.access.set_parameter(1, "posCtlPid.xKp", 1.7) == pytest.approx(1.7)
    assert real.param["posCtlPid.xKp"] == pytest.approx(1.8)
    until(lambda: (np.abs(session.ask(session.access.batteries).result() - 3.9) < 0.4).all())
    assert client.command(name="takeoff")["ok"]
    until(lambda: (session.frame.position[:, 2] > 0.7).all())
    assert client.command(name="goto", drones=["real"], x=-0.6, y=0.5, z=1.0)["ok"]
    until(lambda: np.linalg.norm(real.true_position - [-0.6, 0.5, 1.0]) < 0.1)
    refused = client.command(name="rewind", branch=0, time=0.5)
    assert not refused["ok"] and "real drones" in refused["text"]
    assert client.command(name="land")["ok"]
    until(lambda: (session.frame.position[:, 2] < 0.08).all())
    assert real.true_position[2] < 0.08
