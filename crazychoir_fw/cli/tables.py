"""Summaries as tables for people."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rich import box
from rich.table import Table
from rich.text import Text

MANY = 32
"""Swarms up to this size are listed whole; of a larger one, the worst."""


def facts_table(facts: Mapping[str, str]) -> Table:
    """Return one row per fact: its name and what is to be said."""
    table = Table(show_header=False, box=None)
    for name, value in facts.items():
        table.add_row(Text(name, style="bold"), Text(value, overflow="fold"))
    return table


def flight_table(summary: dict[str, Any]) -> Table:
    """Return one row per drone, or the worst ones of a large swarm."""
    drones = summary["drones"]
    title = f"{summary['mission']}: {len(drones)} drones, {summary['provider']} onboard software"
    if len(drones) > MANY:
        drones = sorted(drones, key=lambda drone: -(drone["max_error_m"] or 0.0))[:MANY]
        title += f" (the {MANY} with the largest errors)"
    table = Table(title=title, box=box.SIMPLE_HEAD, collapse_padding=True, pad_edge=False)
    table.add_column("drone", no_wrap=True, min_width=5)
    # two short lines each, so that the table fits a terminal of 80 columns with its units
    headings = ["RMS error\n(cm)", "max error\n(cm)", "end\n(cm)", "estimate\n(cm)", "thrust\n(%)", "battery\n(V)"]
    for heading in headings:
        table.add_column(heading, justify="right", no_wrap=True)
    table.add_column("supervisor", no_wrap=True)
    for drone in drones:
        lengths = ("rms_error_m", "max_error_m", "endpoint_error_m", "estimator_rms_m")
        table.add_row(
            drone["id"],
            *(_figure(drone[key], scale=100.0) for key in lengths),
            _figure(drone["hover_thrust_percent"]),
            _figure(drone["battery_V"], digits=2),
            drone["supervisor_state"],
        )
    return table


def flight_tables(summary: dict[str, Any]) -> list[Table]:
    """Return what is shown of any flight: one table for phases, two for layers."""
    if "endpoint_error_m" in summary["drones"][0]:
        return [flight_table(summary)]
    tables = [_layers_table(summary)]
    return [*tables, _criteria_table(summary)] if summary["criteria"] else tables


def _layers_table(summary: dict[str, Any]) -> Table:
    """Return one row per drone that layers flew, or the worst ones of a large swarm."""
    drones = summary["drones"]
    title = f"{summary['mission']}: {len(drones)} drones, backend {summary['backend']}"
    if len(drones) > MANY:
        drones = sorted(drones, key=lambda drone: -(drone["position_error_m"] or 0.0))[:MANY]
        title += f" (the {MANY} with the largest errors)"
    table = Table(title=title, box=box.SIMPLE_HEAD, collapse_padding=True, pad_edge=False)
    table.add_column("drone", no_wrap=True, min_width=5)
    table.add_column("role", no_wrap=True)
    headings = ["end\n(cm)", "RMS error\n(cm)", "max error\n(cm)", "nearest\n(m)"]
    for heading in headings:
        table.add_column(heading, justify="right", no_wrap=True)
    table.add_column("state", no_wrap=True)
    for drone in drones:
        lengths = ("position_error_m", "rms_error_m", "max_error_m")
        table.add_row(
            drone["id"],
            drone["role"],
            *(_figure(drone[key], scale=100.0) for key in lengths),
            _figure(drone["least_distance_m"], digits=2),
            drone["phase"],
        )
    return table


def _criteria_table(summary: dict[str, Any]) -> Table:
    """Return one row per criterion: what was allowed, what was measured."""
    table = Table(box=box.SIMPLE_HEAD, collapse_padding=True, pad_edge=False)
    table.add_column("criterion", no_wrap=True)
    table.add_column("allowed", justify="right", no_wrap=True)
    table.add_column("measured", justify="right", no_wrap=True)
    table.add_column("", no_wrap=True)
    for entry in summary["criteria"]:
        sign = "≥" if entry["criterion"].startswith(("min_", "tasks_")) else "≤"
        is_flag = isinstance(entry["limit"], bool)
        measured = "-" if entry["value"] is None else f"{entry['value']:.4g}"
        went = Text("passed", style="green") if entry["passed"] else Text("failed", style="bold red")
        allowed = "all" if is_flag else f"{sign} {entry['limit']:g}"
        table.add_row(entry["criterion"], allowed, measured, went)
    return table


def verdict(summary: dict[str, Any], folder: Path) -> Text:
    """Return the last line: how it went, how fast it was, where the files are."""
    went = ("success", "bold green") if summary["success"] else ("failed", "bold red")
    pace = f"{summary['sim_seconds']:.1f} s flown in {summary['wall_seconds']:.1f} s"
    factor = summary["real_time_factor"]
    return Text.assemble(went, f": {pace} ({_figure(factor)} x real time), see {folder}/")


def _figure(value: float | None, scale: float = 1.0, digits: int = 1) -> str:
    """Return a figure of a summary; one that the flight does not have is a dash."""
    return "-" if value is None else f"{value * scale:.{digits}f}"
