"""What log blocks cost the simulation, for one drone and for a swarm.

    python benchmarks/log_cost.py --drones 1 30 --json log.json

Every drone has two blocks of five floats at 100 Hz. The same world flies with the blocks, with an appointment that does
nothing at the same instants, and with neither; the three take turns. `sampling` is what the sampling itself takes, from
the outside of C to the queue of the radio, while the world flies.
"""

from __future__ import annotations

import argparse
import json
import statistics
import struct
import time
from pathlib import Path

from swarm_scale import hovering_world

from crazychoir_fw.crtp.services.log_sampler import _Group
from crazychoir_fw.crtp.station import Station
from crazychoir_fw.onboard.variables import log_table
from crazychoir_fw.simulation import World, set_threads

KINDS = {
    "in the state": ("stateEstimate.x", "stateEstimate.y", "stateEstimate.z", "stabilizer.roll", "stabilizer.pitch"),
    "computed when read": tuple(f"stateEstimateZ.{name}" for name in ("x", "y", "z", "vx", "vy")),
}
FLOAT = 7


class Stopwatch:
    """Adds up what sampling takes."""

    def __init__(self) -> None:
        self.spent = 0.0
        self._sample = _Group._sample

    def __enter__(self) -> Stopwatch:
        sample = self._sample

        def timed(group: _Group) -> None:
            begin = time.thread_time()
            sample(group)
            self.spent += time.thread_time() - begin

        _Group._sample = timed
        return self

    def __exit__(self, *_: object) -> None:
        _Group._sample = self._sample


def start_blocks(stations: list[Station], names: tuple[str, ...]) -> None:
    """Let two blocks run on every drone."""
    ids = list(log_table(0))
    values = b"".join(struct.pack("<BH", FLOAT, ids.index(name)) for name in names)
    for station in stations:
        for number in (1, 2):
            station.receive(bytes((0x5D, 6, number)) + values)
            station.receive(bytes((0x5D, 3, number, 1)))
        station.context.carry_out()


def fly(world: World, seconds: float) -> float:
    """Return the processor time (s) of a flight."""
    begin = time.process_time()
    world.run(seconds)
    return time.process_time() - begin


def measure(world: World, seconds: float, repeats: int) -> list[dict[str, object]]:
    """Return a row for each kind of variable."""
    rows: list[dict[str, object]] = []
    stations = [Station(world, drone) for drone in world.drones]
    for kind, names in KINDS.items():
        spent: dict[str, list[float]] = {"alone": [], "stops": [], "blocks": [], "sampling": []}
        packets = 0
        for _ in range(repeats):
            spent["alone"].append(fly(world, seconds))
            cancel = world.agenda.every(10, lambda: None)
            spent["stops"].append(fly(world, seconds))
            cancel()
            with Stopwatch() as watch:
                start_blocks(stations, names)
                world.step(20)
                for station in stations:
                    station.context.take_out()
                watch.spent = 0.0
                spent["blocks"].append(fly(world, seconds))
                spent["sampling"].append(watch.spent)
                packets = sum(len(station.context.take_out()) for station in stations)
                for station in stations:
                    station.end_session()
                world.step(20)
        middle = {name: statistics.median(values) for name, values in spent.items()}
        rows.append(
            {
                "drones": len(stations),
                "values": kind,
                "sampling_us_per_packet": 1e6 * middle["sampling"] / packets,
                "all_us_per_packet": 1e6 * (middle["blocks"] - middle["alone"]) / packets,
                "slower_by_stops": middle["stops"] / middle["alone"] - 1,
                "slower_by_blocks": middle["blocks"] / middle["alone"] - 1,
            }
        )
    return rows


def main() -> None:
    """Measure and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--drones", type=int, nargs="+", default=[1, 30])
    parser.add_argument("--seconds", type=float, default=2.0, help="simulated seconds per run")
    parser.add_argument("--repeats", type=int, default=7)
    parser.add_argument("--json", type=Path)
    arguments = parser.parse_args()

    set_threads(1)
    rows = []
    for count in arguments.drones:
        for row in measure(hovering_world(count), arguments.seconds, arguments.repeats):
            rows.append(row)
            print(
                f"{row['drones']:4} drones, {row['values']:>18}: {row['sampling_us_per_packet']:5.2f} us per packet, "
                f"{row['all_us_per_packet']:5.2f} with all around it; the world is slower by "
                f"{row['slower_by_blocks']:.1%}, of which stops {row['slower_by_stops']:.1%}"
            )
    if arguments.json:
        arguments.json.write_text(json.dumps(rows, indent=2) + "\n")


if __name__ == "__main__":
    main()
