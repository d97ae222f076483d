"""A law from a file beside the mission: it takes off, flies and lands alike in one process and as nodes."""

import json

import numpy as np
import pytest
from ros_flights import PATIENCE, Flight

from crazychoir_fw.flight.engine import fly
from crazychoir_fw.mission import load_mission

LAW = '''
import numpy as np
from crazychoir_fw.guidance import CFDistributedFeedback


class Rendezvous(CFDistributedFeedback):
    """That of docs/guidance.md."""

    def evaluate_input(self, neigh_data):
        own = self.current_pose
        pull = sum((pose.position - own.position for pose in neigh_data.values()), np.zeros(3))
        return 0.5 * pull - 1.5 * own.velocity
'''

MISSION = """
name: meet
backend: {backend}
log_rate: 50
seed: 1
drones:
  - {{id: agent_0, position: [0.0, 0.0]}}
  - {{id: agent_1, position: [2.0, 0.0]}}
  - {{id: agent_2, position: [1.0, 2.0]}}
layers:
  rate: 50
  communication: {{graph: complete}}
  guidance: {{class: "rendezvous.py:Rendezvous", height: 0.8}}
  planning: {{class: Spline}}
  control: {{gains: mujoco}}
flight:
  - takeoff: {{duration: 3}}
  - start: {{duration: 1.5}}
  - land: {{duration: 3}}
"""


def write(folder, backend):
    (folder / "rendezvous.py").write_text(LAW)
    return MISSION.format(backend=backend)


def check(z, nearest):
    """Look at heights (m), shape (T, N), and at how near two came (m)."""
    assert z.max(axis=0) == pytest.approx(0.8, abs=0.2)
    assert z[-1] == pytest.approx(0.015, abs=0.05)
    assert 0.3 < nearest < 1.2  # from 2 m


@pytest.mark.parametrize("backend", ["integrator", "sim"])
def test_in_one_process(tmp_path, backend):
    path = tmp_path / "mission.yaml"
    path.write_text(write(tmp_path, backend))
    result = fly(load_mission(path), visuals=False)
    assert result.success, result.failures
    places = np.stack([result.log.signals[f"sim.{axis}"] for axis in "xyz"], axis=-1)
    gaps = np.linalg.norm(places[:, [0, 0, 1]] - places[:, [1, 2, 2]], axis=-1)
    check(places[..., 2], gaps.min())


def test_as_nodes(tmp_path):
    flight = Flight(tmp_path, write(tmp_path, "sim"), "--processes", "per-drone")
    try:
        flight.begin()
        assert flight.process.wait(PATIENCE) == 0, flight.log.read_text()[-3000:]
    finally:
        flight.close()
    summary = json.loads((flight.out / "summary.json").read_text())
    assert summary["success"]
    with np.load(flight.out / "log.npz") as log:
        heights = log["signal/sim.z"]
    check(heights, min(drone["least_distance_m"] for drone in summary["drones"]))
