"""What flights over ROS leave behind in memory: nothing."""

import os
import signal
from pathlib import Path

import pytest
from ros_flights import PATIENCE, Flight

SHARED = Path("/dev/shm")
MISSION = """
backend: integrator
drones:
  - {id: agent_0, position: [0.0, 0.0]}
  - {id: agent_1, position: [1.0, 0.0]}
layers:
  guidance: {class: SimpleGuidance, height: 0.4}
  planning: {class: Spline}
  control: {gains: mujoco}
flight:
  - takeoff: {duration: 1.0}
  - land: {duration: 1.0}
"""

pytestmark = pytest.mark.skipif(not SHARED.is_dir(), reason="shared memory is elsewhere")


def shared_ports(domain):
    """What Fast DDS keeps in shared memory for the processes of a domain; ports as in UDP, 250 for each."""
    first = 7400 + 250 * domain
    numbers = {f"fastrtps_port{number}" for number in range(first, first + 250)}
    return {path.name for path in SHARED.iterdir() if path.name.removesuffix("_el") in numbers}


@pytest.mark.parametrize("processes", ["one", "per-drone"])
def test_processes_give_back_what_they_share(tmp_path, processes):
    sharing = {name: value for name, value in os.environ.items() if name != "FASTRTPS_DEFAULT_PROFILES_FILE"}
    sharing["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    # files of a process that was killed earlier in the same domain
    earlier = {path.name for path in SHARED.iterdir()}
    flight = Flight(tmp_path, MISSION, "--processes", processes, environment=sharing)
    try:
        flight.until(lambda: flight.time > 0.5, "it flies")
        if not shared_ports(flight.domain) - earlier:
            pytest.skip("this middleware shares no memory in this way")
        assert flight.process.wait(PATIENCE) == 0
    finally:
        flight.close()
    assert shared_ports(flight.domain) <= earlier


def test_without_being_asked_nobody_shares_memory_and_who_is_killed_leaves_none(tmp_path):
    earlier = {path.name for path in SHARED.iterdir()}
    flight = Flight(tmp_path, MISSION, "--processes", "per-drone", patience=2.0)
    try:
        flight.until(lambda: flight.time > 0.5, "it flies")
        assert shared_ports(flight.domain) <= earlier
        os.kill(flight.numbers()["agent_1"], signal.SIGKILL)
        flight.process.wait(PATIENCE)
    finally:
        flight.close()
    assert shared_ports(flight.domain) <= earlier
