"""A law of the user's that raises in its node: the node goes on, its drone lands in order, the others fly on."""

import json

import numpy as np
import pytest
from geometry_msgs.msg import Twist
from ros_flights import PATIENCE, Flight
from std_msgs.msg import String

from crazychoir_fw.common.messages import Pose, Reference
from crazychoir_fw.control import FlatnessPositionCtrl, FPQRSender, GeometryAttitudeCtrl, HierarchicalController
from crazychoir_fw.planning import PositionTraj
from crazychoir_fw.recording.flight_log import FlightLog
from crazychoir_fw.ros.controller import CrazyflieController
from crazychoir_fw.ros.layer_failure import heard_failure
from crazychoir_fw.ros.names import FAILURE

LAWS = """
from crazychoir_fw.control import FlatnessPositionCtrl
from crazychoir_fw.guidance import SimpleGuidance

class Guidance(SimpleGuidance):
    def step(self, now):
        if self.agent_id == 0 and self.current_pose.position[2] > 0.9:
            raise ValueError("lost my way")
        return super().step(now)

class Control(FlatnessPositionCtrl):
    def control(self, current_pose, desired_reference):
        if current_pose.position[2] > 0.9 and current_pose.position[0] < 0.5:
            raise ValueError("lost my way")
        return super().control(current_pose, desired_reference)
"""
MISSION = """
backend: {backend}
seed: 1
log_rate: 50
drones: [{{id: agent_0, position: [0, 0]}}, {{id: agent_1, position: [1, 0]}}]
layers:
  rate: 50
  odometry: truth
  guidance: {{class: "{guidance}", height: 1.0}}
  planning: {{class: Spline}}
  control: {{position: "{position}", gains: mujoco}}
flight: [{{takeoff: {{duration: 4}}}}, {{land: {{duration: 3}}}}]
"""


@pytest.mark.parametrize(
    ("backend", "guidance", "position", "line"),
    [
        ("sim", "mine.py:Guidance", "FlatnessPositionCtrl", 8),
        ("integrator", "SimpleGuidance", "mine.py:Control", 14),
    ],
)
def test_its_drone_lands_and_the_other_flies_on(tmp_path, backend, guidance, position, line):
    (tmp_path / "mine.py").write_text(LAWS)
    flight = Flight(
        tmp_path,
        MISSION.format(backend=backend, guidance=guidance, position=position),
        "--processes",
        "per-node",
    )
    try:
        flight.begin()
        code = flight.process.wait(PATIENCE)
    finally:
        flight.close()
    said = flight.log.read_text()
    assert code == 1 and "Traceback" not in said and "ended with code" not in said, said[-3000:]
    summary = json.loads((flight.out / "summary.json").read_text())
    assert [drone["phase"] for drone in summary["drones"]] == ["failed", "landed"]
    (told,) = (failure for failure in summary["failures"] if "ValueError" in failure)
    assert told.startswith("agent_0: ") and f"ValueError: lost my way (mine.py:{line})" in told
    log = FlightLog.load(flight.out / "log.npz")
    z, vz = log.signals["sim.z"], log.signals["sim.vz"]
    assert (z.max(axis=0) > 0.85).all() and (z[-1] < 0.06).all()
    assert vz.min() > -1.0  # a fall from 1 m ends with 4.4 m/s


class Raises(FlatnessPositionCtrl):
    def control(self, current_pose, desired_reference):
        raise SystemExit("no idea")


def test_a_controller_node_that_stands_alone_says_so_and_goes_on(bench):
    controller = HierarchicalController(Raises(), GeometryAttitudeCtrl(), FPQRSender(), PositionTraj())
    node = bench.make(CrazyflieController, controller=controller, agent_id=3)
    heard, commands = bench.hear(String, f"/agent_3/{FAILURE}"), bench.hear(Twist, "/agent_3/cmd_vel")
    bench.until(bench.is_connected)

    def fly(now):
        node.take_pose(Pose(np.array([0.0, 0.0, 1.0]), np.array([0.0, 0, 0, 1]), np.zeros(3), np.zeros(3), time=now))
        node.controller.set_reference(Reference(position=np.zeros(3)))
        node._work(now)

    for k in range(5):
        fly(0.01 * k)
    bench.until(lambda: heard)
    for k in range(5, 10):
        fly(0.01 * k)
    bench.drain()
    name, reason = heard_failure(heard[0])
    assert name == "controller" and reason.startswith("HierarchicalController: SystemExit: no idea (test_ros_law")
    assert len(heard) == 1 and not commands


@pytest.mark.parametrize("data", ["", "[]", "{}", '{"node": 1}', "a\x1b[31m\nb", "[" * 5000])
def test_whatever_comes_on_its_topic_is_one_printable_line(data):
    _, reason = heard_failure(String(data=data))
    assert reason.isprintable() and len(reason) <= 300
