"""Missions flown as processes by the command line, and a node that observes them."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import rclpy
from rclpy.context import Context
from rclpy.node import Node
from ros_domains import reserve_domain
from rosgraph_msgs.msg import Clock
from std_msgs.msg import String

from crazychoir_fw.ros.names import LATEST, qos
from crazychoir_fw.ros.process import make_executor, take_leave
from crazychoir_fw.ros.topic_experiment import READY

ONLOOKER = "onlooker"
PATIENCE = 240.0  # [s], of the wall clock, for what must come


class Flight:
    """A mission flown as processes, and a node that observes it."""

    def __init__(self, folder: Path, mission: str, *options: str, patience: float = 0.5, environment=None):
        self.file = folder / "mission.yaml"
        self.file.write_text(mission)
        self.out = folder / "out"
        self.domain = domain = reserve_domain()
        # long timeouts: no process counts as lost because the machine is busy
        code = (
            "from functools import partial; from crazychoir_fw.cli import app; from crazychoir_fw.ros import manager; "
            f"manager.RosOptions = partial(manager.RosOptions, deadline={PATIENCE}, patience={patience}); "
            # nor does the flight begin before the onlooker sees it
            "from crazychoir_fw.ros.topic_experiment import TopicExperiment as Host; alone = Host.wait_for; "
            f"Host.wait_for = lambda host, names, *rest: alone(host, [*names, {ONLOOKER!r}], *rest); app()"
        )
        command = [sys.executable, "-c", code, "fly", str(self.file), "--ros", "--no-video", "--out", str(self.out)]
        self.log = folder / "log.txt"
        with self.log.open("w") as log:
            command += ["--domain", str(domain), *options]
            self.process = subprocess.Popen(command, stdout=log, stderr=log, env=environment)
        self.context = Context()
        rclpy.init(args=[], context=self.context, domain_id=domain)
        self.node = Node(ONLOOKER, context=self.context)
        self.executor = make_executor(self.context)
        self.executor.add_node(self.node)
        self.time = 0.0
        self._said = None
        self.node.create_subscription(Clock, "/clock", self._take_time, qos(10))

    def _take_time(self, message):
        self.time = message.clock.sec + message.clock.nanosec / 1e9

    def until(self, condition, what):
        """Work until something is so; the flight begins with the first call."""
        self.begin()
        self.see(condition, what)

    def see(self, condition, what):
        """Work until something is so, before the flight begins too."""
        deadline = time.monotonic() + PATIENCE
        while not condition():
            assert time.monotonic() < deadline, f"{what}: not within {PATIENCE} s\n{self.log.read_text()[-3000:]}"
            assert self.process.poll() is None, f"{what}: the flight has ended\n{self.log.read_text()[-3000:]}"
            self.executor.spin_once(timeout_sec=0.05)

    def begin(self):
        """Let the flight begin, now that all is subscribed to that must be heard.

        A packet of discovery that a busy machine drops is sent again three seconds later: short flights are over then.
        """
        if self._said is None:
            listeners = list(self.node.subscriptions)
            self.see(lambda: all(listener.get_publisher_count() for listener in listeners), "the nodes are seen")
            self._said = self.node.create_publisher(String, READY, LATEST)
            self._said.publish(String(data=ONLOOKER))

    def numbers(self):
        """Return the process id of each member."""
        return json.loads((self.out / "processes.json").read_text())

    def close(self):
        """End whatever still runs."""
        take_leave(self.executor, [self.node], self.context)
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
            try:
                self.process.wait(60.0)
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.process.wait()


def is_running(number):
    try:
        os.kill(number, 0)
    except ProcessLookupError:
        return False
    return Path(f"/proc/{number}/stat").read_text().rpartition(")")[2].split()[0] != "Z"


def all_gone(numbers):
    deadline = time.monotonic() + PATIENCE
    while any(map(is_running, numbers)) and time.monotonic() < deadline:
        time.sleep(0.05)
    return not any(map(is_running, numbers))
