"""What becomes of a flight when all layers of one drone are killed in the middle of it, scheme by scheme."""

import json
import os
import signal
from pathlib import Path

import pytest
from ros_flights import PATIENCE, Flight
from std_msgs.msg import Empty

from crazychoir_fw.ros.names import qos

EXAMPLES = Path(__file__).parents[2] / "examples"

START_S = 3.0
BOUND_S = 15.0  # simulated, for the whole flight

MISSION = """
extends: {example}
backend: integrator
criteria: {{min_distance_m: 0.0}}
flight:
  - takeoff: {{duration: 1.5}}
  - start: {{duration: {start}}}
  - land: {{duration: 2.0}}
"""

FAST = [
    ("aggregative", "agent_1"),
    ("mpc", "agent_2"),
    ("task_assignment", "agent_5"),
    ("collision_vel", "agent_1"),
]
"""The killed drone of each example: one scheme of a kind. A follower of a bearing formation is in `test_ros_swarm`."""

ALL = [
    *FAST,
    ("aggregative_lighthouse", "agent_1"),
    ("aggregative_moving_intruders", "agent_1"),
    ("aggregative_moving_intruders", "intruder_0"),
    ("bearing_formation", "agent_0"),  # a leader
    ("bearing_formation", "agent_2"),
    ("bearing_formation", "agent_3"),
    ("collision", "agent_1"),
    ("containment", "agent_0"),  # a leader
    ("containment", "agent_5"),
    ("containment_time_varying", "agent_5"),
    ("distance_formation", "agent_2"),
    ("goto", "agent_1"),
    ("pickup_delivery", "agent_2"),
    ("swap_ten", "agent_3"),
]
"""All examples of several drones with layers: ``CRAZYCHOIR_ALL_FLIGHTS=1 pytest tests/ros/test_ros_kills.py``.

Their delays are in docs/ros.md.
"""

SOONEST_S = 1.0
"""Simulated, within which a loss must be told."""
TOLD_BY = {
    **dict.fromkeys(["task_assignment", "pickup_delivery"], "gone"),
    **dict.fromkeys(["collision", "collision_vel", "goto", "swap_ten"], "held"),
}
"""Kind of event by which others than the supervisor tell: table or host; else neighbors, by ``lost``."""
DELAYS = dict.fromkeys(["task_assignment", "pickup_delivery"], 0.5 + 1.0)
"""Additional delay (s): a table detects a drone that does not request its list, by start delay and deadline."""


@pytest.mark.parametrize(("scheme", "victim"), ALL if os.environ.get("CRAZYCHOIR_ALL_FLIGHTS") else FAST)
def test_one_that_is_killed_is_missed_and_all_land(scheme, victim, tmp_path):
    text = MISSION.format(example=EXAMPLES / f"{scheme}.yaml", start=START_S)
    flight = Flight(tmp_path, text, "--processes", "per-drone", patience=2.0)
    try:
        begun = []
        flight.node.create_subscription(Empty, "/experiment_trigger", lambda _: begun.append(flight.time), qos(10))
        flight.until(lambda: begun and flight.time >= begun[0] + 0.3, "the experiment is under way")
        os.kill(flight.numbers()[victim], signal.SIGKILL)
        killed = flight.time
        # criteria of the whole flight are not met by a short one
        assert flight.process.wait(PATIENCE) in (0, 1), flight.log.read_text()[-3000:]
        summary = json.loads((flight.out / "summary.json").read_text())
    finally:
        flight.close()
    events = summary["events"]

    def told(kind):
        return [event for event in events if event["kind"] == kind]

    (ended,) = told("ended")
    assert ended["drone"] == victim
    assert ended["time"] - killed <= SOONEST_S
    # on a busy machine another drone may count as lost for a moment as well
    others = [
        event
        for event in told("held" if victim.startswith("intruder") else TOLD_BY.get(scheme, "lost"))
        if victim == event["drone"] or event["details"].get("reason") == f"lost {victim}"
    ]
    assert others
    assert others[0]["time"] - killed <= SOONEST_S + DELAYS.get(scheme, 0.0)
    # the killed one as well: the host lands drones without a node
    assert sorted(event["drone"] for event in told("landed")) == sorted(drone["id"] for drone in summary["drones"])
    assert not told("failure")
    assert max(event["time"] for event in events) < BOUND_S
