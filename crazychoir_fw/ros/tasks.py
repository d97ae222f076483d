"""Tables of work as ROS 2 nodes, and how guidance asks them: dynamic task assignment, pickup and delivery.

The table announces each list on ``/optimization_trigger`` (`std_msgs/Int64`, its label, latched). Each agent requests
its own by the service ``/agent_{i}/task_list``, and reports its next task as completed by the service
``/agent_{i}/task_completion`` (both `std_srvs/Trigger`; the list is JSON in the message). It publishes its plan on
``/agent_{i}/task_report``, and the table publishes events on ``/happenings`` (both `std_msgs/String`, JSON). The report
also carries tasks that were completed after the table had made a newer list.

A table that is restarted continues where the previous one ended. After each change a table publishes its state on
``/table_memory``. The host of the flight repeats that on ``/last_table`` (both `std_msgs/String`, JSON; the latter
latched), and a table that has not begun restores it from there.
"""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from rclpy.context import Context
from rclpy.qos import QoSProfile
from std_msgs.msg import Int64, String
from std_srvs.srv import Trigger

from crazychoir_fw.common.errors import CrazychoirError
from crazychoir_fw.guidance.schemes import tasks as plain
from crazychoir_fw.guidance.schemes.delivery import DeliveryRequest
from crazychoir_fw.guidance.schemes.tasks import DispatchTable, Offer, PositionTask
from crazychoir_fw.ros.guidance_node import GuidanceNode
from crazychoir_fw.ros.names import LAST_BUTTON, LATEST, START
from crazychoir_fw.ros.node import LayerNode

TRIGGER = "/optimization_trigger"
HAPPENINGS = "/happenings"
MEMORY = "/table_memory"
LAST_TABLE = "/last_table"
LIST = "task_list"
COMPLETION = "task_completion"
REPORT = "task_report"
DONE = "done"
"""Only key of a report: number of a task that was completed after the table had made a newer list."""

EVERYTHING = QoSProfile(depth=1000)
"""Deep enough that messages do not drop out of the queue."""

_KINDS = {kind.__name__: kind for kind in (PositionTask, DeliveryRequest)}
_EARLY = "nothing is known to be next"
_RETRY_S = 0.1
_LARGEST = 1_000_000  # letters of a message


def offer_to_text(offer: Offer) -> str:
    """Return an offer as JSON."""
    items = [{"kind": type(item).__name__, **dataclasses.asdict(item)} for item in offer.items]
    return json.dumps({"label": offer.label, "items": items})


def text_to_offer(text: str) -> Offer:
    """Return the offer that a text holds.

    Raises:
        CrazychoirError: If it holds none.
    """
    try:
        data = _mapping(text)
        items = []
        for entry in data["items"]:
            kind = _KINDS[entry.pop("kind")]
            items.append(kind(**{key: tuple(v) if isinstance(v, list) else v for key, v in entry.items()}))
        return Offer(int(data["label"]), tuple(items))
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise CrazychoirError(f"list of tasks: it cannot be read: {error}") from None


def _mapping(text: str) -> dict[str, Any]:
    data = json.loads(text) if len(text) <= _LARGEST else None
    if not isinstance(data, dict):
        raise ValueError("allowed: a mapping")
    return data


