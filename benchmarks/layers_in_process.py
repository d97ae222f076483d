"""How fast layers fly a swarm in one process, and where the time goes.

    python benchmarks/layers_in_process.py [--seconds 20] [--threads 2]

Bearing formations of 4, 11 and 30 drones, and ten that swap places behind a safety filter (the missions in examples/),
on simulated drones with their onboard software, after their take-off. Compare runs side by side only: other programs on
the machine change every number. Those of the fastest fifth of rounds change least: `best` is processor time of a round
of one thread, `flown` that of the drones in it, `ratio` their quotient and `x_cpu` simulated seconds per second of it.
"""

import argparse
import json
import time
from pathlib import Path

import numpy as np

from crazychoir_fw.flight.backends import make_backend
from crazychoir_fw.flight.engine import make_experiment
from crazychoir_fw.flight.experiment import PARTS, Experiment
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
    best, flown = fastest_rounds(experiment, round(seconds / experiment.period))
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    rounds = seconds / experiment.period
    row = {"backend": backend, "drones": len(experiment.agents), "real_time_factor": round(seconds / wall, 2)}
    row |= {"round": round(1e6 * wall / rounds), "cpu": round(1e6 * cpu / rounds)}
    row |= {"best": round(1e6 * best), "flown": round(1e6 * flown), "ratio": round(best / flown, 2)}
    row["x_cpu"] = round(experiment.period / best, 1)
    return row | {part: round(1e6 * experiment.shares[part] / rounds) for part in PARTS}


def fastest_rounds(experiment: Experiment, rounds: int) -> tuple[float, float]:
    """Fly; return the processor time (s) that a fifth of rounds stays below, and of the drones in them."""
    backend, advance, clock = experiment.backend, experiment.backend.advance, time.thread_time
    of_rounds, of_drones = [], []

    def timed(seconds: float) -> None:
        begin = clock()
        advance(seconds)
        of_drones.append(clock() - begin)

    backend.advance = timed  # type: ignore[method-assign]
    for _ in range(rounds):
        begin = clock()
        experiment.step()
        of_rounds.append(clock() - begin)
    backend.advance = advance  # type: ignore[method-assign]
    return float(np.quantile(of_rounds, 0.2)), float(np.quantile(of_drones, 0.2))


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=20.0, help="simulated time of each measurement (s)")
    parser.add_argument("--threads", type=int, default=2, help="threads of the simulation")
    parser.add_argument("--json", type=Path, help="file for the numbers")
    given = parser.parse_args()
    rows = []
    for backend in ("sim", "integrator"):
        for name in ("bearing_formation", "letter_s", "grid_30", "swap_ten"):
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
