"""Tables of tasks as nodes: services, announcements, status messages, and a table that restarts."""

import json

import numpy as np
import pytest
import rclpy
from nav_msgs.msg import Odometry
from std_msgs.msg import Empty, Int64, String
from std_srvs.srv import Trigger

from crazychoir_fw.common.errors import CrazychoirError
from crazychoir_fw.common.messages import Pose
from crazychoir_fw.guidance.schemes import PositionTaskTable
from crazychoir_fw.guidance.schemes.delivery import DeliveryRequest
from crazychoir_fw.guidance.schemes.tasks import Offer, PositionTask
from crazychoir_fw.ros import TaskGuidance, tasks
from crazychoir_fw.ros.conversions import pose_to_odometry, to_stamp
from crazychoir_fw.ros.names import LATEST
from crazychoir_fw.ros.tasks import TableDesk, TaskTable, offer_to_text, text_to_offer


class Customer:
    """Asks a table as an agent does."""

    def __init__(self, bench, agent):
        self.bench = bench
        self.list = bench.user.create_client(Trigger, f"/agent_{agent}/{tasks.LIST}")
        self.completion = bench.user.create_client(Trigger, f"/agent_{agent}/{tasks.COMPLETION}")
        self.reports = bench.user.create_publisher(String, f"/agent_{agent}/{tasks.REPORT}", tasks.EVERYTHING)
        bench.until(lambda: self.list.service_is_ready() and self.completion.service_is_ready())
        bench.until(lambda: self.reports.get_subscription_count())

    def call(self, client):
        future = client.call_async(Trigger.Request())
        self.bench.until(future.done)
        return future.result()

    def ask(self):
        answer = self.call(self.list)
        return text_to_offer(answer.message) if answer.success else None

    def report(self, label, *numbers):
        told = {"label": label, "takes": list(numbers), "next": list(numbers)}
        self.reports.publish(String(data=json.dumps(told)))
        self.bench.drain()


def make_table(bench, agents=1, **options):
    options = {"probability": 1.0, "start_delay": 0.0, "generations": 3, **options}
    return bench.make(TaskTable, PositionTaskTable(agents, **options))


def kinds(events):
    return [json.loads(message.data)["kind"] for message in events]


def begun(bench, **options):
    """Return a node whose first list is out, labels heard, and what happened."""
    node = make_table(bench, **options)
    labels, events = bench.hear(Int64, tasks.TRIGGER), bench.hear(String, tasks.HAPPENINGS)
    start = bench.speaker(Empty, "/experiment_trigger")
    bench.at(1.0)
    assert not labels
    start.publish(Empty())
    bench.until(lambda: node.table._begins is not None)
    bench.at(1.1)
    bench.until(lambda: labels and events)
    return node, labels, events


def test_the_first_trigger_announces_the_first_list(bench):
    node, labels, events = begun(bench)
    assert [message.data for message in labels] == [1]
    assert kinds(events) == ["tasks"]
    offer = Customer(bench, 0).ask()
    assert offer == Offer(1, tuple(node.table.tasks.values()))


def test_before_the_start_there_is_no_list(bench):
    make_table(bench)
    bench.at(1.0)
    assert Customer(bench, 0).ask() is None


def test_completion_is_of_what_was_reported_to_come_next(bench):
    node, labels, events = begun(bench)
    agent = Customer(bench, 0)
    (task,) = agent.ask().items
    early = agent.call(agent.completion)
    assert (early.success, early.message) == (False, "nothing is known to be next")
    agent.report(1, task.sequence)
    bench.until(lambda: "agreed" in kinds(events))
    assert agent.call(agent.completion).success
    assert node.table.finished == 1
    # the next one is drawn, and announced
    bench.until(lambda: len(labels) == 2 and len(events) == 5)
    assert labels[-1].data == 2
    assert kinds(events) == ["tasks", "assigned", "agreed", "completed", "tasks"]
    assert agent.ask().items[0].sequence == 1


def test_what_was_done_before_a_newer_list_was_made_is_heard_of(bench):
    node, labels, events = begun(bench)
    agent = bench.add(rclpy.create_node("agent", namespace="agent_0", context=bench.context))
    desk, offers = TableDesk(agent), []
    bench.until(lambda: desk._list.service_is_ready() and desk._completion.service_is_ready())
    bench.until(lambda: desk._report.get_subscription_count())
    desk.request(0, offers.append)
    bench.until(lambda: offers)
    (task,) = offers[0].items
    desk.report(0, {"label": 1, "takes": [task.sequence], "next": [task.sequence]})
    bench.until(lambda: "agreed" in kinds(events))
    # it asks for a list, and then arrives
    desk.request(0, offers.append)
    bench.until(lambda: len(offers) == 2)
    assert offers[1].items == (task,)
    desk.complete(0, task.sequence)
    bench.drain()
    assert node.table.finished == 0
    # of that list it takes nothing, since all of it is done
    desk.report(0, {"label": 1, "takes": [], "next": []})
    bench.until(lambda: kinds(events).count("assigned") == 2)
    bench.until(lambda: node.table.finished == 1)
    bench.until(lambda: len(labels) == 2)
    bench.until(lambda: kinds(events).count("completed") == 1)


