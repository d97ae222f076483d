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
BOUND_S = 25.0  # simulated, for the whole flight

MISSION = """
extends: {example}
backend: integrator
criteria: {{min_distance_m: 0.0}}
flight:
  - takeoff: {{duration: 1.5}}
  - start: {{duration: {start}}}
  - land: {{duration: 2.0}}
"""

VICTIMS = {
    "bearing_formation": "agent_2",
    "distance_formation": "agent_3",
    "containment": "agent_4",
    "mpc": "agent_2",
    "aggregative": "agent_1",
    "task_assignment": "agent_5",
    "pickup_delivery": "agent_1",
    "collision_vel": "agent_1",
}


@pytest.mark.parametrize("scheme", VICTIMS)
def test_one_that_is_killed_is_missed_and_the_others_land(scheme, tmp_path):
    text = MISSION.format(example=EXAMPLES / f"{scheme}.yaml", start=START_S)
    flight = Flight(tmp_path, text, "--processes", "per-drone")
    victim = VICTIMS[scheme]
    try:
        begun = []
        flight.node.create_subscription(Empty, "/experiment_trigger", lambda _: begun.append(flight.time), qos(10))
        flight.until(lambda: begun and flight.time >= begun[0] + 0.5, "the experiment is under way")
        os.kill(flight.numbers()[victim], signal.SIGKILL)
        assert flight.process.wait(PATIENCE) in (0, 1), flight.log.read_text()[-3000:]
        summary = json.loads((flight.out / "summary.json").read_text())
    finally:
        flight.close()
    import shutil

    shutil.copytree(flight.out, f"/tmp/h/rosall_out/k_{scheme}", dirs_exist_ok=True)
    shutil.copy(flight.log, f"/tmp/h/rosall_out/k_{scheme}/log.txt")
    events = summary["events"]
    ended = [event["time"] for event in events if event["kind"] == "ended"]
    assert len(ended) == 1
    held = [event for event in events if event["kind"] == "held"]
    assert [event["drone"] for event in held] == [victim]
    assert held[0]["time"] - ended[0] <= 1.0
    landed = {event["drone"] for event in events if event["kind"] == "landed"}
    assert landed == {drone["id"] for drone in summary["drones"]}
    assert max(event["time"] for event in events) < BOUND_S
