"""What is left of building a world."""

import subprocess
import sys

import pytest

GROWTH = """
from crazychoir_fw.simulation import DroneConfig, World

def resident():
    return int(next(line for line in open("/proc/self/status") if line.startswith("VmRSS")).split()[1])

World([DroneConfig("first")], visuals=False).step(1)
before = resident()
world = World([DroneConfig(f"cf{i}", (0.3 * i, 0.0)) for i in range(300)], visuals=False)
world.step(1)
print((resident() - before) / 300)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
def test_a_drone_of_a_large_swarm_takes_little_memory():
    """In KiB, with its share of what a world has once: 65, and 120 when freed memory stays with the process."""
    run = subprocess.run([sys.executable, "-c", GROWTH], check=True, capture_output=True, text=True)
    assert float(run.stdout) < 90.0
