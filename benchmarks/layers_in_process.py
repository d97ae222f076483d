"""How fast layers fly a swarm in one process, and where the time goes.

    python benchmarks/layers_in_process.py [--seconds 20] [--threads 2]

Bearing formations of 4, 11 and 30 drones (the missions in examples/) on simulated drones with their onboard software,
after their take-off. Compare runs side by side only: other programs on the machine change every number.
"""

import argparse
import json
import time
from pathlib import Path

from crazychoir_fw.flight.backends import make_backend
from crazychoir_fw.flight.engine import make_experiment
from crazychoir_fw.flight.experiment import PARTS
from crazychoir_fw.mission.loader import load_mission

EXAMPLES = Path(__file__).parents[1] / "examples"


def measure(name: str, backend: str, seconds: float, threads: int) -> dict[str, float | str]:
    """Return what one swarm costs, times in microseconds per round."""
    mission = load_mission(EXAMPLES / f"{name}.yaml", backend=backend)
    experiment = make_experiment(mission, make_backend(mission, threads))
    experiment.takeoff()
    experiment.run(5.0)
    experiment.start()
    experiment.run(1.0)
    experiment.shares.update(dict.fromkeys(PARTS, 0.0))
    wall, cpu = time.perf_counter(), time.process_time()
    experiment.run(seconds)
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    rounds = seconds / experiment.period
    row = {"backend": backend, "drones": len(experiment.agents), "real_time_factor": round(seconds / wall, 2)}
    row |= {"round": round(1e6 * wall / rounds), "cpu": round(1e6 * cpu / rounds)}
    return row | {part: round(1e6 * experiment.shares[part] / rounds) for part in PARTS}


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=20.0, help="simulated time of each measurement (s)")
    parser.add_argument("--threads", type=int, default=2, help="threads of the simulation")
    parser.add_argument("--json", type=Path, help="file for the numbers")
    given = parser.parse_args()
    rows = []
    for backend in ("sim", "integrator"):
        for name in ("bearing_formation", "letter_s", "grid_30"):
            row = measure(name, backend, given.seconds, given.threads)
            if not rows:
                print("times in microseconds per round of 10 ms")
                print(" ".join(f"{key[:10]:>10}" for key in row))
            print(" ".join(f"{value:>10}" for value in row.values()), flush=True)
            rows.append(row)
    if given.json:
        given.json.write_text(json.dumps(rows, indent=2) + "\n")


if __name__ == "__main__":
    main()
