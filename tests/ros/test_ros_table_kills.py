"""A table whose process is killed in the middle of a flight, and started again: all of its tasks get done."""

import json
import os
import signal

import pytest
from ros_flights import PATIENCE, Flight
from std_msgs.msg import String

from crazychoir_fw.ros.tasks import EVERYTHING, HAPPENINGS

COMMON = """
backend: integrator
log_rate: 50
drones:
  - {{id: agent_0, position: [0.0, 0.0]}}
  - {{id: agent_1, position: [1.0, 0.0]}}
layers:
  rate: 50
  communication: {{graph: complete, deadline_s: 0.2}}
{layers}
flight:
  - takeoff: {{duration: 1.5}}
  - start: {{duration: {start}}}
  - land: {{duration: 1.5}}
criteria: {{tasks_completed: {count}, min_distance_m: 0.0}}
"""

TASKS = """
  guidance: {class: TaskGuidance, height: 0.4, options: {max_iterations: 10, speed: 1.0}}
  tasks: {seed: 4, low: [-0.5, -0.5], high: [1.5, 0.5], probability: 1.0, generations: 4}
"""

DELIVERIES = """
  guidance: {class: DeliveryGuidance, height: 0.4, options: {capacity: 1, speed: 0.8, dwell: 0.2}}
  delivery:
    requests:
      - {pickup: [0.0, 0.5], delivery: [0.5, 0.5]}
      - {pickup: [1.0, -0.5], delivery: [0.5, -0.5]}
      - {pickup: [0.0, -0.5], delivery: [0.0, 0.8], at: 3.0}
"""

# much longer than the tasks take: time goes on while the table starts again, which takes a busy machine up to 20 s
MISSIONS = {
    "tasks": COMMON.format(layers=TASKS, start=40.0, count=5),
    "deliveries": COMMON.format(layers=DELIVERIES, start=50.0, count=3),
}
"""The second is flown with ``CRAZYCHOIR_ALL_FLIGHTS=1`` only."""


@pytest.mark.parametrize("kind", MISSIONS if os.environ.get("CRAZYCHOIR_ALL_FLIGHTS") else ["tasks"])
def test_a_table_that_is_killed_and_started_again_gives_out_all_of_its_tasks(kind, tmp_path):
    flight = Flight(tmp_path, MISSIONS[kind], "--processes", "per-drone", "--restart", "--pace", "1.0")
    try:
        happened = []
        flight.node.create_subscription(
            String, HAPPENINGS, lambda message: happened.append(json.loads(message.data)["kind"]), EVERYTHING
        )
        flight.until(lambda: "assigned" in happened, "tasks are shared out")
        first = flight.numbers()["table"]
        os.kill(first, signal.SIGKILL)
        flight.until(lambda: flight.numbers()["table"] != first, "it is started again")
        code = flight.process.wait(PATIENCE)
        summary = json.loads((flight.out / "summary.json").read_text())
    finally:
        flight.close()
    events = [event["kind"] for event in summary["events"]]
    assert events.count("ended") == 1
    assert code == 0, summary["failures"]
