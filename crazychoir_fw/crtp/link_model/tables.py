"""What simulated radios have counted, as tables for people."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rich import box
from rich.console import Group
from rich.table import Table

MANY = 32
"""So many drones are listed; of more, those with the most trouble."""


def link_tables(statistics: Mapping[str, Any]) -> Group:
    """Return one table of the radios and one of their drones.

    Args:
        statistics: What `SimulatedRadios.statistics` returns.
    """
    return Group(_radios(statistics["radios"]), _drones(statistics["drones"]))


def _radios(radios: Mapping[str, Any]) -> Table:
    table = _table("Radios", ["radio", "channel", "drones", "busy\n(%)", "on air\n(%)", "exchanges", "un-\nanswered"])
    table.add_column("colli-\nsions", justify="right", no_wrap=True)
    table.add_column("lost\nlinks", justify="right", no_wrap=True)
    for name, radio in radios.items():
        shares = (f"{100 * radio[key]:.1f}" for key in ("utilization", "on_air"))
        counts = (str(radio[key]) for key in ("exchanges", "unanswered", "collisions", "lost_links"))
        channel = f"{radio['channel']}, {radio['data_rate']}"
        table.add_row(name, channel, str(len(radio["drones"])), *shares, *counts)
    return table


def _drones(drones: Mapping[str, Any]) -> Table:
    rows = [(drone, way, figures, figures[way]) for drone, figures in drones.items() for way in ("up", "down")]
    rows = [row for row in rows if row[3]["sent"]]
    title = "Packets"
    if len(rows) > 2 * MANY:
        rows = sorted(rows, key=lambda row: -(row[3]["lost"] + row[3]["dropped"]))[: 2 * MANY]
        title += f" (the {2 * MANY} streams with the most losses)"
    headings = ["drone", "way", "sent", "lost", "drop-\nped", "re-\npeated", "twice", "out of\norder", "most\nqueued"]
    table = _table(title, [*headings, "mean\n(ms)", "95 %\n(ms)", "max\n(ms)"])
    for drone, way, _, tally in rows:
        counts = ("sent", "lost", "dropped", "repeated", "duplicated", "reordered", "most_waiting")
        times = ("latency_mean_ms", "latency_p95_ms", "latency_max_ms")
        milliseconds = (_milliseconds(tally[key]) for key in times)
        table.add_row(drone, way, *(str(tally[key]) for key in counts), *milliseconds)
    return table


def _milliseconds(value: float | None) -> str:
    if value is None:
        return "-"
    return f"{value:.1f}" if value < 100.0 else f"{value:.0f}"


def _table(title: str, headings: list[str]) -> Table:
    table = Table(title=title, box=box.SIMPLE_HEAD, padding=0, pad_edge=False)
    for number, heading in enumerate(headings):
        table.add_column(heading, justify="left" if number < 2 else "right", no_wrap=True)
    return table
