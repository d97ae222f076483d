"""Arming and rebooting by services: of a host with onboard software, from a terminal and from the page."""

import threading

import pytest
import rclpy
from rclpy.context import Context
from ros_domains import reserve_domain
from typer.testing import CliRunner

from crazychoir_fw.cli import app
from crazychoir_fw.common.errors import StateError, UnknownNameError
from crazychoir_fw.flight.access import Access, open_access
from crazychoir_fw.flight.access.ros import NO_ARM, RosAccess
from crazychoir_fw.flight.agent import Agent, DronePhase
from crazychoir_fw.flight.sim_backend import SimBackend
from crazychoir_fw.mission.loader import parse_mission
from crazychoir_fw.ros.arming_services import ARM, request_once, serve_arming_services, served_on
from crazychoir_fw.ros.joined_drones import JoinedDrones
from crazychoir_fw.ros.node import LayerNode
from crazychoir_fw.ros.process import make_executor
from crazychoir_fw.simulation import DroneConfig, World

MISSION = parse_mission(
    {
        "name": "care",
        "drones": [{"id": "first", "position": [0.0, 0.0]}, {"id": "second", "position": [1.0, 0.0]}],
        "layers": {"guidance": {"class": "SimpleGuidance"}},
        "flight": [{"takeoff": {"duration": 2.0}}],
    }
)


class Host:
    """Serves two drones, of which the second must be armed."""

    def __init__(self):
        drones = [DroneConfig("a", (0.0, 0.0)), DroneConfig("b", (1.0, 0.0), platform="cf21bl")]
        self.world = World(drones, seed=1, visuals=False)
        self.world.run(3.0)
        assert self.world["b"].can_arm
        assert not self.world["b"].can_fly
        backend = SimBackend(self.world, "truth", 50)
        self.agents = [Agent(i, name, None) for i, name in enumerate(backend.names)]
        self.domain = reserve_domain()
        self.context = Context()
        rclpy.init(args=[], context=self.context, domain_id=self.domain)
        self.node = LayerNode("host", swarm_wide=True, context=self.context)
        serve_arming_services(self.node, self.agents, open_access(backend))
        executor = make_executor(self.context)
        executor.add_node(self.node)
        self._ends = threading.Event()
        self._thread = threading.Thread(target=self._spin, args=[executor], daemon=True)
        self._thread.start()

    def _spin(self, executor):
        while not self._ends.is_set():
            executor.spin_once(timeout_sec=0.05)

    def close(self):
        self._ends.set()
        self._thread.join()
        rclpy.try_shutdown(context=self.context)


@pytest.fixture
def host():
    opened = Host()
    yield opened
    opened.close()


def test_one_is_armed_and_disarmed_and_a_wrong_name_is_refused(host):
    drone = host.world["b"]
    assert request_once(ARM, True, ["agent_1"], host.domain) == {"agent_1": "armed"}
    host.world.run(0.1)
    assert drone.can_fly
    with pytest.raises(UnknownNameError, match="there is no drone 'agent_7', allowed: agent_0, agent_1"):
        request_once(ARM, True, ["agent_7"], host.domain)
    runner = CliRunner()
    result = runner.invoke(app, ["ros", "disarm", "--drones", "agent_1", "--domain", str(host.domain)])
    assert (result.exit_code, result.stdout) == (0, "agent_1: disarmed\n")
    host.world.run(0.1)
    assert not drone.can_fly


def test_who_flies_is_not_rebooted_and_the_others_are(host):
    host.agents[0].phase = DronePhase.FLYING
    host.agents[1].phase, host.agents[1].failure = DronePhase.FAILED, "it fell"
    with pytest.raises(StateError, match="agent_0: a flies; LAND or STOP it before REBOOT"):
        request_once("reboot", False, [], host.domain)
    assert host.agents[0].phase is DronePhase.FLYING
    assert (host.agents[1].phase, host.agents[1].failure) == (DronePhase.GROUND, None)
    assert not host.world["b"].can_arm  # its software has just begun


def test_the_page_asks_the_host(host):
    context = Context()
    rclpy.init(args=[], context=context, domain_id=host.domain)
    node = LayerNode("page", swarm_wide=True, context=context)
    executor = make_executor(context)
    executor.add_node(node)

    def spin():
        executor.spin_once(timeout_sec=0.02)

    stopped = []
    access = RosAccess(JoinedDrones(node, MISSION, lambda: None, spin, stopped.extend))
    access.stop_now([1])  # whatever else is under way
    assert stopped == [1]
    for _ in range(500):
        if len(served_on(node, ARM)) == 2:
            break
        spin()
    assert "arm" not in access.missing()
    access.arm(1, True)
    host.world.run(0.1)
    assert host.world["b"].can_fly
    assert access.reboot(1) == "ready in 2 s"
    rclpy.try_shutdown(context=context)


def test_point_masses_are_not_armed():
    class Masses:
        names = ("a",)

    domain = reserve_domain()
    context = Context()
    rclpy.init(args=[], context=context, domain_id=domain)
    node = LayerNode("host", swarm_wide=True, context=context)
    serve_arming_services(node, [Agent(0, "a", None)], Access(Masses()))
    assert served_on(node, ARM) == []
    with pytest.raises(StateError, match="point masses have nothing to arm"):
        RosAccess(JoinedDrones(node, MISSION, lambda: None)).arm(0, True)
    assert "point masses" in NO_ARM
    rclpy.try_shutdown(context=context)
