"""ROS 2 nodes: thin adapters with the class names and keyword arguments of the paper around the plain layers.

This is the only package that imports rclpy. Install it with ``pip install 'crazychoir-fw[ros]'``, or source an
installation of ROS 2.
"""

from importlib import import_module
from typing import Any

from crazychoir_fw.common.errors import MissingLibraryError
from crazychoir_fw.ros.middleware import stay_on_this_machine

stay_on_this_machine()

try:
    import rclpy  # noqa: F401
except ModuleNotFoundError as error:
    raise MissingLibraryError(
        f"crazychoir_fw.ros needs {error.name}, which is not installed: run pip install 'crazychoir-fw[ros]', "
        "or source an installation of ROS 2"
    ) from error

# Nodes under the names of the paper, and the strategies that its listings pass to them. The import is deferred
# to first use, so that a process imports only modules that it uses.
_NAMES_IN = {
    "crazychoir_fw.control": (
        "AttitudeControl AttitudeCtrlStrategy FPQRSender FRPYSender FlatnessAccelerationCtrl FlatnessPositionCtrl "
        "GeometryAttitudeCtrl PositionControl PositionCtrlStrategy SafeFlatnessAccelerationCtrl "
        "SafeFlatnessPositionCtrl SenderStrategy VelSender VelocityCtrlStrategy"
    ),
    "crazychoir_fw.control.safety": "DoubleIntegratorCBF SingleIntegratorCBF",
    "crazychoir_fw.mocap": "Estimator MocapConfig",
    "crazychoir_fw.planning": "AccelerationTraj FullStateTraj PositionTraj TrajHandlerStrategy",
    "crazychoir_fw.ros.buttons": "Buttons",
    "crazychoir_fw.ros.controller": "CrazyflieController HierarchicalController VelocityController",
    "crazychoir_fw.ros.neighbor_sensing": "ClosestRobotGetter",
    "crazychoir_fw.ros.integrator": "CrazyflieIntegrator",
    "crazychoir_fw.ros.mocap": "MocapOdometry MocapSimulator",
    "crazychoir_fw.ros.node": "LayerNode",
    "crazychoir_fw.ros.planner": "PointToPointPlanner_2D",
    "crazychoir_fw.ros.pose_sources": "pose_subscribe",
    "crazychoir_fw.ros.radio": (
        "RadioHandler RadioHandlerFPQR RadioHandlerFRPY RadioHandlerVel RadioHandlerVelLightHouse RadioHandlerXYZ "
        "RadioHandlerXYZLightHouse"
    ),
    "crazychoir_fw.ros.safety": (
        "CollisionAvoidance DoubleIntegratorCollisionAvoidance SafeHierarchicalController "
        "SingleIntegratorCollisionAvoidance UnicycleCollisionAvoidance"
    ),
    "crazychoir_fw.ros.simulation": "Pace SimulationNode",
    "crazychoir_fw.ros.trajectory": (
        "AccelerationTrajHandler FullStateTrajHandler MinimumSnap Polynomial7th Spline SplinePosition TrajectoryHandler"
    ),
    "crazychoir_fw.ros.visualizer": "SimpleVisualizer Visualizer rviz_config",
}
_MODULE_OF = {name: module for module, names in _NAMES_IN.items() for name in names.split()}

__all__ = sorted(_MODULE_OF)


def __getattr__(name: str) -> Any:
    if name not in _MODULE_OF and not name[:1].isupper():
        raise AttributeError(f"module 'crazychoir_fw.ros' has no attribute {name!r}")
    # a class that is none of these is the node of a guidance law, if anything
    value = getattr(import_module(_MODULE_OF.get(name, "crazychoir_fw.ros.guidance")), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    from crazychoir_fw.mission.registry import our_names

    return sorted({*globals(), *_MODULE_OF, *our_names("guidance")})
