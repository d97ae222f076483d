"""A mission as processes, one per drone and layer: ``ros2 launch crazychoir_fw bearing_formation.launch.py``.

Press the buttons with ``crazychoir ros takeoff``, ``start``, ``land``, ``stop``, or with ``ros2 topic pub``.
"""

from pathlib import Path

from launch.actions import DeclareLaunchArgument, ExecuteProcess, OpaqueFunction
from launch.substitutions import LaunchConfiguration

from crazychoir_fw.mission import load_mission
from crazychoir_fw.ros.parts import parts_of
from launch import LaunchDescription


def processes(context):
    """Return the processes of the mission that was named."""
    mission = LaunchConfiguration("mission").perform(context)
    loaded = load_mission(mission)
    started = [
        ExecuteProcess(
            name="simulation",
            cmd=[*_ROS, "simulation", mission, "--speed", LaunchConfiguration("speed").perform(context)],
            output="screen",
        )
    ]
    for part in parts_of(loaded, LaunchConfiguration("processes").perform(context)):
        words = [word for i in part.agents for word in ("--drone", loaded.fleet[i].id)]
        words += [word for layer in part.layers for word in ("--layer", layer)]
        started.append(
            ExecuteProcess(name=part.name.replace("/", "_"), cmd=[*_ROS, "layers", mission, *words], output="screen")
        )
    return started


_EXAMPLES = Path(__file__).resolve().parents[1] / "examples"  # in the repository, and where it is installed
_ROS = ("python3", "-m", "crazychoir_fw.ros")


def generate_launch_description():
    """Return what is to be started."""
    return LaunchDescription(
        [
            DeclareLaunchArgument(
                "mission",
                default_value=str(_EXAMPLES / "bearing_formation.yaml"),
                description="mission file (YAML)",
            ),
            DeclareLaunchArgument("processes", default_value="per-node", description="per-node, per-drone or one"),
            DeclareLaunchArgument("speed", default_value="1.0", description="simulated seconds per second"),
            OpaqueFunction(function=processes),
        ]
    )
