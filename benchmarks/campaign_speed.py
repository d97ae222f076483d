"""How fast campaigns are: flights per second, and what a flight costs beside its steps.

    python benchmarks/campaign_speed.py [--flights 200] [--workers 2]
    python benchmarks/campaign_speed.py --ray-nodes 2 4

Times per flight are CPU times (user and system), which do not depend on what else the machine does: first in this
process, the steps of the physics and software apart from the rest; then of all processes of an engine.
"""

import argparse
import json
import os
import resource
import tempfile
import time
from contextlib import contextmanager
from pathlib import Path

import yaml

from crazychoir_fw.campaign.campaign import load_campaign
from crazychoir_fw.campaign.engines import Processes, here
from crazychoir_fw.campaign.ray_engine import RayEngine
from crazychoir_fw.campaign.run import run
from crazychoir_fw.campaign.table import hash_of
from crazychoir_fw.common.kept_memory import keep_freed_memory
from crazychoir_fw.flight.onboard_flight import OnboardFlight

HOVER = {
    "name": "hover",
    "drones": [{"id": "cf1", "position": [0.0, 0.0]}],
    "flight": [
        {"takeoff": {"height": 1.0, "duration": 2.0}},
        {"hover": {"duration": 13.0}},
        {"land": {"duration": 2.5}},
    ],
}


@contextmanager
def steps_timed():
    """Adds up the CPU time (s) of the steps of all flights of this process."""
    fly, spent = OnboardFlight.fly, [0.0]

    def timed(self):
        begin = time.process_time()
        try:
            fly(self)
        finally:
            spent[0] += time.process_time() - begin

    OnboardFlight.fly = timed
    try:
        yield spent
    finally:
        OnboardFlight.fly = fly


def in_this_process(file, folder, flights):
    """Return CPU time per flight (ms): of its steps, and of all else."""
    keep_freed_memory()
    run(load_campaign(file, flights=2), folder / "warm", here)
    with steps_timed() as steps:
        begin = time.process_time()
        outcome = run(load_campaign(file, flights=flights), folder / "here", here)
        spent = time.process_time() - begin
    return 1e3 * steps[0] / flights, 1e3 * (spent - steps[0]) / flights, outcome


def cpu_of_all():
    """Return CPU time (s) of this process and of its children that have ended."""
    used = [resource.getrusage(one) for one in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(one.ru_utime + one.ru_stime for one in used)


def by_workers(file, folder, flights, workers):
    """Return wall time (s), and CPU time per flight of all processes (ms), start of the workers included."""
    before, begin = cpu_of_all(), time.perf_counter()
    with Processes(workers) as engine:
        outcome = run(load_campaign(file, flights=flights), folder / f"workers{workers}", engine)
        seconds = time.perf_counter() - begin
    return seconds, 1e3 * (cpu_of_all() - before) / flights, outcome


def cpu_of_ray():
    """Return CPU time (s) of this process and of all processes below it that live."""
    import psutil

    total = 0.0
    for process in (psutil.Process(), *psutil.Process().children(recursive=True)):
        try:
            times = process.cpu_times()
        except psutil.NoSuchProcess:
            continue
        total += times.user + times.system
    return total


def by_ray(file, folder, flights, nodes):
    """Return the same on a cluster of so many node processes of this machine, with workers that run already."""
    import ray
    from ray.cluster_utils import Cluster

    os.environ["RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO"] = "0"
    os.environ["PYTHONPATH"] = os.pathsep.join([str(Path.cwd()), os.environ.get("PYTHONPATH", "")])
    made = Cluster(initialize_head=True, head_node_args={"num_cpus": 1, "include_dashboard": False})
    for _ in range(nodes - 1):
        made.add_node(num_cpus=1)
    ray.init(address=made.address, logging_level="ERROR", log_to_driver=False)
    try:
        warm = load_campaign(file, flights=8 * nodes)
        run(warm, folder / f"warm{nodes}", RayEngine("auto", warm))
        campaign = load_campaign(file, flights=flights)
        before, begin = cpu_of_ray(), time.perf_counter()
        outcome = run(campaign, folder / f"ray{nodes}", RayEngine("auto", campaign))
        return time.perf_counter() - begin, 1e3 * (cpu_of_ray() - before) / flights, outcome
    finally:
        ray.shutdown()
        made.shutdown()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--flights", type=int, default=200)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--ray-nodes", type=int, nargs="*", default=[], help="node processes of a local cluster")
    parser.add_argument("--json", type=Path, help="write the figures to this file")
    given = parser.parse_args()
    figures = {}
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        file = folder / "hover.yaml"
        file.write_text(yaml.safe_dump(HOVER))
        steps, beside, outcome = in_this_process(file, folder, given.flights)
        flown = sum(record.sim_seconds for record in outcome.records) / given.flights
        figures["here"] = {"steps_ms": steps, "beside_ms": beside}
        table = hash_of(outcome.records)
        print(f"{given.flights} flights of {flown:.1f} s: {steps:.1f} ms of steps and {beside:.1f} ms beside them")
        engines = [(f"{given.workers} workers", by_workers, given.workers)]
        engines += [(f"Ray, {nodes} nodes", by_ray, nodes) for nodes in given.ray_nodes]
        for name, fly, count in engines:
            seconds, cpu, outcome = fly(file, folder, given.flights, count)
            more = cpu - steps - beside
            figures[name] = {"seconds": seconds, "cpu_ms": cpu, "more_ms": more}
            same = "the same table" if hash_of(outcome.records) == table else "ANOTHER TABLE"
            print(f"{name}: {seconds:.1f} s, {cpu:.1f} ms per flight, {more:+.1f} ms to that; {same}")
    if given.json is not None:
        given.json.write_text(json.dumps(figures, indent=1) + "\n")


if __name__ == "__main__":
    main()
