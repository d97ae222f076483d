"""What it costs that agents talk.

    python benchmarks/communicators.py                    # 50 agents in one process, 10 over ROS 2
    python benchmarks/communicators.py --agents 20 --no-ros

In one process, agents exchange messages of 1 kB with four neighbors each at 50 Hz, as objects and as bytes; the share
of a core is processor time per round over the time between rounds. Over ROS 2, one process each, agents exchange rounds
in lock step as fast as they can; without rclpy that part is skipped. Compare runs side by side only.
"""

import argparse
import json
import multiprocessing
import os
import time
from pathlib import Path
from typing import Any

import numpy as np

from crazychoir_fw.guidance import Graph, InProcessTransport, TimeVaryingCommunicator

RATE = 50.0  # [Hz]
NUMBERS = 128  # of 8 bytes: 1 kB
WARM_UP = 20  # rounds


def neighbors(count: int) -> Graph:
    """Return who talks to whom: each to the two on either side of it, in a ring."""
    if count < 6:
        return Graph.complete(count)
    return Graph.undirected(count, [(i, (i + k) % count) for i in range(count) for k in (1, 2)])


def in_one_process(count: int, rounds: int, serialize: bool) -> dict[str, Any]:
    """Return what a round of so many agents costs."""
    graph, air = neighbors(count), InProcessTransport(serialize=serialize)
    agents = [
        TimeVaryingCommunicator(i, count, graph.in_neighbors(i), graph.out_neighbors(i), transport=air)
        for i in range(count)
    ]
    message = np.arange(float(NUMBERS))
    begin = 0.0
    for k in range(-WARM_UP, rounds):
        if k == 0:
            begin = time.process_time()
        for agent in agents:
            agent.neighbors_send(message)
        for agent in agents:
            agent.collect()
    cpu = (time.process_time() - begin) / rounds
    heard = sum(agent.statistics.received for agent in agents) / (rounds + WARM_UP)
    return {
        "where": "one process, bytes" if serialize else "one process, objects",
        "agents": count,
        "messages_per_round": round(heard),
        "round_us": round(1e6 * cpu, 1),
        "cpu_share_at_50_hz": round(cpu * RATE, 4),
    }


def talk(i: int, count: int, rounds: int, results: Any) -> None:
    """Exchange rounds over ROS 2, as one process; puts the time of each round (s) into the results."""
    import rclpy

    from crazychoir_fw.ros.communicator import RosTransport

    rclpy.init()
    node = rclpy.create_node("benchmark", namespace=f"agent_{i}")
    graph, transport = neighbors(count), RosTransport(node)
    agent = TimeVaryingCommunicator(i, count, graph.in_neighbors(i), graph.out_neighbors(i), transport=transport)
    executor = rclpy.executors.SingleThreadedExecutor()
    executor.add_node(node)
    message = np.arange(float(NUMBERS))
    patience = time.monotonic() + 60.0
    while not transport.is_connected and time.monotonic() < patience:
        executor.spin_once(timeout_sec=0.05)
    taken = []
    for k in range(-WARM_UP, rounds):
        begin = time.perf_counter()
        agent.neighbors_send(message)
        end = time.monotonic() + (5.0 if k < 0 else 1.0)
        while not agent.has_round() and time.monotonic() < end:
            executor.spin_once(timeout_sec=0.1)
        agent.collect()
        agent.catch_up()
        if k >= 0:
            taken.append(time.perf_counter() - begin)
    results.put((taken, agent.statistics.lost))
    node.destroy_node()
    rclpy.shutdown()


def over_ros(count: int, rounds: int) -> dict[str, Any] | None:
    """Return how long rounds take between processes; None without ROS 2."""
    try:
        import rclpy  # noqa: F401
    except ImportError:
        return None
    from crazychoir_fw.ros.manager import free_domain

    os.environ["ROS_DOMAIN_ID"] = str(free_domain())
    fresh = multiprocessing.get_context("spawn")
    results = fresh.Queue()
    processes = [fresh.Process(target=talk, args=(i, count, rounds, results)) for i in range(count)]
    for process in processes:
        process.start()
    found = [results.get(timeout=120.0 + rounds) for _ in processes]
    for process in processes:
        process.join()
    taken = 1e3 * np.concatenate([times for times, _ in found])
    return {
        "where": "ROS 2, one process each",
        "agents": count,
        "rounds": rounds,
        "median_ms": round(float(np.median(taken)), 3),
        "p99_ms": round(float(np.percentile(taken, 99)), 3),
        "lost": sum(lost for _, lost in found),
    }


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--agents", type=int, default=50, help="agents in one process")
    parser.add_argument("--ros-agents", type=int, default=10, help="agents over ROS 2")
    parser.add_argument("--rounds", type=int, default=500)
    parser.add_argument("--no-ros", action="store_true", help="leave ROS 2 out")
    parser.add_argument("--json", type=Path, help="file for the numbers")
    given = parser.parse_args()
    rows = []
    for serialize in (False, True):
        rows.append(in_one_process(given.agents, given.rounds, serialize))
        print(rows[-1], flush=True)
    if not given.no_ros:
        row = over_ros(given.ros_agents, given.rounds)
        print(row or "ROS 2: skipped, there is no rclpy")
        rows += [row] if row else []
    if given.json:
        given.json.write_text(json.dumps(rows, indent=2) + "\n")


if __name__ == "__main__":
    main()
