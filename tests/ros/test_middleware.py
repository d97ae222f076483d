"""The settings of the middleware: this machine only and no shared memory, unless the user says otherwise."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from std_msgs.msg import String

import crazychoir_fw.ros
from crazychoir_fw.ros.middleware import stay_on_this_machine
from crazychoir_fw.ros.names import LATEST

RANGE = "ROS_AUTOMATIC_DISCOVERY_RANGE"
PROFILES = "FASTRTPS_DEFAULT_PROFILES_FILE"
LOOPBACK = str(Path(crazychoir_fw.ros.__file__).with_name("loopback.xml"))
OURS = {RANGE: "SUBNET", PROFILES: LOOPBACK}


@pytest.mark.parametrize(
    ("chosen", "told"),
    [
        ({}, OURS),
        ({"ROS_DISTRO": "jazzy", "RMW_IMPLEMENTATION": "rmw_fastrtps_dynamic_cpp"}, OURS),
        ({"ROS_DISTRO": "kilted"}, {RANGE: "LOCALHOST"}),
        ({"RMW_IMPLEMENTATION": "rmw_cyclonedds_cpp"}, {RANGE: "LOCALHOST"}),
        ({PROFILES: "mine.xml"}, {RANGE: "LOCALHOST"}),
        ({"FASTDDS_DEFAULT_PROFILES_FILE": "mine.xml"}, {RANGE: "LOCALHOST"}),
        ({RANGE: "SUBNET"}, {}),
        ({RANGE: "LOCALHOST", PROFILES: "mine.xml"}, {}),
        (OURS, {}),
    ],
)
def test_what_the_user_has_chosen_is_left_alone(chosen, told):
    environment = dict(chosen)
    stay_on_this_machine(environment)
    assert environment == {**chosen, **told}


CHILD = """
import os, sys, rclpy
{told}
from std_msgs.msg import String
from rclpy.qos import DurabilityPolicy, QoSProfile
rclpy.init()
node = rclpy.create_node("child")
publisher = node.create_publisher(String, "/words", QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL))
publisher.publish(String(data="heard"))
ours = [os.readlink(f"/proc/self/fd/{{number}}") for number in os.listdir("/proc/self/fd")
        if os.path.exists(f"/proc/self/fd/{{number}}")]
rows = [line.split() for line in list(open("/proc/net/udp"))[1:]]
print(*{{row[1].partition(":")[0] for row in rows if f"socket:[{{row[9]}}]" in ours}}, flush=True)
sys.stdin.read()
"""
US, SOMEBODY_ELSE = "import crazychoir_fw.ros", ""


@pytest.fixture
def child():
    """Starts a node in a process of its own, whose environment says nothing; returns the process."""
    started = []

    def start(told):
        environment = {name: value for name, value in os.environ.items() if name not in OURS}
        process = subprocess.Popen(
            [sys.executable, "-c", CHILD.format(told=told)],
            env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
        )  # fmt: skip
        started.append(process)
        return process

    yield start
    for process in started:
        process.communicate(timeout=60.0)


@pytest.mark.skipif(not Path("/proc/net/udp").is_file(), reason="only Linux shows who listens where")
def test_nobody_listens_to_other_machines(child):
    # hexadecimal, the last byte first: 127.0.0.1, and the group of discovery, 239.255.0.1
    assert set(child(US).stdout.readline().split()) == {"0100007F", "0100FFEF"}
    assert "00000000" in child(SOMEBODY_ELSE).stdout.readline().split()


@pytest.mark.parametrize("told", [US, SOMEBODY_ELSE], ids=["us", "somebody else"])
def test_others_on_this_machine_find_us(bench, child, told):
    heard = []
    bench.user.create_subscription(String, "/words", heard.append, LATEST)
    child(told)
    bench.until(lambda: heard)
    assert heard[0].data == "heard"
