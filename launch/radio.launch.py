"""Drones over one Crazyradio: ``ros2 launch crazychoir_fw radio.launch.py uris:=radio://0/80/2M/E7E7E7E701,…``."""

import json

from launch.actions import DeclareLaunchArgument, ExecuteProcess, OpaqueFunction
from launch.substitutions import LaunchConfiguration

from launch import LaunchDescription


def node(context):
    """Return the radio node of the drones that were named."""
    uris = LaunchConfiguration("uris").perform(context).split(",")
    kind = LaunchConfiguration("kind").perform(context)
    run = (
        f"import rclpy; from crazychoir_fw.ros import RadioHandler{kind}; rclpy.init(); node = RadioHandler{kind}()\n"
        "try: rclpy.spin(node)\nexcept KeyboardInterrupt: pass\nfinally: node.destroy_node()"
    )
    words = ["-p", f"uris:={json.dumps(uris)}", "-p", f"agent_ids:={json.dumps(list(range(len(uris))))}"]
    return [ExecuteProcess(name="radio", cmd=["python3", "-c", run, "--ros-args", *words], output="screen")]


def generate_launch_description():
    """Return what is to be started."""
    return LaunchDescription(
        [
            DeclareLaunchArgument("uris", description="URIs, separated by commas"),
            DeclareLaunchArgument("kind", default_value="FPQR", description="FPQR, FRPY, Vel or XYZ"),
            OpaqueFunction(function=node),
        ]
    )
