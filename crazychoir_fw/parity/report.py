"""Writes what was found out: one HTML page that needs nothing beside itself, and the same as JSON."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from crazychoir_fw.common.replacing import replacing
from crazychoir_fw.parity.deviation import Deviation, Verdict
from crazychoir_fw.parity.functions import Comparison
from crazychoir_fw.parity.plots import plot_svg
from crazychoir_fw.parity.run import Parity
from crazychoir_fw.parity.tolerances import FLIGHT, REPLAY, WHOLE

HTML, JSON = "parity.html", "parity.json"
PLOTS = 16
"""Of so many signals there is a picture, the worst ones of all."""
ROWS = 30
"""So many signals of a comparison are listed in the page; the JSON file has all."""

_MARKS = {
    Verdict.IDENTICAL: "identical",
    Verdict.EQUAL: "equal",
    Verdict.DIFFERENT: "different",
    Verdict.MISSING: "missing",
    Verdict.NOT_JUDGED: "unjudged",
}
_FACTS = (
    "provider",
    "version",
    "content",
    "checkout",
    "platform",
    "features",
    "missing_features",
    "compiler",
    "flags",
    "set_parameters",
)


def write_report(parity: Parity, folder: Path) -> tuple[Path, Path]:
    """Write `parity.html` and `parity.json` into a folder, each in one step, and return their paths."""
    page, data = folder / HTML, folder / JSON
    with replacing(page) as temporary:
        temporary.write_text(html_page(parity), encoding="utf-8")
    with replacing(data) as temporary:
        temporary.write_text(json.dumps(parity.as_json(), indent=1, allow_nan=False) + "\n", encoding="utf-8")
    return page, data


def html_page(parity: Parity) -> str:
    """Return the page."""
    environment = Environment(
        loader=PackageLoader("crazychoir_fw.parity", "."),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {"figure": figure, "mark": _MARKS.__getitem__, "tick": tick, "allowed": allowed}
    return environment.get_template("report.html.jinja").render(
        parity=parity,
        facts=_facts(parity),
        headline=headline(parity),
        plots=_plots(parity),
        rows=ROWS,
        listed=_listed,
        verdicts=[verdict for verdict in Verdict if verdict is not Verdict.NOT_JUDGED],
        tolerances={"Functions on recorded inputs": (*REPLAY, WHOLE), "Flights in lockstep": FLIGHT},
    )


def headline(parity: Parity) -> str:
    """Return the verdict with its reasons in one sentence."""
    counts = {word: count for word, count in parity.counts().items() if count}
    parts = [f"{count} {word}" for word, count in counts.items()]
    values = sum(row.what == "factory value" for row in parity.tables.differences)
    if values:
        parts.append(f"{values} other factory values" if values > 1 else "1 other factory value")
    if parity.tables.missing:
        parts.append(f"{parity.tables.missing} variables on one side only")
    return f"{len(parity.comparisons)} comparisons: {', '.join(parts)}"


def figure(value: float | int | str | None) -> str:
    """Return a number in few digits; nothing is a dash, and what is no number says so."""
    if value is None:
        return "–"
    if isinstance(value, str):
        return value
    if isinstance(value, float) and not math.isfinite(value):
        return "not a number" if math.isnan(value) else "unmatched"
    if isinstance(value, int):
        return f"{value:,}".replace(",", " ")
    return f"{value:.3g}"


def tick(value: int | None, is_by_number: bool) -> str:
    """Return when something happened."""
    if value is None:
        return "–"
    return f"#{value}" if is_by_number else f"{value / 1000:.3f} s"


def allowed(deviation: Deviation) -> str:
    """Return how far a signal may be off, in words."""
    row = deviation.tolerance
    if not row.is_judged:
        return "not judged"
    unit = "count" if row.absolute == 1 and row.unit == "counts" else row.unit
    parts = [f"{row.absolute:g} {unit}".strip()] if row.absolute else []
    parts += [f"{row.ulps} ulps"] if row.ulps and deviation.max_ulps is not None else []
    parts += [f"{row.relative:g} of the largest"] if row.relative else []
    return " or ".join(parts) or "0"


def _listed(comparison: Comparison) -> list[Deviation]:
    """Return the signals of a comparison that deviate, the worst ones of too many."""
    return [deviation for deviation in comparison.deviations if deviation.deviating][:ROWS]


def _facts(parity: Parity) -> list[tuple[str, str, str]]:
    """Return what is known of both providers, side by side."""
    rows = []
    for name in _FACTS:
        values = [_words(identity.get(name)) for identity in (parity.reference, parity.candidate)]
        if any(values):
            rows.append((name.replace("_", " "), *values))
    return rows


def _words(value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, dict):
        return ", ".join(f"{key} = {item}" for key, item in value.items())
    return ", ".join(map(str, value)) if isinstance(value, (list, tuple)) else str(value)


def _plots(parity: Parity) -> dict[tuple[str, str], list[tuple[str, Markup]]]:
    """Return pictures of the worst signals of all: by group and name of the comparison, (signal, SVG)."""
    candidates = [
        (deviation, comparison)
        for comparison in parity.comparisons
        for deviation in comparison.deviations
        if deviation.signal in comparison.traces
    ]
    candidates.sort(key=lambda item: item[0].severity, reverse=True)
    found: dict[tuple[str, str], list[tuple[str, Markup]]] = {}
    for deviation, comparison in candidates[:PLOTS]:
        title = f"{comparison.group} {comparison.name}: {deviation.signal}"
        svg = plot_svg(comparison.traces[deviation.signal], deviation.tolerance, comparison.is_by_number, title)
        found.setdefault((comparison.group, comparison.name), []).append((deviation.signal, Markup(svg)))
    return found
