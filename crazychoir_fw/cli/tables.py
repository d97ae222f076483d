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


def flight_tables(summary: dict[str, Any]) -> list[Table]:
    """Return what is shown of a flight: the drones, and the criteria, if there are some."""
    tables = [_drones_table(summary)]
    return [*tables, _criteria_table(summary)] if summary["criteria"] else tables


Columns = tuple[tuple[str, str, float | None, int], ...]

# two short lines each, so that a table fits a terminal of 80 columns with its units: heading, key, factor, digits
_ONBOARD_COLUMNS: Columns = (
    ("RMS error\n(cm)", "rms_error_m", 100.0, 1),
    ("max error\n(cm)", "max_error_m", 100.0, 1),
    ("end\n(cm)", "endpoint_error_m", 100.0, 1),
    ("estimate\n(cm)", "estimator_rms_m", 100.0, 1),
    ("thrust\n(%)", "hover_thrust_percent", 1.0, 1),
    ("battery\n(V)", "battery_V", 1.0, 2),
    ("supervisor", "supervisor_state", None, 0),
)
_LAYERS_COLUMNS: Columns = (
    ("role", "role", None, 0),
    ("end\n(cm)", "position_error_m", 100.0, 1),
    ("RMS error\n(cm)", "rms_error_m", 100.0, 1),
    ("max error\n(cm)", "max_error_m", 100.0, 1),
    ("nearest\n(m)", "least_distance_m", 1.0, 2),
    ("state", "phase", None, 0),
)


def _drones_table(summary: dict[str, Any]) -> Table:
    """Return one row per drone, or the worst ones of a large swarm."""
    drones = summary["drones"]
    columns, worst, flown = _LAYERS_COLUMNS, "position_error_m", f"backend {summary['backend']}"
    if "role" not in drones[0]:
        columns, worst, flown = _ONBOARD_COLUMNS, "max_error_m", f"{summary['provider']} onboard software"
    title = f"{summary['mission']}: {len(drones)} drones, {flown}"
    if len(drones) > MANY:
        drones = sorted(drones, key=lambda drone: -(drone[worst] or 0.0))[:MANY]
        title += f" (the {MANY} with the largest errors)"
    table = Table(title=title, box=box.SIMPLE_HEAD, collapse_padding=True, pad_edge=False)
    table.add_column("drone", no_wrap=True, min_width=5)
    for heading, _, factor, _ in columns:
        table.add_column(heading, justify="left" if factor is None else "right", no_wrap=True)
    for drone in drones:
        figures = (drone[key] if factor is None else _figure(drone[key], factor, n) for _, key, factor, n in columns)
        table.add_row(drone["id"], *figures)
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


def verdict(summary: dict[str, Any], folder: Path | None) -> Text:
    """Return the last line: how it went, how fast it was, where the files are."""
    went = ("success", "bold green") if summary["success"] else ("failed", "bold red")
    pace = f"{summary['sim_seconds']:.1f} s flown in {summary['wall_seconds']:.1f} s"
    factor = summary["real_time_factor"]
    where = "" if folder is None else f", see {folder}/"
    return Text.assemble(went, f": {pace} ({_figure(factor)} x real time){where}")


def _figure(value: float | None, scale: float = 1.0, digits: int = 1) -> str:
    """Return a figure of a summary; one that the flight does not have is a dash."""
    return "-" if value is None else f"{value * scale:.{digits}f}"
