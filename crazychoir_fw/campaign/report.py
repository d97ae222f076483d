"""Writes what a campaign says: report.html (needs nothing beside itself), summary.json, junit.xml, flights.csv."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from crazychoir_fw.campaign.compare import Comparison, culprits
from crazychoir_fw.campaign.flight import CRASHED, MARGIN, Record
from crazychoir_fw.campaign.run import Outcome
from crazychoir_fw.campaign.sensitivity import FAILED, Influence, influences
from crazychoir_fw.campaign.table import hash_of
from crazychoir_fw.campaign.verdict import GO, NO_GO, figures_table
from crazychoir_fw.campaign.worst import worst_of
from crazychoir_fw.common.replacing import replacing
from crazychoir_fw.onboard.core import identity

_TONES = {GO: "good", NO_GO: "bad"}
_ROWS, _HISTOGRAMS, _PAIRS, _JUNIT = 20, 6, 4, 1000
_SHOWN_CULPRITS = 10


def write_results(outcome: Outcome) -> Path:
    """Write all files into the folder of a campaign, each in one step; returns the page."""
    folder = outcome.folder
    found = influences(outcome.campaign, outcome.records)
    found = sorted(found, key=lambda one: one.figure not in (FAILED, MARGIN))
    texts = {
        "report.html": _page(outcome, found),
        "summary.json": json.dumps(summary_of(outcome, found), indent=2, allow_nan=False) + "\n",
        "junit.xml": junit_of(outcome),
        "flights.csv": csv_of(outcome.records),
    }
    for name, text in texts.items():
        with replacing(folder / name) as temporary:
            temporary.write_text(text, encoding="utf-8")
    return folder / "report.html"


def summary_of(outcome: Outcome, found: Sequence[Influence]) -> dict[str, Any]:
    """Return the content of summary.json."""
    verdict, settings = outcome.verdict, outcome.campaign.settings
    return {
        "campaign": outcome.campaign.name,
        "mission": str(outcome.campaign.mission_file),
        "file": str(outcome.campaign.file),
        "identity": outcome.identity,
        "answer": verdict.answer,
        "reasons": list(verdict.reasons),
        "flights": verdict.flown,
        "passed": verdict.passed,
        "crashed": verdict.crashed,
        "interval": [round(end, 6) for end in verdict.interval],
        "proven": round(verdict.lower, 6),
        "require": settings.require.model_dump(),
        "quantiles": [{**vars(one), "value": _finite(one.value)} for one in verdict.quantiles],
        "influences": [vars(one) for one in found[:_ROWS]],
        "worst": [record.number for record in worst_of(outcome.records)],
        "hash": hash_of(outcome.records),
        "design": settings.design,
        "seed": settings.seed,
        "build": identity(),
    }


def write_comparison(both: Comparison, folder: Path) -> Path:
    """Write compare.html and compare.json; returns the page."""
    named = culprits(both)
    page = (
        _environment()
        .get_template("compare.html.jinja")
        .render(both=both, tone=_TONES.get(both.answer, "open"), culprits=named[:_SHOWN_CULPRITS])
    )
    content = {
        "answer": both.answer,
        "sentence": both.sentence,
        "broken": both.broken,
        "mended": both.mended,
        "p": both.p,
        "differences": [vars(one) for one in both.differences],
        "culprits": [vars(one) for one in named],
    }
    for name, text in (("compare.html", page), ("compare.json", json.dumps(content, indent=2) + "\n")):
        with replacing(folder / name) as temporary:
            temporary.write_text(text, encoding="utf-8")
    return folder / "compare.html"


def _finite(value: float | None) -> float | None:
    return value if value is not None and math.isfinite(value) else None


def junit_of(outcome: Outcome) -> str:
    """Return the verdict and the flights as continuous integration reads them."""
    records, verdict = outcome.records[:_JUNIT], outcome.verdict
    suite = ElementTree.Element("testsuite", name=outcome.campaign.name, tests=str(len(records) + 1))
    case = ElementTree.SubElement(suite, "testcase", classname=outcome.campaign.name, name="verdict")
    if verdict.answer != GO:
        ElementTree.SubElement(case, "failure", message=verdict.answer).text = "\n".join(verdict.reasons)
    for record in records:
        name = f"flight {record.number}"
        case = ElementTree.SubElement(
            suite, "testcase", classname=outcome.campaign.name, name=name, time=f"{record.wall_seconds:.3f}"
        )
        if record.outcome == CRASHED:
            ElementTree.SubElement(case, "error", message=_clean("; ".join(record.failures)))
        elif not record.passed:  # a campaign may be GO with failures
            ElementTree.SubElement(case, "skipped", message=_clean("; ".join(record.failures)))
    ElementTree.indent(suite)
    return ElementTree.tostring(suite, encoding="unicode", xml_declaration=True) + "\n"


def _clean(text: str) -> str:
    """Return a text without characters that XML does not know."""
    return "".join(letter for letter in text if letter.isprintable())


def csv_of(records: Sequence[Record]) -> str:
    """Return all flights, a row each."""
    values = dict.fromkeys(key for record in records for key in record.values)
    figures = dict.fromkeys(name for record in records for name in record.figures)
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["flight", "outcome", *values, *figures, "failures"])
    for record in records:
        row = [record.values.get(key, "") for key in values] + [record.figures.get(name, "") for name in figures]
        writer.writerow([record.number, record.outcome, *row, "; ".join(record.failures)])
    return text.getvalue()


# -------------------------------------------------------------------------------- the page


def _page(outcome: Outcome, found: Sequence[Influence]) -> str:
    campaign, by_number = outcome.campaign, outcome.campaign.rows()
    worst = [(one, campaign.job(one.number, by_number[one.number]).command) for one in worst_of(outcome.records)]
    return (
        _environment()
        .get_template("report.html.jinja")
        .render(
            campaign=campaign,
            verdict=outcome.verdict,
            tone=_TONES.get(outcome.verdict.answer, "open"),
            seconds=sum(record.sim_seconds for record in outcome.records),
            influences=found[:_ROWS],
            has_sobol=any(one.total is not None for one in found),
            plots=[Markup(svg) for svg in _plots(outcome, found)],
            worst=worst,
            folder=outcome.folder,
            facts=_facts(outcome),
        )
    )


def _environment() -> Environment:
    environment = Environment(
        loader=PackageLoader("crazychoir_fw.campaign", "."), autoescape=True, undefined=StrictUndefined
    )
    environment.filters["figure"] = lambda value: "–" if value is None else f"{value:.4g}"
    return environment


def _facts(outcome: Outcome) -> list[tuple[str, Any]]:
    campaign = outcome.campaign
    providers = ", ".join(sorted({drone.provider for drone in campaign.mission.fleet}))
    return [
        ("mission", campaign.mission_file),
        ("provider", campaign.variant.provider or providers),
        ("seed", campaign.settings.seed),
        ("design", campaign.settings.design),
        *identity().items(),
        ("hash of the table", hash_of(outcome.records)),
    ]


def _plots(outcome: Outcome, found: Sequence[Influence]) -> Iterable[str]:
    """Yield histograms of figures with their limits, then the most telling pairs of values with failures marked."""
    limits = _limits(outcome)
    table = figures_table(outcome.records)
    first = [name for name in limits if name in table]
    others = [name for name in table if name not in limits and name not in ("sim_seconds", "margin")]
    for name in [*first, *others][:_HISTOGRAMS]:
        known = table[name][np.isfinite(table[name])]
        if len(known):
            yield _histogram(name, known, limits.get(name, []))
    for x, y in _telling_pairs(outcome, found):
        yield _pair(outcome.records, x, y)


def _limits(outcome: Outcome) -> dict[str, list[float]]:
    found: dict[str, list[float]] = {}
    for name, limit in outcome.campaign.settings.quantiles.items():
        found[name] = [end for end in (limit.max, limit.min) if end is not None]
    criteria = getattr(outcome.campaign.mission, "criteria", None)
    for name, limit in ({} if criteria is None else criteria.model_dump()).items():
        if isinstance(limit, float):
            found.setdefault(name, []).append(limit)
    return found


def _telling_pairs(outcome: Outcome, found: Sequence[Influence]) -> list[tuple[str, str]]:
    failed = any(not record.passed for record in outcome.records)
    ranked = dict.fromkeys(one.key for one in found if one.figure == (FAILED if failed else "margin") or not failed)
    keys = list(ranked)[:4]
    return [(x, y) for k, x in enumerate(keys) for y in keys[k + 1 :]][:_PAIRS]


def _histogram(name: str, values: np.ndarray, limits: Sequence[float]) -> str:
    def draw(axes: Any) -> None:
        axes.hist(values, bins=min(30, max(5, int(np.sqrt(len(values))))), color="#2766b8")
        for limit in limits:
            axes.axvline(limit, color="#c0352b", linestyle="--")
        axes.set_xlabel(name)
        axes.set_ylabel("flights")

    return _svg(draw)


def _pair(records: Sequence[Record], x: str, y: str) -> str:
    def draw(axes: Any) -> None:
        for passed, color, marker in ((True, "#2766b8", "."), (False, "#c0352b", "x")):
            chosen = [record for record in records if record.passed == passed and x in record.values]
            axes.plot(
                [one.values[x] for one in chosen], [one.values[y] for one in chosen], marker, color=color, markersize=5,
                label="succeeded" if passed else "failed",
            )  # fmt: skip
        axes.set_xlabel(x)
        axes.set_ylabel(y)
        axes.legend(fontsize=7)

    return _svg(draw)


def _svg(draw: Any) -> str:
    """Return a small plot as SVG that fits into a page."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(4.0, 2.8), layout="constrained")
    axes = figure.add_subplot()
    axes.tick_params(labelsize=7)
    draw(axes)
    axes.xaxis.label.set_fontsize(8)
    axes.yaxis.label.set_fontsize(8)
    text = io.StringIO()
    figure.savefig(text, format="svg", metadata={"Date": None})
    return text.getvalue()[text.getvalue().index("<svg") :]