class TaskTable(LayerNode):
    """A table of work as a node; the first ``/experiment_trigger`` starts it."""

    def __init__(
        self,
        table: DispatchTable,
        *,
        frequency: float = 50.0,
        parameters: Mapping[str, Any] | None = None,
        context: Context | None = None,
    ) -> None:
        """Make the node.

        Args:
            table: The table.
            frequency: How often it looks at the time (Hz).
            parameters: Values of parameters.
            context: Context of rclpy.
        """
        super().__init__("task_table", parameters=parameters, context=context, swarm_wide=True)
        self.table = table
        table.note = self._note
        self._trigger = self.create_publisher(Int64, TRIGGER, LATEST)
        self._happenings = self.create_publisher(String, HAPPENINGS, EVERYTHING)
        self._before: str | None = None
        self._has_missed_start = False
        self._memory = self.create_publisher(String, MEMORY, LATEST)
        table.listen(self._announce)
        self.create_subscription(String, LAST_TABLE, self._take_last_table, LATEST)
        for where in (f"/{LAST_BUTTON}", *(self.topic_of(i, LAST_BUTTON) for i in range(table.agents))):
            self.create_subscription(String, where, self._take_last_button, LATEST)
        self._next: dict[int, list[int]] = {i: [] for i in range(table.agents)}
        for i in range(table.agents):
            self.create_service(Trigger, self.topic_of(i, LIST), self._list_of(i))
            self.create_service(Trigger, self.topic_of(i, COMPLETION), self._completion_of(i))
            self.create_subscription(String, self.topic_of(i, REPORT), self._report_of(i), EVERYTHING)
            self.listen(START, self._start, self.topic_of(i, START.name.lstrip("/")))
        self.listen(START, self._start)
        self.every(frequency, self._step)

    def _start(self, _: Any) -> None:
        self.table.start(self.now())

    def _announce(self, label: int) -> None:
        # save the state before agents receive the list, so that a restarted table has it, too
        self._remember()
        self._trigger.publish(Int64(data=label))

    def _remember(self) -> None:
        self._memory.publish(String(data=json.dumps(self.table.memory())))

    def _take_last_table(self, message: String) -> None:
        """Store the last state of a previous table until the next step, which has the time."""
        self._before = message.data

    def _take_last_button(self, message: String) -> None:
        """Note a start before this node existed, so that a table started in mid-flight joins it."""
        self._has_missed_start |= message.data == "start"

    def _step(self, now: float) -> None:
        if self._before is not None:
            self._go_on(self._before, now)
            self._before = None
        if self._has_missed_start:
            self.table.start(now)
        self.table.step(now)

    def _go_on(self, before: str, now: float) -> None:
        """Restore the state of a table that has ended, unless this one has a list already."""
        if self.table.label:
            return
        try:
            self.table.remember(_mapping(before), now)
        except (ValueError, CrazychoirError) as error:
            self.get_logger().warning(f"{LAST_TABLE}: {error}")
            return
        self.get_logger().info(f"goes on with list {self.table.label}")

    def _note(self, kind: str, agent: int | None, details: Mapping[str, Any]) -> None:
        self._happenings.publish(String(data=json.dumps({"kind": kind, "agent": agent, "details": details})))

    def _list_of(self, agent: int) -> Callable[[Any, Any], Any]:
        def answer(_: Any, response: Any) -> Any:
            def give(offer: Offer) -> None:
                self._next[agent] = []
                response.success, response.message = True, offer_to_text(offer)

            self.table.request(agent, give)
            return response

        return answer

    def _completion_of(self, agent: int) -> Callable[[Any, Any], Any]:
        def answer(_: Any, response: Any) -> Any:
            if not self._next[agent]:
                response.message = _EARLY
                return response
            response.success = self.table.complete(agent, self._next[agent].pop(0))
            self._remember()
            return response

        return answer

    def _report_of(self, agent: int) -> Callable[[Any], None]:
        def take(message: String) -> None:
            try:
                decision = _mapping(message.data)
                if DONE in decision:
                    done = int(decision[DONE])
                    self._next[agent] = [number for number in self._next[agent] if number != done]
                    self.table.complete(agent, done)
                    self._remember()
                    return
                upcoming = [int(number) for number in decision["next"]]
                takes = [int(number) for number in decision["takes"]]
            except (ValueError, KeyError, TypeError) as error:
                self.get_logger().warning(f"{self.topic_of(agent, REPORT)}: {error}", throttle_duration_sec=1.0)
                return
            self._next[agent] = upcoming
            self.table.report(agent, {**decision, "takes": takes})

        return take


class PositionTaskTable(TaskTable):
    """The table of random points of the original (docs/reference/crazychoir.md#17.5)."""

    def __init__(self, N: int | None = None, *, context: Context | None = None, **options: Any) -> None:
        """Make the node.

        Args:
            N: Number of agents, and of tasks.
            context: Context of rclpy.
            options: Of `crazychoir_fw.guidance.schemes.PositionTaskTable`.
        """
        super().__init__(plain.PositionTaskTable(N or 1, **options), context=context)


class TableDesk:
    """A table in another process, for the guidance of a node. No call blocks."""

    def __init__(self, node: GuidanceNode) -> None:
        """Find the table by topics and services of a node."""
        self._node = node
        self._list = node.create_client(Trigger, LIST)
        self._completion = node.create_client(Trigger, COMPLETION)
        self._report = node.create_publisher(String, REPORT, EVERYTHING)
        self._upcoming: list[int] = []  # as it was reported

    def listen(self, callback: Callable[[int], None]) -> None:
        """Call `callback(label)` at each new list."""
        self._node.create_subscription(Int64, TRIGGER, lambda message: callback(int(message.data)), LATEST)

    def request(self, agent: int, callback: Callable[[Offer], None]) -> None:
        """Request the list; without a response the guidance has to retry."""
        del agent
        if not self._list.service_is_ready():
            return

        def take(future: Any) -> None:
            response = future.result()
            if response is not None and response.success:
                try:
                    callback(text_to_offer(response.message))
                except CrazychoirError as error:
                    self._node.get_logger().warning(str(error))

        self._list.call_async(Trigger.Request()).add_done_callback(take)

    def report(self, agent: int, decision: Mapping[str, Any]) -> None:
        """Publish the plan of the agent."""
        del agent
        self._upcoming = list(decision.get("next", ()))
        self._report.publish(String(data=json.dumps(decision, default=_plain)))

    def complete(self, agent: int, number: int) -> None:
        """Report the next task as completed; retried until the table has received the plan."""

        def take(future: Any) -> None:
            response = future.result()
            if response is None or response.success or response.message != _EARLY:
                if self._upcoming[:1] == [number]:
                    del self._upcoming[0]
            else:
                self._later(lambda: self.complete(agent, number))

        if number not in self._upcoming:
            # a newer list was made before the table knew of this completion: tell it, so that the task is not repeated
            self._report.publish(String(data=json.dumps({DONE: number})))
            return
        if self._upcoming[0] != number or not self._completion.service_is_ready():
            self._later(lambda: self.complete(agent, number))
            return
        self._completion.call_async(Trigger.Request()).add_done_callback(take)

    def _later(self, work: Callable[[], None]) -> None:
        timer: list[Any] = []

        def once() -> None:
            self._node.destroy_timer(timer[0])
            work()

        timer.append(self._node.create_timer(_RETRY_S, once))


def _plain(value: Any) -> Any:
    if isinstance(value, np.generic):
        return value.item()
    raise TypeError(f"{type(value).__name__} cannot be told")
