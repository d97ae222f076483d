"""How fast campaigns are: flights per second, and what a flight costs beside its steps.

python benchmarks/campaign_speed.py [--flights 200] [--workers 2]
"""

import argparse
import json
import tempfile
import time
from pathlib import Path

import yaml

from crazychoir_fw.campaign.campaign import load_campaign
from crazychoir_fw.campaign.engines import Processes
from crazychoir_fw.campaign.run import run

HOVER = {
    "name": "hover",
    "drones": [{"id": "cf1", "position": [0.0, 0.0]}],
    "flight": [
        {"takeoff": {"height": 1.0, "duration": 2.0}},
        {"hover": {"duration": 13.0}},
        {"land": {"duration": 2.5}},
    ],
}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--flights", type=int, default=200)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--json", type=Path, help="write the figures to this file")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder, Processes(given.workers) as engine:
        file = Path(folder) / "hover.yaml"
        file.write_text(yaml.safe_dump(HOVER))
        run(load_campaign(file, flights=2 * given.workers), Path(folder) / "warm", engine)
        begin = time.perf_counter()
        outcome = run(load_campaign(file, flights=given.flights), Path(folder) / "out", engine)
        seconds = time.perf_counter() - begin
    flown = sum(record.sim_seconds for record in outcome.records)
    steps = sum(record.wall_seconds for record in outcome.records)
    beside = 1e3 * (given.workers * seconds - steps) / given.flights
    print(f"{given.flights} flights of {flown / given.flights:.1f} s, {given.workers} workers: {seconds:.1f} s")
    flying = 1e3 * steps / given.flights
    if given.json is not None:
        given.json.write_text(json.dumps({"seconds": seconds, "steps_ms": flying, "beside_ms": beside}))
    print(f"{flown / seconds:.0f} x real time, per flight {flying:.1f} ms of steps and {beside:.1f} ms beside them")


if __name__ == "__main__":
    main()
