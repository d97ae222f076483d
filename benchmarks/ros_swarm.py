"""How fast a swarm flies when its layers are ROS 2 nodes, and how long a command takes.

    python benchmarks/ros_swarm.py                      # 10 and 30 drones, all layers in one process and one per drone
    python benchmarks/ros_swarm.py --drones 4 --processes per-node

Every drone has guidance that exchanges poses with up to six neighbors, a controller, and odometry at 100 Hz; two of
them lead and have a trajectory handler. In lockstep the simulation waits for every command, so that the real-time
factor is the pace of the slowest; the latency is from an odometry to the command that answers it. What host and
layers cost is processor time per round, which other work on the machine changes less than the pace.
"""

import argparse
import json
import os
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from crazychoir_fw.mission import load_mission
from crazychoir_fw.ros.manager import RosOptions, check, fly_as_processes, hosting


def mission_of(count: int, backend: str, folder: Path):
    """Return a mission of so many drones on a grid, each of which talks to three before it."""
    ids = [f"agent_{i}" for i in range(count)]
    # off the grid, since bearings along one line determine no place
    jitter = np.random.default_rng(1).uniform(-0.15, 0.15, (count, 2))
    places = [[0.8 * (i % 6) + float(jitter[i, 0]), 0.8 * (i // 6) + float(jitter[i, 1])] for i in range(count)]
    pairs = [[ids[i], ids[j]] for i in range(count) for j in (i - 1, i - 2, i - 6) if j >= 0]
    mission = {
        "name": "ros_swarm",
        "backend": backend,
        "drones": [{"id": name, "position": place} for name, place in zip(ids, places, strict=True)],
        "layers": {
            "communication": {"graph": pairs},
            "guidance": {
                "class": "BearingFormation",
                "leaders": [ids[0], ids[1]],
                "formation": places,
                "gains": "mujoco",
            },
            "planning": {"class": "Spline"},
            "control": {"gains": "mujoco"},
        },
        "flight": [{"takeoff": {"duration": 2.0}}, {"start": {"duration": 5.0}}],
    }
    path = folder / "ros_swarm.yaml"
    path.write_text(json.dumps(mission))
    return load_mission(path)


def measure(mission, options, seconds, result):
    """Fly, and write what was measured into a file. Runs in the process that has the drones."""
    from crazychoir_fw.flight.backends import make_backend

    backend = make_backend(mission)
    booting = time.perf_counter()
    with hosting(replace(options, deadline=30.0)) as make:
        experiment = make(mission, backend)
        figures = fly(mission, experiment, time.perf_counter() - booting, seconds)
    result.write_text(json.dumps(figures))
    return 0


def fly(mission, experiment, booted, seconds):
    """Return what was measured in formation."""
    experiment.takeoff()
    experiment.run(2.0)
    experiment.start()
    experiment.run(0.5)
    node = experiment.node
    node.latencies = []
    began, processor = time.perf_counter(), time.process_time()
    others = processor_time_of_others()
    experiment.run(seconds)
    wall = time.perf_counter() - began
    processor, others = time.process_time() - processor, processor_time_of_others() - others
    rounds = round(seconds * mission.layers.rate)
    latencies = np.array(node.latencies) * 1e3
    return {
        "boot_s": booted,
        "factor": seconds / wall,
        "odometry_hz": rounds / wall,
        "commands": len(latencies),
        "median_ms": float(np.median(latencies)),
        "p99_ms": float(np.percentile(latencies, 99)),
        "host_ms": 1e3 * processor / rounds,
        "layers_ms": 1e3 * others / rounds,
    }


def processor_time_of_others() -> float:
    """Return what all processes beside this one that have the same parent have used so far (s)."""
    ticks = 0
    for file in Path("/proc").glob("[0-9]*/stat"):
        try:
            number, fields = int(file.parent.name), file.read_text().rpartition(")")[2].split()
        except OSError:  # it has ended
            continue
        if int(fields[1]) == os.getppid() and number != os.getpid():
            ticks += int(fields[11]) + int(fields[12])
    return ticks / os.sysconf("SC_CLK_TCK")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--drones", type=int, nargs="+", default=[10, 30])
    parser.add_argument("--processes", nargs="+", default=["one", "per-drone"])
    parser.add_argument("--backend", default="sim", choices=["sim", "integrator"])
    parser.add_argument("--seconds", type=float, default=5.0, help="simulated")
    parser.add_argument("--pace", type=float, help="real-time factor to keep instead of lockstep")
    parser.add_argument("--json", type=Path, help="file for the numbers")
    args = parser.parse_args()
    print(
        f"{'drones':>6} {'processes':>10} {'x real time':>11} {'odometry':>9} {'median':>9} {'p99':>9} {'boot':>7} "
        f"{'host':>9} {'layers':>9}"
    )
    rows = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for count in args.drones:
            mission = mission_of(count, args.backend, folder)
            for processes in args.processes:
                options = RosOptions(processes, None, args.pace, lockstep=args.pace is None)
                check(mission, options)
                result = folder / "figures.json"
                result.unlink(missing_ok=True)
                fly_as_processes(
                    mission, options, lambda ready, m=mission, r=result: measure(m, ready, args.seconds, r), quiet=True
                )
                if not result.is_file():
                    print(f"{count:6} {processes:>10} did not fly")
                    continue
                figures = json.loads(result.read_text())
                rows.append({"drones": count, "processes": processes, **figures})
                print(
                    f"{count:6} {processes:>10} {figures['factor']:11.2f} {figures['odometry_hz']:6.0f} Hz "
                    f"{figures['median_ms']:6.1f} ms {figures['p99_ms']:6.1f} ms {figures['boot_s']:5.1f} s "
                    f"{figures['host_ms']:6.2f} ms {figures['layers_ms']:6.2f} ms",
                    flush=True,
                )
    if args.json:
        args.json.write_text(json.dumps(rows, indent=2) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
