"""Goals in the plane."""

import numpy as np
import pytest
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Odometry
from std_msgs.msg import Empty
from trajectory_msgs.msg import JointTrajectory

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import Pose
from crazychoir_fw.ros import PointToPointPlanner_2D
from crazychoir_fw.ros.conversions import pose_to_odometry


def goal(x, y):
    message = PoseStamped()
    message.pose.position.x, message.pose.position.y = x, y
    return message


def test_a_goal_becomes_a_go_to_and_is_reached_once(bench):
    node = bench.make(PointToPointPlanner_2D, agent_id=2)
    points, reached = bench.hear(JointTrajectory, "/agent_2/traj_params"), bench.hear(Empty, "/agent_2/goal_reached")
    goals, poses = bench.speaker(PoseStamped, "/agent_2/goal_pose"), bench.speaker(Odometry, "/agent_2/odom")
    bench.until(lambda: all(node.count_subscribers(f"/agent_2/{name}") for name in ("traj_params", "goal_reached")))
    # a new goal takes the place of the one before
    for place in ((3.0, 3.0), (1.0, -1.0)):
        goals.publish(goal(*place))
    bench.until(lambda: len(points) == 2)
    (point,) = points[-1].points
    # the numbers of docs/reference/crazychoir.md#7 and #24: 0.5 + 0.15 i, 20 s
    np.testing.assert_allclose(point.positions, [1.0, -1.0, 0.8])
    assert point.time_from_start.sec == 20

    def at(x, y):
        poses.publish(pose_to_odometry(Pose(np.array([x, y, 0.8]), np.array([0.0, 0.0, 0.0, 1.0]))))
        bench.drain()

    for place in ((3.0, 3.0), (1.0, -1.051)):
        at(*place)
    assert not reached
    at(1.0, -1.049)
    bench.until(lambda: reached)
    at(1.0, -1.0)
    assert len(reached) == 1


@pytest.mark.parametrize("options", [{"goal_tolerance": 0.0}, {"duration": float("nan")}])
def test_numbers_out_of_range_are_refused(ros_context, options):
    with pytest.raises(RangeError, match=f"{next(iter(options))} is"):
        PointToPointPlanner_2D(agent_id=0, context=ros_context, **options)
