"""The key `layers` of a mission file, a file per section.

Which classes there are, and what they take, is known to the layers alone; here stands how they are named.
"""

from crazychoir_fw.mission.layers.control import ControlLayer, PlanningLayer
from crazychoir_fw.mission.layers.guidance import GuidanceLayer
from crazychoir_fw.mission.layers.layers import Layers
from crazychoir_fw.mission.layers.safety import SafetyLayer
from crazychoir_fw.mission.layers.tables import DeliveryLayer, TasksLayer

__all__ = [
    "ControlLayer",
    "DeliveryLayer",
    "GuidanceLayer",
    "Layers",
    "PlanningLayer",
    "SafetyLayer",
    "TasksLayer",
]
