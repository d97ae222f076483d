"""Flights of real drones that a signal ends: the drones land. Served drones stand in for real ones."""

import signal
import subprocess
import sys
import threading
import time
from importlib.util import find_spec

import numpy as np
import pytest

pytest.importorskip("cflib")
from ports import free_ports

from crazychoir_fw.simulation import DroneConfig, World

NEEDS_ROS = pytest.mark.skipif(find_spec("rclpy") is None, reason="rclpy is not installed")
SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
HOVER = """
name: hover
hardware: {accept: [names, places]}  # each of three flies it
drones: [{id: cf1, position: [0, 0]}]
flight: [{takeoff: {duration: 3.0}}, {start: {duration: 60.0}}]
layers:
  guidance: {class: SimpleGuidance, height: 0.8}
"""
STREAMED = (
    "  planning: {class: Spline}\n  control: {class: HierarchicalController, sender: FPQRSender, gains: mujoco}\n"
)
COMMAND = (sys.executable, "-c", "from crazychoir_fw.cli import app; app()", "fly", "--no-video")


def fly(tmp_path, text, uri, *options):
    """Start a flight over the radio as a process, or as several."""
    folder = tmp_path / uri.rpartition(":")[2]
    folder.mkdir()
    (folder / "hover.yaml").write_text(text)
    arguments = (
        folder / "hover.yaml",
        "--backend",
        "hardware",
        "--uri-base",
        uri,
        "--no-video",
        "--out",
        folder,
        *options,
    )
    with (folder / "said.txt").open("w") as said:
        return subprocess.Popen(
            [*COMMAND, *map(str, arguments)], stdout=said, stderr=subprocess.STDOUT, preexec_fn=hear_hang_ups
        )


def hear_hang_ups():
    """Take SIGHUP as usual, also where the tests run under nohup."""
    signal.signal(signal.SIGHUP, signal.SIG_DFL)


@pytest.mark.parametrize(
    ("text", "options"),
    [
        (HOVER, []),
        (HOVER + STREAMED, []),
        pytest.param(HOVER + STREAMED, ["--ros", "--processes", "per-drone"], marks=NEEDS_ROS),
    ],
    ids=["planner on board", "thrust and rates", "processes"],
)
def test_drones_land_when_a_signal_ends_their_flight(tmp_path, text, options):
    world = World([DroneConfig(f"cf{k}", (float(k), 0.0)) for k in range(len(SIGNALS))], seed=1, visuals=False)
    port = free_ports(len(SIGNALS))
    heights = []
    world.agenda.every(50, lambda: heights.append((world.time, *world.positions()[:, 2])))
    with world.serve(port=port) as server:
        thread = threading.Thread(target=server.run, daemon=True)
        thread.start()
        flights = [fly(tmp_path, text, f"udp://127.0.0.1:{port + k}", *options) for k in range(len(SIGNALS))]
        try:
            wait_until(lambda: world.positions()[:, 2].min() > 0.7)
            for flight, number in zip(flights, SIGNALS, strict=True):
                flight.send_signal(number)
            codes = [flight.wait(30.0) for flight in flights]
            wait_until(lambda: world.positions()[:, 2].max() < 0.05)
        finally:
            for flight in flights:
                flight.kill()
            server.stop()
            thread.join(20.0)
    assert codes == ([130] * 3 if options else [130, 128 + signal.SIGTERM, 128 + signal.SIGHUP])
    fastest = np.diff(np.array(heights), axis=0)
    # free fall from there ends at 4 m/s
    assert (fastest[:, 1:] / fastest[:, :1]).min() > -1.0


def wait_until(condition, seconds=60.0):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "did not come true"
        time.sleep(0.05)