def test_nothing_is_done_that_is_not_on_the_list(bench):
    node, _, events = begun(bench)
    agent = Customer(bench, 0)
    agent.reports.publish(String(data='{"done": 99}'))
    bench.until(lambda: "refused" in kinds(events))
    assert (node.table.finished, node.table.label) == (0, 1)


@pytest.mark.parametrize(
    "text", ["", "[]", "{}", '{"done": "x"}', '{"next": 3, "takes": []}', '{"next": ["a"], "takes": []}']
)
def test_reports_that_cannot_be_read_are_left_out(bench, text):
    node, _, events = begun(bench)
    agent = Customer(bench, 0)
    agent.reports.publish(String(data=text))
    agent.report(1)
    bench.until(lambda: "assigned" in kinds(events))
    assert kinds(events).count("assigned") == 1
    assert node.table.label == 1


def test_who_does_not_ask_is_told_to_be_gone(bench):
    _, labels, events = begun(bench, agents=2)
    Customer(bench, 0).ask()
    bench.at(2.2)
    bench.until(lambda: "gone" in kinds(events))
    gone = [json.loads(message.data) for message in events if '"gone"' in message.data]
    assert [event["agent"] for event in gone] == [1]
    assert [message.data for message in labels] == [1]


def latch(bench, topic, text):
    bench.user.create_publisher(String, topic, LATEST).publish(String(data=text))


def test_a_table_that_is_started_again_goes_on_with_a_newer_list(bench):
    first, labels, _ = begun(bench)
    memories = bench.hear(String, tasks.MEMORY)
    agent = Customer(bench, 0)
    agent.ask()
    agent.report(1, 0)
    bench.until(lambda: agent.call(agent.completion).success)
    bench.until(lambda: memories and json.loads(memories[-1].data)["finished"] == 1)
    bench.nodes.remove(first)
    first.destroy_node()
    latch(bench, tasks.LAST_TABLE, memories[-1].data)
    latch(bench, "/last_button", "start")
    again = make_table(bench)
    bench.until(lambda: again._before is not None)
    bench.at(20.0)
    bench.until(lambda: labels[-1].data > 2)
    assert again.table.finished == 1
    assert again.table.tasks == first.table.tasks
    # no drone counts as gone because of the time before the restart
    bench.at(20.5)
    assert not again.table.gone
    asked = Customer(bench, 0).ask()
    assert (asked.label, asked.items[0].sequence) == (labels[-1].data, 1)


def test_one_that_missed_the_start_begins_by_itself(bench):
    latch(bench, "/last_button", "start")
    node = make_table(bench)
    bench.until(lambda: node._has_missed_start)
    bench.at(7.0)
    bench.at(7.1)
    assert node.table.label == 1


@pytest.mark.parametrize("text", ["", "[1]", "{}", '{"label": 0, "finished": 0, "gone": []}'])
def test_a_memory_that_is_none_is_left_out(bench, text):
    node = make_table(bench)
    node._go_on(text, 1.0)
    assert node.table.label == 0


@pytest.mark.parametrize(
    "items",
    [
        (PositionTask(0, 3, (1.0, -2.0), (0, 2)),),
        (DeliveryRequest(1, (0.0, 1.0), (2.0, 3.0), 1.5, at=2.0, carrier=4), DeliveryRequest(2, (0, 1), (2, 3))),
        (),
    ],
)
def test_offers_survive_being_text(items):
    assert text_to_offer(offer_to_text(Offer(7, items))) == Offer(7, items)


@pytest.mark.parametrize("text", ["", "3", "{}", '{"label": 1, "items": [{"kind": "Offer"}]}', '{"items": 3}'])
def test_texts_that_are_no_offers_are_refused(text):
    with pytest.raises(CrazychoirError, match="list of tasks"):
        text_to_offer(text)


def test_a_guidance_flies_to_what_the_table_offers_and_completes_it(bench):
    table = make_table(bench, generations=1)
    node = bench.make(
        TaskGuidance,
        agent_id=0,
        law={"takeoff_time": 0.5, "max_iterations": 2, "duration": 0.5},
        parameters={"N": 1, "init_pos": [0.0, 0.0, 0.5]},
    )
    events = bench.hear(String, tasks.HAPPENINGS)
    odom = bench.speaker(Odometry, "/agent_0/odom")
    start = bench.speaker(Empty, "/experiment_trigger", listeners=2)
    place, now = np.array([0.0, 0.0, 0.5]), 1.0

    def is_seen():
        pose = node.guidance.current_pose
        return pose is not None and pose.time >= now - 1e-6

    def fly(seconds):
        nonlocal now
        for _ in range(round(seconds / 0.05)):
            now += 0.05
            message = pose_to_odometry(Pose(place, np.array([0.0, 0.0, 0.0, 1.0]), np.zeros(3), np.zeros(3)))
            message.header.stamp = to_stamp(now)
            odom.publish(message)
            bench.until(is_seen)
            bench.at(now)

    fly(0.1)
    start.publish(Empty())
    bench.until(lambda: table.table._begins is not None)
    fly(3.0)
    assert "assigned" in kinds(events)
    place = np.array([*table.table.tasks[0].position, 0.5])
    fly(0.5)
    bench.until(lambda: "completed" in kinds(events))
    assert table.table.is_done
