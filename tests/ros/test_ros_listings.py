"""The listings of the paper run as printed, but for the lines that import."""

import subprocess
import sys

import pytest

SPIN = """
import rclpy
from rclpy.executors import ExternalShutdownException
{listing}
# within the executor: elsewhere it could come between a publisher and its message
node.create_timer(1.0, rclpy.shutdown)
try:
    rclpy.spin(node)
except ExternalShutdownException:
    pass
print("spun", node.get_fully_qualified_name())
"""

CONTROLLER = """
from crazychoir_fw.ros import AccelerationTraj, FlatnessAccelerationCtrl, FPQRSender, GeometryAttitudeCtrl
from crazychoir_fw.ros import HierarchicalController
rclpy.init()
node = HierarchicalController(
    pos_strategy=FlatnessAccelerationCtrl(),
    attitude_strategy=GeometryAttitudeCtrl(),
    command_sender=FPQRSender(),
    traj_handler=AccelerationTraj(),
)
"""

GUIDANCE = """
from crazychoir_fw.ros import BearingFormation
rclpy.init()
node = BearingFormation(update_frequency=100.0, pose_handler='pubsub', pose_topic='odom')
"""

DISTANCES = """
from crazychoir_fw.ros import FormationControlGuidance
rclpy.init()
node = FormationControlGuidance(update_frequency=50.0, law={'k': 0.3})
"""

TIME_VARYING = """
from crazychoir_fw.ros import TimeVaryingContainmentGuidance
rclpy.init()
node = TimeVaryingContainmentGuidance(update_frequency=50.0)
"""

PREDICTIVE = """
from crazychoir_fw.ros import MPCGuidance
rclpy.init()
node = MPCGuidance(1.0, 50.0, law={'coupling': 2.0})
"""

INTEGRATOR = """
from crazychoir_fw.ros import CrazyflieIntegrator
rclpy.init()
node = CrazyflieIntegrator(integration_freq=100)
"""

# agent 0 is seen along x: 3 rows of 3 N numbers, those of the agent itself are zero
PROJECTION = [0.0, 0.0, 0.0, *[0.0] * 3, 0.0, 1.0, 0.0, *[0.0] * 3, 0.0, 0.0, 1.0, *[0.0] * 3]
NEIGHBOR = ["-p", "N:=2", "-p", "in_neigh:=[0]", "-p", "out_neigh:=[0]"]
FORMATION = [*NEIGHBOR, "-p", f"ort_proj:={PROJECTION}"]


@pytest.mark.parametrize(
    ("listing", "arguments", "name"),
    [
        (CONTROLLER, [], "/agent_1/controller"),
        (GUIDANCE, FORMATION, "/agent_1/guidance"),
        (DISTANCES, [*NEIGHBOR, "-p", "weights:=[1.0, 0.0]"], "/agent_1/guidance"),
        (TIME_VARYING, [*NEIGHBOR, "-p", "seed:=3"], "/agent_1/guidance"),
        (PREDICTIVE, NEIGHBOR, "/agent_1/guidance"),
        (INTEGRATOR, ["-p", "init_pos:=[0.0, 0.0, 1.0]"], "/agent_1/integrator"),
    ],
)
def test_a_listing_runs(listing, arguments, name):
    program = SPIN.format(listing=listing)
    command = [sys.executable, "-c", program, "--ros-args", "-r", "__ns:=/agent_1", "-p", "agent_id:=1", *arguments]
    run = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert run.returncode == 0, run.stderr
    assert run.stdout.strip() == f"spun {name}"
