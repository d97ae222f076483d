"""Nodes that fly over the radio, here against a simulation that is served in real time.

Drones are commanded by velocities: they hover where commands come late, so that a busy machine is no failure.
"""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from geometry_msgs.msg import Twist, Vector3
from nav_msgs.msg import Odometry
from ros_domains import reserve_domain
from std_msgs.msg import Empty, String

from crazychoir_fw.ros.radio import RadioHandlerVel

sys.path.append(str(Path(__file__).resolve().parents[1] / "crtp"))
from serving import PATIENCE_S, serving

MISSION = """
name: over_the_radio
backend: hardware
hardware: {{accept: [names, places]}}  # those of `crazychoir serve --count 3`
drones:
  - {{id: agent_0, position: [0.0, 0.0], uri: "{cf1}"}}
  - {{id: agent_1, position: [0.5, 0.0], uri: "{cf2}"}}
layers:
  guidance: {{class: SimpleGuidance, height: 0.4}}
  planning: {{class: Spline}}
  control: {{class: VelocityController, gains: mujoco}}
flight:
  - takeoff: {{duration: 1.5}}
  - land: {{duration: 1.5}}
"""


@pytest.fixture(scope="module")
def uris():
    with serving("--count", "3") as (_, made):
        yield made


def test_a_mission_flies_over_the_radio_with_its_layers_as_nodes(uris, tmp_path):
    file, out = tmp_path / "mission.yaml", tmp_path / "out"
    file.write_text(MISSION.format(**uris))
    command = [sys.executable, "-c", "from crazychoir_fw.cli import app; app()", "fly", str(file), "--ros"]
    command += ["--processes", "one", "--no-video", "--out", str(out), "--domain", str(reserve_domain())]
    flown = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE_S, env={**os.environ})
    assert flown.returncode == 0, flown.stdout + flown.stderr
    assert (out / "summary.json").is_file()


def test_a_radio_node_takes_off_flies_and_lands(uris, bench):
    parameters = {"uris": [uris["cf3"]], "agent_ids": [2], "takeoff_height": 0.4}
    bench.add(RadioHandlerVel(parameters=parameters, context=bench.context))
    heard = bench.hear(Odometry, "/agent_2/cf_odom")
    states = bench.hear(String, "/agent_2/radio_state")
    commands = bench.speaker(Twist, "/agent_2/cmd_vel")
    takeoff, land = bench.speaker(Empty, "/takeoff"), bench.speaker(Empty, "/land")

    def place():
        position = heard[-1].pose.pose.position
        return position.x, position.y, position.z

    bench.until(lambda: heard)
    start = place()
    takeoff.publish(Empty())
    bench.until(lambda: place()[2] > 0.3, states)

    def has_moved():
        # as many as the executor can take: the radio's threads live on beside them
        commands.publish(Twist(linear=Vector3(x=0.3)))
        return place()[0] - start[0] > 0.15

    bench.until(has_moved, states)
    assert abs(place()[1] - start[1]) < 0.1
    land.publish(Empty())
    bench.until(lambda: place()[2] < 0.1, states)


TASKS = """
name: tasks_over_the_radio
backend: hardware
hardware: {{accept: [names, places]}}  # those of `crazychoir serve --count 3`
seed: 2
drones:
  - {{id: agent_0, position: [0.0, 0.0], uri: "{cf1}"}}
  - {{id: agent_1, position: [0.5, 0.0], uri: "{cf2}"}}
layers:
  communication: {{graph: complete, deadline_s: 0.2}}
  guidance: {{class: TaskGuidance, height: 0.4, options: {{max_iterations: 8, speed: 0.8}}}}
  tasks: {{seed: 4, low: [-0.3, -0.3], high: [0.8, 0.3], probability: 1.0, generations: 3}}
flight:
  - takeoff: {{duration: 1.5}}
  - start: {{duration: 4.0}}
  - land: {{duration: 1.5}}
criteria: {{tasks_completed: 1, min_distance_m: 0.0}}
"""


@pytest.mark.skipif("CRAZYCHOIR_ALL_FLIGHTS" not in os.environ, reason="takes long: CRAZYCHOIR_ALL_FLIGHTS=1 flies it")
def test_tasks_are_shared_out_over_the_radio(uris, tmp_path):
    file, out = tmp_path / "mission.yaml", tmp_path / "out"
    file.write_text(TASKS.format(**uris))
    command = [sys.executable, "-c", "from crazychoir_fw.cli import app; app()", "fly", str(file)]
    command += ["--no-video", "--out", str(out)]
    flown = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE_S)
    assert flown.returncode == 0, flown.stdout + flown.stderr
