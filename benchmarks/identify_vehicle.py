"""Identifies a vehicle from recorded flights in the format of NanoBench.

    python benchmarks/identify_vehicle.py --data FOLDER --flights A B C --out vehicle.yaml

Writes the parameters that differ from platform cf2, as `DroneConfig.vehicle` and `real_flights.py --vehicle` read them.
Judge them on other flights.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from recorded.identification import MASS, TIME_CONSTANTS, Identified, identify

from crazychoir_fw.common.errors import CrazychoirError
from crazychoir_fw.common.replacing import replacing
from crazychoir_fw.comparison.nanobench import flight_files, read_flight

UNITS = {
    "mass": "kg",
    "inertia": "kg m^2",
    "drag.rotor_xy": "kg/rad",
    "drag.body": "N s^2/m^2",
    "flight_moment.x": "N s",
    "flight_moment.y": "N s",
    "flight_moment.thrust": "N",
    "rotors.time_constant_up": "s",
    "rotors.time_constant_down": "s",
    "rotors.heat_loss": '"1"',
    "rotors.heat_time": "s",
    "rotors.heat_own_loss": '"1"',
    "rotors.heat_own_time": "s",
    "rotors.heat_thrust": "N",
    "battery.resistance": "Ohm",
}


def line(name: str, value: Any, spread: dict[str, tuple[float, ...]]) -> str:
    """Return one line of the file: value, unit, and what each flight alone says."""
    if isinstance(value, str):
        text = value
    elif isinstance(value, tuple):
        text = f"[{', '.join(f'{part:.4g}' for part in value)}]"
    else:
        text = f"{value:.4g}"
    alone = spread.get(name)
    note = f', note: "regressions, each flight alone: {", ".join(f"{part:.3g}" for part in alone)}"' if alone else ""
    unit = f", unit: {UNITS[name]}" if name in UNITS else ', unit: ""'
    return f"{name}: {{value: {text}{unit}, source: NANO{note}}}"


def file_text(found: Identified) -> str:
    """Return the YAML file."""
    lines = [
        "# A Crazyflie 2.1 with motion-capture markers and charging deck: what differs from cf2. NANO: identified by",
        f"# benchmarks/identify_vehicle.py from NanoBench (arXiv 2603.09908): {', '.join(found.flights)}.",
        "# Mass is given by the data set; thrust scale and trim differ from flight to flight and are not here.",
        "",
        *(line(name, value, found.spread) for name, value in found.vehicle.items()),
    ]
    return "\n".join(lines) + "\n"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, required=True, help="folder with flights (*.csv, *.csv.gz)")
    parser.add_argument("--flights", nargs="+", default=[], help="names to identify from; all by default")
    parser.add_argument("--mass", type=float, default=MASS, help="of the vehicle [kg]")
    parser.add_argument("--time-constants", nargs="+", type=float, default=TIME_CONSTANTS, help="to try [s]")
    parser.add_argument("--no-refining", action="store_true", help="moments and drag by regression alone (faster)")
    parser.add_argument("--out", type=Path, required=True)
    options = parser.parse_args()
    try:
        flights = [read_flight(path) for path in flight_files(options.data, options.flights)]
        found = identify(flights, options.mass, options.time_constants, refines=not options.no_refining, report=print)
    except CrazychoirError as error:
        raise SystemExit(str(error)) from error
    with replacing(options.out) as path:
        path.write_text(file_text(found))
    print(file_text(found), end="")


if __name__ == "__main__":
    main()
