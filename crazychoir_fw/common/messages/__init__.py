"""What layers hand to each other: plain data of numpy arrays, which the ROS nodes turn into messages and back.

World frame: x, y level, z up. Body frame: x forward, y left, z up. Quaternions are (x, y, z, w), body to world. Arrays
may have leading dimensions, (..., 3), for several drones at once.
"""

from crazychoir_fw.common.messages.pose import Pose
from crazychoir_fw.common.messages.reference import Reference
from crazychoir_fw.common.messages.trajectory import TrajectoryPoint
from crazychoir_fw.common.messages.twist import Twist

__all__ = ["Pose", "Reference", "TrajectoryPoint", "Twist"]
