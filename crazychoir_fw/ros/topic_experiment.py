"""An experiment that is watched and steered by topics, wherever its layers run: buttons in and out, drones, events."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Sequence
from typing import Any

from rclpy.qos import QoSDurabilityPolicy, QoSProfile
from std_msgs.msg import Empty, String

from crazychoir_fw.common.errors import CrazychoirError
from crazychoir_fw.flight.access import open_access
from crazychoir_fw.flight.experiment import Experiment, Names
from crazychoir_fw.ros.arming_services import serve_arming_services
from crazychoir_fw.ros.drone_states import StateTeller
from crazychoir_fw.ros.names import BUTTONS, LAST_BUTTON, LATEST
from crazychoir_fw.ros.simulation import SimulationNode

READY = "/ready"
"""Topic on which each process announces that it has found its partners."""

_EVERYTHING = QoSProfile(depth=1000, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)
"""Deep enough for messages of all processes at once: none may drop out of the queue."""


class TopicExperiment(Experiment):
    """An experiment with a node: odometry and clock go out with each round, and buttons are topics both ways."""

    no_rewind = "Over ROS 2 time cannot be turned back: whoever listens has heard what was. Without --ros it can."

    def __init__(self, node: SimulationNode, executor: Any, mission: Any, *arguments: Any, **options: Any) -> None:
        """Make an experiment of a mission.

        Args:
            node: Publishes the drones of the backend, and paces the rounds.
            executor: Executor that spins the node.
            mission: The mission.
            arguments: Of `Experiment`: backend, agents, groups, …
            options: Of `Experiment`.
        """
        super().__init__(*arguments, rate=mission.layers.rate, log_rate=mission.log_rate, **options)
        self.node, self._executor, self._mission = node, executor, mission
        executor.add_node(node)
        self.ready: set[str] = set()
        """Processes that have found their partners."""
        self._presses = [0] * len(self.agents)
        self._own_presses: Counter[tuple[str, int | None]] = Counter()
        self._buttons: dict[tuple[str, int | None], Any] = {}
        self._last_buttons: dict[int | None, Any] = {None: node.create_publisher(String, f"/{LAST_BUTTON}", LATEST)}
        numbers = range(len(self.agents))
        for name, topic in BUTTONS.items():
            for i in (None, *numbers):
                where = topic.name if i is None else node.topic_of(i, topic.name.lstrip("/"))
                self._buttons[name, i] = node.announce(topic, where)
                node.listen(topic, lambda _, pressed=name, i=i: self._pressed(pressed, i), where)
        node.create_subscription(String, READY, lambda message: self._is_ready(message.data), _EVERYTHING)

    def _is_ready(self, process: str) -> None:
        self.ready.add(process)

    def wait_for(self, processes: Sequence[str], timeout: float, look: Callable[[], None] = lambda: None) -> list[str]:
        """Wait until processes have found their partners; returns those that have not in time (s, wall).

        Args:
            processes: Their names.
            timeout: How long (s, wall).
            look: Called at least every 50 ms; an error that it raises ends the wait.
        """
        deadline = time.monotonic() + timeout
        while not self.ready.issuperset(processes) and time.monotonic() < deadline:
            self._executor.spin_once(timeout_sec=0.05)
            look()
        return sorted(set(processes) - self.ready)

    def tell_states(self) -> None:
        """Start to publish states and events of the drones, and to serve ``arm`` and ``reboot``."""
        access = open_access(self.backend)
        self._teller = StateTeller(self.node, self, self._mission, access, self._presses.__getitem__)
        serve_arming_services(self.node, self.agents, access)

    def step(self) -> None:
        """Fly one round: publish odometry and clock, receive commands and buttons, carry them out."""
        self.node.exchange(self._executor)
        if not self.node.context.ok():
            raise CrazychoirError("ROS was shut down")
        super().step()

    # ---------------------------------------------------------------- buttons

    def takeoff(self, drones: Names = None) -> None:
        """See `Experiment`."""
        self._press_and_tell("takeoff", drones)

    def start(self, drones: Names = None) -> None:
        """See `Experiment`."""
        self._press_and_tell("start", drones)

    def land(self, drones: Names = None) -> None:
        """See `Experiment`."""
        self._press_and_tell("land", drones)

    def stop(self, drones: Names = None) -> None:
        """See `Experiment`."""
        self._press_and_tell("stop", drones)

    def _press_and_tell(self, button: str, drones: Names) -> None:
        self._carry_out(button, drones)
        chosen = [agent.index for agent in self._chosen(drones)]
        for i in [None] if len(chosen) == len(self.agents) else chosen:
            self._own_presses[button, i] += 1
            self._buttons[button, i].publish(Empty())
            self._keep(button, i)

    def _carry_out(self, button: str, drones: Names) -> None:
        """Carry out a button in the process of the drones."""
        getattr(super(), button)(drones)
        for agent in self._chosen(drones):
            self._presses[agent.index] += 1

    def _keep(self, button: str, drone: int | None) -> None:
        """Publish the latest button, latched, for processes that restart."""
        if drone not in self._last_buttons:
            topic = self.node.topic_of(drone, LAST_BUTTON)
            self._last_buttons[drone] = self.node.create_publisher(String, topic, LATEST)
        self._last_buttons[drone].publish(String(data=button))

    def _pressed(self, button: str, drone: int | None) -> None:
        """Take a button of all drones or of one: an echo of this flight's own press, or one of another node."""
        if self._own_presses[button, drone] > 0:
            self._own_presses[button, drone] -= 1
            return
        self._carry_out(button, None if drone is None else self.agents[drone].name)
        self._keep(button, drone)
