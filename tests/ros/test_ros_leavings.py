"""What a flight over ROS leaves behind in memory: nothing."""

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


def shared_ports(domain):
    """What Fast DDS keeps in shared memory for the processes of a domain; ports as in UDP, 250 for each."""
    first = 7400 + 250 * domain
    numbers = {f"fastrtps_port{number}" for number in range(first, first + 250)}
    return [path.name for path in SHARED.iterdir() if path.name.removesuffix("_el") in numbers]


@pytest.mark.skipif(not SHARED.is_dir(), reason="shared memory is elsewhere")
@pytest.mark.parametrize("processes", ["one", "per-drone"])
def test_processes_give_back_what_they_share(tmp_path, processes):
    flight = Flight(tmp_path, MISSION, "--processes", processes)
    try:
        flight.until(lambda: flight.time > 0.5, "it flies")
        if not shared_ports(flight.domain):
            pytest.skip("this middleware shares no memory in this way")
        assert flight.process.wait(PATIENCE) == 0
    finally:
        flight.close()
    assert shared_ports(flight.domain) == []
