"""Cooperative decisions: what each drone asks for, from what it and its neighbors know.

Plain objects without ROS and without a clock: every method that needs the time takes `now` (s).
"""

from crazychoir_fw.guidance.bearing_formation import BearingFormation
from crazychoir_fw.guidance.cf_guidance import CFGuidance, Phase
from crazychoir_fw.guidance.communicator import TopicCommunicator
from crazychoir_fw.guidance.communicator_interface import Communicator, Statistics
from crazychoir_fw.guidance.communicator_kinds import (
    BestEffortCommunicator,
    StaticCommunicator,
    TimeVaryingCommunicator,
)
from crazychoir_fw.guidance.containment import (
    Containment,
    ContainmentGuidance,
    TimeVaryingContainment,
    TimeVaryingContainmentGuidance,
)
from crazychoir_fw.guidance.distance_formation import FormationControl, FormationControlGuidance
from crazychoir_fw.guidance.distributed_feedback import CFDistributedFeedback
from crazychoir_fw.guidance.disturbance import DisturbedTransport
from crazychoir_fw.guidance.gains import FORMATION_GAINS, FormationGains
from crazychoir_fw.guidance.graph import (
    Graph,
    NeighborSchedule,
    RandomEdges,
    SeveralSchedules,
    TimedGraphs,
    WithinDistance,
)
from crazychoir_fw.guidance.group import GuidanceGroup
from crazychoir_fw.guidance.law import LawContext, Needs, NodeFace, Option, option
from crazychoir_fw.guidance.metrics import Flown, Metrics, Verdict, criterion
from crazychoir_fw.guidance.outputs import Outputs
from crazychoir_fw.guidance.round_guidance import RoundGuidance
from crazychoir_fw.guidance.simple import GoToGuidance, SimpleDIControl, SimpleGuidance, TargetListGuidance
from crazychoir_fw.guidance.transport import InProcessTransport, Transport
from crazychoir_fw.guidance.velocity_feedback import DistributedControlGuidance, VelocityFeedback

__all__ = [
    "FORMATION_GAINS",
    "BearingFormation",
    "BestEffortCommunicator",
    "CFDistributedFeedback",
    "CFGuidance",
    "Communicator",
    "Containment",
    "ContainmentGuidance",
    "DistributedControlGuidance",
    "DisturbedTransport",
    "Flown",
    "FormationControl",
    "FormationControlGuidance",
    "FormationGains",
    "GoToGuidance",
    "Graph",
    "GuidanceGroup",
    "InProcessTransport",
    "LawContext",
    "Metrics",
    "Needs",
    "NeighborSchedule",
    "NodeFace",
    "Option",
    "Outputs",
    "Phase",
    "RandomEdges",
    "RoundGuidance",
    "SeveralSchedules",
    "SimpleDIControl",
    "SimpleGuidance",
    "StaticCommunicator",
    "Statistics",
    "TargetListGuidance",
    "TimeVaryingCommunicator",
    "TimeVaryingContainment",
    "TimeVaryingContainmentGuidance",
    "TimedGraphs",
    "TopicCommunicator",
    "Transport",
    "VelocityFeedback",
    "Verdict",
    "WithinDistance",
    "criterion",
    "option",
]
