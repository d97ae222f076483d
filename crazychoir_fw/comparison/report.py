"""What a comparison looks like: rows of a table, a picture, a page, a file for programs."""

from __future__ import annotations

import base64
import json
import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined, select_autoescape

from crazychoir_fw.common.replacing import replacing
from crazychoir_fw.common.version import __version__
from crazychoir_fw.comparison.plots import draw_chain
from crazychoir_fw.comparison.side_by_side import Comparison

PICTURE, PAGE, SUMMARY = "comparison.png", "report.html", "summary.json"


@dataclass(frozen=True)
class Row:
    """One line of the table; what is not known is a dash."""

    name: str
    unit: str
    real: str
    simulated: str
    difference: str


def rows_of(comparison: Comparison) -> list[Row]:
    """Return the table: whole flight first, then plant, motors, controller."""
    return [*_whole(comparison), *_parts(comparison.figures)]


def _whole(comparison: Comparison) -> Iterator[Row]:
    chain = comparison.chain
    yield Row("distance of the paths (RMS, after the shift)", "cm", "", "", _text(100 * chain.path_rms_m, ".1f"))
    yield Row("shift: simulated comes later", "ms", "", "", _text(1000 * chain.lag_s, ".0f"))
    pairs: list[tuple[str, str, tuple[float, float], float, str, str, float]] = [
        ("lag behind the setpoint", "ms", chain.lag_behind_setpoint_s, 1000.0, ".0f", "ms", math.nan),
        ("distance to the setpoint (RMS)", "cm", chain.tracking_rms_m, 100.0, ".1f", "%", chain.tracking_percent),
        ("tilt (RMS)", "deg", chain.tilt_rms_deg, 1.0, ".2f", "%", chain.tilt_percent),
        ("commanded thrust (mean)", "counts", chain.thrust_counts, 1.0, ".0f", "%", chain.thrust_percent),
        ("voltage of the pack (mean)", "V", chain.voltage_v, 1.0, ".3f", "V", chain.voltage_difference_v),
    ]
    for name, unit, (real, simulated), factor, form, unit_of_difference, difference in pairs:
        if unit_of_difference == unit == "ms":
            difference = 1000.0 * (simulated - real)
        decimals = {"%": "+.1f", "V": "+.3f", "ms": "+.0f"}[unit_of_difference]
        shown = _text(difference, decimals)
        yield Row(
            name,
            unit,
            _text(factor * real, form),
            _text(factor * simulated, form),
            shown if shown == "–" else f"{shown} {unit_of_difference}",
        )


def _parts(figures: dict[str, Any]) -> Iterator[Row]:
    for key, name, unit, form in (
        ("controller_roll_rms_deg", "controller alone: desired roll (RMS)", "deg", ".2f"),
        ("controller_pitch_rms_deg", "controller alone: desired pitch (RMS)", "deg", ".2f"),
        ("controller_thrust_rms_percent", "controller alone: thrust (RMS)", "%", ".2f"),
        ("motor_worst_mean_percent", "mixer and compensation alone: worst motor (mean)", "%", ".3f"),
    ):
        if key in figures:
            yield Row(name, unit, "", "", _text(figures[key], form))
    for key, what, unit, form in (
        ("plant_position_cm", "position", "cm", ".2f"),
        ("plant_tilt_deg", "tilt", "deg", ".1f"),
    ):
        for seconds, value in zip(figures.get("plant_horizons_s", ()), figures.get(key, ()), strict=True):
            yield Row(f"plant alone: {what} after {seconds:g} s (RMS)", unit, "", "", _text(value, form))


def _text(value: float | None, form: str) -> str:
    return "–" if value is None or not math.isfinite(value) else format(value, form)


def hover_sentence(comparison: Comparison) -> str | None:
    """Return what was taken from the hover of the real flight, or None."""
    tuning = comparison.tuning
    if tuning is None:
        return None
    x, y, z = (1e4 * torque for torque in tuning.trim_torque)
    return (
        f"from {tuning.hover_seconds:.1f} s of its hover: thrust scale {tuning.thrust_scale:.3f}, "
        f"trim ({x:.1f}, {y:.1f}, {z:.1f}) 1e-4 N m, {tuning.hover_voltage:.2f} V; logs come "
        f"{1000 * tuning.log_lag:.0f} ms after the truth"
    )


def remarks_of(comparison: Comparison) -> list[str]:
    """Return what was repaired in the log, and what could not be compared."""
    lag = comparison.chain.lag_s
    late = [f"the shift of {1000 * lag:.0f} ms is at the end of the searched range"] if abs(lag) > 0.295 else []
    return [*comparison.flight.notes, *comparison.problems, *late]


def write_results(comparison: Comparison, folder: Path, about: dict[str, str]) -> Path:
    """Write picture, page and summary; returns the page.

    Args:
        comparison: What was found.
        folder: Where to; it is made.
        about: What flew, for the page, by name.

    Raises:
        OSError: If it cannot be written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    draw_chain(comparison.chain, comparison.flight.name, folder / PICTURE)
    told = {**about, "version": __version__}
    summary = {
        "flight": comparison.flight.name,
        "drone": comparison.drone,
        "commands": comparison.commands,
        "compared_s": list(comparison.phases.compared),
        "figures": comparison.figures,
        "remarks": remarks_of(comparison),
        "about": told,
    }
    with replacing(folder / SUMMARY) as path:
        path.write_text(json.dumps(_plain(summary), indent=1) + "\n", encoding="utf-8")
    environment = Environment(
        loader=PackageLoader("crazychoir_fw.comparison", "."),
        undefined=StrictUndefined,
        autoescape=select_autoescape(["jinja"], default=True),
    )
    begin, end = comparison.phases.compared
    text = environment.get_template("report.html.jinja").render(
        flight=comparison.flight.name,
        commands=comparison.commands,
        begin=f"{begin:.1f}",
        end=f"{end:.1f}",
        rows=rows_of(comparison),
        hover=hover_sentence(comparison),
        remarks=remarks_of(comparison),
        about=told,
        picture=base64.b64encode((folder / PICTURE).read_bytes()).decode(),
    )
    with replacing(folder / PAGE) as path:
        path.write_text(text, encoding="utf-8")
    return folder / PAGE


def _plain(value: Any) -> Any:
    """Return what JSON can hold: numbers that are not finite are null."""
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value
