"""Host the drones of a mission: ``ros2 launch crazychoir_fw simulation.launch.py mission:=MISSION.yaml``."""

from launch.actions import DeclareLaunchArgument, ExecuteProcess
from launch.substitutions import LaunchConfiguration

from launch import LaunchDescription


def generate_launch_description():
    """Return what is to be started."""
    return LaunchDescription(
        [
            DeclareLaunchArgument("mission", description="mission file with layers (YAML)"),
            DeclareLaunchArgument("speed", default_value="1.0", description="simulated seconds per second"),
            ExecuteProcess(
                cmd=[
                    "python3",
                    *("-m", "crazychoir_fw.ros", "simulation", LaunchConfiguration("mission")),
                    *("--speed", LaunchConfiguration("speed")),
                ],
                output="screen",
            ),
        ]
    )
