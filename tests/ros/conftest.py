"""Nodes in one process, on a domain of their own, under simulated time that the test makes."""

import os
import shutil
import tempfile
import time
from collections import Counter

import pytest
from ros_domains import reserve_domain

# before anything of ROS reads it: a domain of its own, and no need of a home
os.environ["ROS_DOMAIN_ID"] = str(reserve_domain())
os.environ["ROS_LOG_DIR"] = tempfile.mkdtemp(prefix="ros_logs_")

import rclpy
from rclpy.executors import SingleThreadedExecutor, TimeoutException
from rosgraph_msgs.msg import Clock

from crazychoir_fw.ros.conversions import to_stamp

QUIET = 0.002  # [s], after which nothing more is expected to come
PATIENCE = 120.0  # [s], of the wall clock, for what must come; matters only where it does not


class Bench:
    """Nodes, an executor, a clock, and a user's node that subscribes and publishes."""

    def __init__(self, context):
        self.context = context
        self.executor = SingleThreadedExecutor(context=context)
        self.user = rclpy.create_node("user", context=context)
        self.executor.add_node(self.user)
        self.clock = self.user.create_publisher(Clock, "/clock", 10)
        self.nodes = []

    def add(self, node):
        """Let a node work; returns it."""
        self.executor.add_node(node)
        self.nodes.append(node)
        return node

    def make(self, kind, *args, parameters=None, **options):
        """Add a node of a class, under simulated time."""
        parameters = {"use_sim_time": True, **(parameters or {})}
        return self.add(kind(*args, parameters=parameters, context=self.context, **options))

    def hear(self, kind, topic):
        """Return a list into which the messages of a topic go."""
        heard = []
        self.user.create_subscription(kind, topic, heard.append, 100)
        return heard

    def speaker(self, kind, topic, listeners=1):
        """Return a publisher that is connected."""
        publisher = self.user.create_publisher(kind, topic, 10)
        self.until(lambda: publisher.get_subscription_count() >= listeners)
        return publisher

    def drain(self):
        """Work on whatever is there; errors of callbacks come out."""
        while self._work(QUIET):
            pass

    def until(self, happened, heard=()):
        """Run callbacks until a condition holds; at the timeout the last received messages may show the cause."""
        end = time.monotonic() + PATIENCE
        while not happened():
            assert time.monotonic() < end, f"waited in vain, heard {heard[-5:]}"
            self._work(0.05)

    def at(self, now):
        """Let simulated time be so much (s), and whatever is due then happen."""
        self.until(self.is_connected)
        self.clock.publish(Clock(clock=to_stamp(now)))
        self.until(lambda: all(node.get_clock().now().nanoseconds == round(now * 1e9) for node in self._followers()))
        self.drain()

    def is_connected(self):
        """Return whether all subscriptions here are connected to all publishers here, which takes a moment."""
        everybody = [*self.nodes, self.user]
        heard = Counter(listener.topic_name for node in everybody for listener in node.subscriptions)
        return all(
            speaker.get_subscription_count() >= heard[speaker.topic_name]
            for node in everybody
            for speaker in node.publishers
        )

    def _followers(self):
        return [node for node in self.nodes if node.get_parameter("use_sim_time").value]

    def _work(self, timeout):
        try:
            handler, _, _ = self.executor.wait_for_ready_callbacks(timeout_sec=timeout)
        except TimeoutException:
            return False
        handler()
        if handler.exception() is not None:
            raise handler.exception()
        return True

    def close(self):
        for node in [*self.nodes, self.user]:
            node.destroy_node()
        self.executor.shutdown()


@pytest.fixture(scope="session", autouse=True)
def log_folder():
    """Where ROS writes its logs, until the tests are over."""
    yield os.environ["ROS_LOG_DIR"]
    shutil.rmtree(os.environ["ROS_LOG_DIR"], ignore_errors=True)


@pytest.fixture
def ros_context():
    """A context of rclpy."""
    context = rclpy.Context()
    rclpy.init(context=context, args=[])
    yield context
    if context.ok():
        rclpy.shutdown(context=context)


@pytest.fixture
def bench(ros_context):
    """A bench for nodes."""
    made = Bench(ros_context)
    yield made
    made.close()
