"""The whole comparison of two providers: tables, functions, flights, and what is to be said about all of it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

from crazychoir_fw.common.errors import CrazychoirError
from crazychoir_fw.common.version import __version__
from crazychoir_fw.onboard import core
from crazychoir_fw.parity.cases import all_cases
from crazychoir_fw.parity.deviation import Verdict, overall
from crazychoir_fw.parity.fleet import FLEET, Member
from crazychoir_fw.parity.flights import Disturb, compare_flights
from crazychoir_fw.parity.functions import Comparison, compare_functions
from crazychoir_fw.parity.inputs import Inputs, record
from crazychoir_fw.parity.side import Side
from crazychoir_fw.parity.tables import Tables, compare_tables
from crazychoir_fw.parity.tolerances import FLIGHT, OWN_LOOP, REPLAY, WHOLE, Tolerance

Progress = Callable[[str, float], None]
"""Told what is at work and which share of it is done, in [0, 1]."""


@dataclass
class Parity:
    """Everything that was found out."""

    reference: dict[str, Any]
    """Identity of the provider that is right by definition."""
    candidate: dict[str, Any]
    """Identity of the other one."""
    platform: str
    seconds: float
    """How long was flown (s)."""
    seed: int
    inputs: dict[str, Any]
    """``sha256`` of what was recorded, and what is known about it."""
    tables: Tables
    functions: list[Comparison]
    flights: list[Comparison]
    aligned: dict[str, float] = field(default_factory=dict)
    """Parameters of the candidate that were set to the reference's factory values."""
    functions_of: str | None = None
    """Whose functions were asked in place of the candidate's, if not its own."""

    @property
    def comparisons(self) -> list[Comparison]:
        """Functions and flights."""
        return [*self.functions, *self.flights]

    @property
    def verdict(self) -> Verdict:
        """Different, equal within tolerance or identical; what is missing on one side has no say."""
        return overall([self.tables.verdict, *(comparison.verdict for comparison in self.comparisons)])

    @property
    def exit_code(self) -> int:
        """0 when equal within tolerance, 1 when different."""
        return int(self.verdict is Verdict.DIFFERENT)

    def counts(self, comparisons: Sequence[Comparison] | None = None) -> dict[str, int]:
        """Return how many comparisons came to each verdict."""
        found = Counter(item.verdict for item in (self.comparisons if comparisons is None else comparisons))
        words = (Verdict.IDENTICAL, Verdict.EQUAL, Verdict.DIFFERENT, Verdict.MISSING)
        return {verdict.value: found[verdict] for verdict in words}

    def modules(self) -> dict[str, Verdict]:
        """Return the verdict on every module around the algorithms: that of the flights which it decides."""
        names = dict.fromkeys(name for flight in self.flights for name in flight.modules)
        return {name: overall([one.verdict for one in self.flights if name in one.modules]) for name in names}

    def groups(self) -> dict[str, list[Comparison]]:
        """Return the comparisons by group, in order."""
        found: dict[str, list[Comparison]] = {}
        for comparison in self.comparisons:
            found.setdefault(comparison.group, []).append(comparison)
        return found

    def as_json(self) -> dict[str, Any]:
        """Return everything as plain data; numbers that JSON does not know are null."""
        return {
            "report": "crazychoir-fw firmware parity",
            "version": __version__,
            "verdict": self.verdict.value,
            "counts": self.counts(),
            "reference": self.reference,
            "candidate": self.candidate,
            "platform": self.platform,
            "seconds": self.seconds,
            "seed": self.seed,
            "inputs": self.inputs,
            "aligned_parameters": self.aligned,
            "tables": self.tables.as_json(),
            "functions_of": self.functions_of,
            "functions": [comparison.as_json() for comparison in self.functions],
            "flights": [comparison.as_json() for comparison in self.flights],
            "modules": {name: verdict.value for name, verdict in self.modules().items()},
            "tolerances": {
                "replay": [_tolerance(row) for row in (*REPLAY, WHOLE)],
                "flight": [_tolerance(row) for row in FLIGHT],
                "own_loop": [_tolerance(row) for row in OWN_LOOP],
            },
        }


def _tolerance(row: Tolerance) -> dict[str, Any]:
    return {
        "class": row.name,
        "signals": list(row.patterns),
        "absolute": row.absolute,
        "unit": row.unit,
        "ulps": row.ulps,
        "relative": row.relative,
        "judged": row.is_judged,
        "reason": row.reason,
    }


def run_parity(
    reference: Side,
    candidate: Side,
    seconds: float,
    seed: int = 1,
    inputs: Inputs | None = None,
    has_same_parameters: bool = False,
    flies: bool = True,
    fleet: Sequence[Member] = FLEET,
    disturb: Disturb | None = None,
    progress: Progress | None = None,
    algorithms: Side | None = None,
) -> Parity:
    """Compare two providers.

    Args:
        reference: The side that is right by definition.
        candidate: The other one, on the same platform.
        seconds: How long is flown at most, from the moment when the drones can fly.
        seed: Seed of all noise.
        inputs: What the functions are given; None records flights of the reference.
        has_same_parameters: Give the candidate the reference's factory values first, so that other values do not hide
            other code.
        flies: Whether whole flights are compared as well.
        fleet: The drones.
        disturb: See `compare_flights`.
        progress: Told how far the comparison is.
        algorithms: Whose functions are asked in place of the candidate's: where the modules around them are the
            checkout's as well, single functions are not booted. None asks the candidate.

    Raises:
        CrazychoirError: If the inputs were recorded on another platform.
    """
    tell = progress or (lambda what, share: None)
    tables = compare_tables(reference, candidate)
    aligned = _align(reference, candidate, tables) if has_same_parameters else {}
    if inputs is None:
        inputs = record(reference, seconds, seed, fleet, lambda share: tell("recording flights", share))
    elif inputs.metadata.get("platform") != reference.platform:
        raise CrazychoirError(
            f"the inputs were recorded on {inputs.metadata.get('platform')}, the providers are those of "
            f"{reference.platform}: choose --platform {inputs.metadata.get('platform')}"
        )
    functions = compare_functions(
        reference, algorithms or candidate, all_cases(inputs), lambda share: tell("replaying functions", share)
    )
    flights = []
    if flies:
        flights = compare_flights(
            reference, candidate, seconds, seed, fleet, disturb, lambda share: tell("flying in lockstep", share)
        )
    return Parity(
        reference=_identity(reference),
        candidate=_identity(candidate),
        platform=reference.platform,
        seconds=seconds,
        seed=seed,
        inputs={"sha256": inputs.digest, **inputs.metadata},
        tables=tables,
        functions=functions,
        flights=flights,
        aligned=aligned,
        functions_of=None if algorithms is None else _identity(algorithms)["provider"],
    )


def _identity(side: Side) -> dict[str, Any]:
    return {**core.provider_identity(side.number), "number": side.number, "set_parameters": side.parameters}


def _align(reference: Side, candidate: Side, tables: Tables) -> dict[str, float]:
    """Give the candidate the factory values of the reference that differ; return them."""
    differing = {row.name for row in tables.differences if row.what == "factory value"}
    ours = reference.factory_values()
    aligned = {
        name: float(ours[name]) for name in sorted(differing) if not candidate.parameter_table[name].is_read_only
    }
    candidate.parameters = {**aligned, **candidate.parameters}
    return aligned
