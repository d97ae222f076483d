"""Motion capture: what its messages say, velocities from poses, and a simulated system."""

from crazychoir_fw.mocap.decoding import decode_odometry, decode_pose_stamped, decode_vicon_position
from crazychoir_fw.mocap.estimator import Estimator
from crazychoir_fw.mocap.predictor import TIME_CONSTANT, FilteredDerivative, SingleStagePredictor
from crazychoir_fw.mocap.simulated import MocapConfig, SimulatedMocap

__all__ = [
    "TIME_CONSTANT",
    "Estimator",
    "FilteredDerivative",
    "MocapConfig",
    "SimulatedMocap",
    "SingleStagePredictor",
    "decode_odometry",
    "decode_pose_stamped",
    "decode_vicon_position",
]
