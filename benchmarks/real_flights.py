"""Flies against recorded flights of real Crazyflies (NanoBench format), in four comparisons.

    python benchmarks/real_flights.py --data FOLDER --json flights.json --plots FOLDER

1 controller: recorded estimate and setpoints into our controller; desired attitude and thrust against the logged ones
2 motors:     thrust and torque commands and voltage through mixer and battery compensation
3 plant:      from true states, with recorded motors and voltage, 0.1, 0.2 and 0.5 s ahead
4 chain:      recorded setpoints into a simulated drone; path, lag, tilt, thrust, voltage

docs/real_flights.md explains every figure.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from crazychoir_fw.common.errors import CrazychoirError
from crazychoir_fw.common.replacing import replacing
from crazychoir_fw.comparison.figures import (
    Attempts,
    chain_figures,
    controller_figures,
    hover_figures,
    motor_figures,
    plant_figures,
)
from crazychoir_fw.comparison.nanobench import flight_files, read_flight
from crazychoir_fw.comparison.phases import find_phases
from crazychoir_fw.comparison.plots import draw_chain
from crazychoir_fw.comparison.tuning import tune
from crazychoir_fw.comparison.whole_chain import fly_again
from crazychoir_fw.onboard import vehicles

VEHICLE = Path(vehicles.__file__).with_name("nanobench.yaml")
IDENTIFIED_FROM = ("B2_circle_slow_rep1", "B5_helix_slow_rep1", "B8_star_slow_rep1")


def compare(path: Path, options: argparse.Namespace) -> dict[str, Any]:
    """Run all comparisons on one flight. What cannot be compared says why in place of figures."""
    row: dict[str, Any] = {"name": path.name.removesuffix(".gz").removesuffix(".csv")}
    attempt = Attempts()
    row["problems"] = attempt.problems
    flight = attempt("reading", lambda: read_flight(path))
    phases = flight and attempt("phases", lambda: find_phases(flight))
    if flight is None or phases is None:
        return row
    vehicle = options.vehicle
    drone = {"positioning": options.positioning, "mocap_latency_ms": options.mocap_latency}
    row |= {
        "controller": flight.controller,
        "used_for_identification": row["name"] in options.identified_from,
        "notes": list(flight.notes),
        "compared_s": list(phases.compared),
    }
    row |= attempt("controller", lambda: controller_figures(flight, phases)) or {}
    row |= attempt("motors", lambda: motor_figures(flight, phases)) or {}
    tuning = attempt("hover", lambda: tune(flight, phases, vehicle))
    if tuning is None:
        return row
    row["hover"] = hover_figures(tuning)
    row |= attempt("plant", lambda: plant_figures(flight, phases, vehicle, tuning)) or {}
    thrust_max = row.get("firmware_thrust_max_n")
    if (chain := attempt("chain", lambda: fly_again(flight, phases, vehicle, tuning, drone, thrust_max))) is not None:
        row |= chain_figures(chain)
        if options.plots is not None:
            draw_chain(chain, row["name"], options.plots / f"{row['name']}.png")
    return row


def number(value: float | None, form: str) -> str:
    """Return a number as text, or a dash."""
    return "–" if value is None else format(value, form)


def tables(rows: list[dict[str, Any]]) -> list[Table]:
    """Return the figures of all flights as tables."""
    inner = Table(title="Controller, motors, plant")
    chain = Table(title="Whole chain: simulated against real")
    for name in ("flight", "roll, pitch [deg]", "thrust [%]", "motors [%]", "0.1, 0.2, 0.5 s [cm]", "tilt [deg]"):
        inner.add_column(name, justify="left" if name == "flight" else "right")
    for name in ("cm, mean trim", "tilt", "cm, trim followed", "tilt"):
        inner.add_column(name, justify="right")
    for name in ("flight", "path [cm]", "shift [ms]", "tracking [%]", "tilt [%]", "thrust [%]", "pack [V]"):
        chain.add_column(name, justify="left" if name == "flight" else "right")

    def several(row: dict[str, Any], key: str, form: str) -> str:
        return " ".join(format(value, form) for value in row.get(key, ())) or "–"

    for row in rows:
        name = row["name"] + (" *" if row.get("used_for_identification") else "")
        angles = [number(row.get(f"controller_{axis}_rms_deg"), ".2f") for axis in ("roll", "pitch")]
        inner.add_row(
            name,
            " ".join(angles),
            number(row.get("controller_thrust_rms_percent"), ".2f"),
            number(row.get("motor_worst_mean_percent"), ".3f"),
            several(row, "plant_position_cm", ".2f"),
            several(row, "plant_tilt_deg", ".1f"),
            several(row, "plant_mean_position_cm", ".2f"),
            several(row, "plant_mean_tilt_deg", ".1f"),
            several(row, "plant_followed_position_cm", ".2f"),
            several(row, "plant_followed_tilt_deg", ".1f"),
        )
        path, lag = row.get("path_rms_m"), row.get("lag_s")
        chain.add_row(
            name,
            number(None if path is None else 100 * path, ".1f"),
            number(None if lag is None else 1000 * lag, ".0f"),
            number(row.get("tracking_percent"), "+.1f"),
            number(row.get("tilt_percent"), "+.1f"),
            number(row.get("thrust_percent"), "+.1f"),
            number(row.get("voltage_difference_v"), "+.3f"),
        )
    return [inner, chain]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, required=True, help="folder with flights (*.csv, *.csv.gz)")
    parser.add_argument("--flight", nargs="+", default=[], metavar="NAME", help="only these; all by default")
    parser.add_argument("--json", type=Path)
    parser.add_argument("--plots", type=Path, metavar="DIR", help="folder for one PNG per flight")
    parser.add_argument("--vehicle", default=str(VEHICLE), help="YAML file of parameters that differ from cf2")
    parser.add_argument("--identified-from", nargs="*", default=IDENTIFIED_FROM, help="flights to mark with *")
    parser.add_argument("--positioning", default="mocap_position", choices=("mocap_position", "mocap"))
    parser.add_argument("--mocap-latency", type=int, default=30, metavar="MS")
    options = parser.parse_args()
    console = Console(width=None if Console().is_terminal else 170)
    try:
        options.vehicle = vehicles.overrides(options.vehicle)
        files = flight_files(options.data, options.flight)
    except CrazychoirError as error:
        raise SystemExit(str(error)) from error
    rows = []
    for path in files:
        rows.append(compare(path, options))
        for problem in rows[-1]["problems"]:
            console.print(f"{rows[-1]['name']}: {problem}", style="yellow", markup=False)
    for table in tables(rows):
        console.print(table)
    console.print("* used for identifying the vehicle")
    if options.json is not None:
        with replacing(options.json) as path:
            path.write_text(json.dumps({"flights": rows}, indent=1) + "\n")


if __name__ == "__main__":
    main()
