"""Environment steps per second of the vector environment, beside the world alone and beside other environments.

    python benchmarks/learning_speed.py                       # 1, 64 and 1024 flights on one and two threads
    python benchmarks/learning_speed.py --crazyflow PYTHON    # crazyflow beside, from its own environment

A step is 10 ms of flight at 100 Hz: ten ticks of vehicle, sensors, filter, controller and motors. Actions are small and
random, so that flights last; what ends begins again within the step. "world alone" are the same ten ticks with no
environment around them, in turn with it, so that the load of the machine counts for both. Seconds are those of
processors (--wall for those of the clock).
"""

from __future__ import annotations

import argparse
import json
import statistics
import subprocess
import sys
import time

import numpy as np

from crazychoir_fw.learning import Hover
from crazychoir_fw.learning.flights import Flights
from crazychoir_fw.learning.vector_env import FlightVectorEnv

ROUNDS = 7

CRAZYFLOW = """
import sys, time, numpy as np
from crazyflow.envs import *
import crazyflow.envs, gymnasium
n = int(sys.argv[1])
env = gymnasium.make_vec("DroneReachPos-v0", num_envs=n, freq=100)
env.reset(seed=0)
action = np.zeros(env.action_space.shape, np.float32)
for _ in range(20):
    env.step(action)
wall, cpu = time.perf_counter(), time.process_time()
steps = 200
for _ in range(steps):
    found = env.step(action)
np.asarray(found[0]["pos"] if isinstance(found[0], dict) else found[0])
print(n * steps / (time.perf_counter() - wall), n * steps / (time.process_time() - cpu))
"""


def measure(count: int, threads: int, clock) -> dict[str, float]:
    env = FlightVectorEnv(Hover(), count, threads=threads)
    env.reset(seed=0)
    rng = np.random.default_rng(0)
    steps = max(10, min(400, 20_000 // count))
    actions = rng.uniform(-0.05, 0.05, (steps, count, 4)).astype(np.float32)
    ours, alone = [], []
    for _ in range(ROUNDS):
        env.reset()
        begin = clock()
        for action in actions:
            env.step(action)
        ours.append((clock() - begin) / steps)
        env.reset()
        env.step(actions[0])
        begin = clock()
        for _ in range(steps // 2):
            env.flights.world.step_motion(env.task.ticks)
        alone.append((clock() - begin) / (steps // 2))
    ratio = statistics.median(a / b for a, b in zip(ours, alone, strict=True))
    return {
        "flights": count,
        "threads": threads,
        "steps_per_second": count / statistics.median(ours),
        "world_alone": count / statistics.median(alone),
        "overhead": ratio - 1.0,
    }


def measure_reset(clock) -> dict[str, float]:
    """Microseconds of a reset of one flight among 1024, by itself and together with 63 others."""
    flights = Flights(Hover(), 1024)
    found = {}
    for size in (1, 64):
        numbers = np.arange(size)
        times = []
        for _ in range(200):
            begin = clock()
            flights.begin(numbers)
            times.append((clock() - begin) / size)
        found[f"reset_us_{size}"] = 1e6 * statistics.median(times)
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--flights", type=int, nargs="+", default=[1, 64, 1024])
    parser.add_argument("--threads", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--wall", action="store_true", help="seconds of the clock on the wall")
    parser.add_argument("--crazyflow", metavar="PYTHON", help="interpreter with crazyflow, measured beside")
    parser.add_argument("--json", metavar="FILE")
    options = parser.parse_args()
    clock = time.perf_counter if options.wall else time.process_time
    rows = []
    print("flights  threads  env-steps/s  world alone  overhead")
    for threads in options.threads:
        for count in options.flights:
            row = measure(count, threads, clock)
            rows.append(row)
            print(
                f"{count:7d}  {threads:7d}  {row['steps_per_second']:11,.0f}  {row['world_alone']:11,.0f}  "
                f"{100 * row['overhead']:7.0f} %",
                flush=True,
            )
    reset = measure_reset(clock)
    print(f"reset: {reset['reset_us_1']:.1f} µs for one flight, {reset['reset_us_64']:.1f} µs each for 64 together")
    found = {"rows": rows, **reset}
    if options.crazyflow:
        for count in options.flights:
            run = subprocess.run([options.crazyflow, "-c", CRAZYFLOW, str(count)], capture_output=True, text=True)
            if run.returncode:
                sys.exit(f"crazyflow: {run.stderr.strip().splitlines()[-1]}")
            wall, cpu = map(float, run.stdout.splitlines()[-1].split())  # it warns on the same stream
            print(
                f"crazyflow, {count} flights: {wall:,.0f} env-steps/s by the clock, {cpu:,.0f} per second of processor"
            )
            found[f"crazyflow_{count}"] = {"wall": wall, "cpu": cpu}
    if options.json:
        with open(options.json, "w") as file:  # noqa: PTH123
            json.dump(found, file, indent=1)


if __name__ == "__main__":
    main()
