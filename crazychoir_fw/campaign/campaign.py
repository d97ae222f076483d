"""A campaign file as data: which mission, how many flights, what varies, and when the answer is GO."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import yaml
from pydantic import Field, ValidationError

from crazychoir_fw.campaign.design import DESIGNS, MAX_FLIGHTS, check_correlation, correlate, shares
from crazychoir_fw.campaign.spread import Varied, default_spread
from crazychoir_fw.common.constraints import choice, number, switch, whole
from crazychoir_fw.common.errors import MissionError
from crazychoir_fw.firmware.checkout import VARIABLE
from crazychoir_fw.mission.distributions import read_distribution
from crazychoir_fw.mission.documents import read_all, read_file
from crazychoir_fw.mission.fleet import Layout
from crazychoir_fw.mission.loader import load_mission, sentence_of
from crazychoir_fw.mission.schema import Mission
from crazychoir_fw.mission.section import Section
from crazychoir_fw.mission.wording import show
from crazychoir_fw.onboard.vehicles import parameters

FLIGHTS = 100
"""Flights of a campaign that does not say."""

SIMULATED = "sim"
"""Backend of flights whose mission names real drones."""

_VEHICLE_ENTRY = re.compile(r"(?P<list>(?P<drone>.+)\.vehicle\.(?P<name>[^\[\]]+))\[(?P<axis>\d)\]")


class Require(Section):
    """When a campaign is GO."""

    success: Annotated[float, number(0.0, 0.999999)] = 0.95
    """Share of flights that must succeed."""

    confidence: Annotated[float, number(0.5, 0.999999)] = 0.95
    """Confidence of the statement that they do: the interval is that of Clopper and Pearson, one-sided."""


class QuantileLimit(Section):
    """What a figure may be in most flights."""

    quantile: Annotated[float, number(0.0, 1.0)] = 0.95
    """Which share of flights must keep the limit."""

    max: Annotated[float, number(-1e9, 1e9)] | None = None
    """Largest value of the figure there."""

    min: Annotated[float, number(-1e9, 1e9)] | None = None
    """Least value of the figure in that share of flights."""


class EarlyStop(Section):
    """When a campaign ends before its last flight: the sequential probability ratio test of Wald."""

    margin: Annotated[float, number(0.0001, 0.5)] = 0.02
    """Half width about `require.success` within which either answer is right."""

    error: Annotated[float, number(1e-6, 0.49)] = 0.05
    """Probability of a wrong answer outside of the margin, of either kind."""


class Search(Section):
    """Look for the smallest deviation that makes a flight fail."""

    budget: Annotated[int, whole(1, 100_000)] = 200
    """Flights of the search."""


class Correlated(Section):
    """Values that go together."""

    keys: Annotated[list[str], Field(min_length=2)]
    """Their key paths, as under `vary`."""

    correlation: Any
    """Of each pair of them."""


class Variant(Section):
    """One side of a comparison."""

    mission: str | None = None
    """Mission file, instead of that of the campaign."""

    provider: str | None = None
    """Provider of all drones."""

    app: list[str] | None = None
    """C files that all drones carry."""

    checkout: str | None = None
    """Folder of the firmware's checkout, for provider `bitcraze`; otherwise that of CRAZYFLIE_FIRMWARE."""

    revision: str | None = None
    """Revision of the checkout's repository; its files are copied out, and the user's tree is left alone."""

    set: list[str] = Field(default_factory=list)
    """Values that are changed, as `--set` takes them."""


class Compare(Section):
    """Two of anything, flown on the same variations and seeds."""

    before: Variant = Variant()
    after: Variant = Variant()


class CampaignFile(Section):
    """What may stand in a campaign file."""

    extends: str
    """Mission file, seen from this file."""

    name: str | None = None
    """Name of the campaign and of its folder; otherwise that of the file."""

    description: str = ""

    flights: Annotated[int, whole(1, MAX_FLIGHTS)] = FLIGHTS
    """How many flights."""

    seed: Annotated[int, whole(0, 2**32 - 1)] = 0
    """Of the variations and of the seeds of the flights."""

    design: Annotated[str, choice(*DESIGNS)] = "monte_carlo"
    """How variations are laid out."""

    set: list[str] = Field(default_factory=list)
    """Values that are changed in all flights, as `--set` takes them."""

    vary: Mapping[str, Any] | None = None
    """Distributions by key path; without it, the spread of real vehicles (`spread.py`)."""

    correlated: list[Correlated] = Field(default_factory=list)
    """Groups of values that go together."""

    require: Require = Require()
    """When the answer is GO."""

    quantiles: Mapping[str, QuantileLimit] = Field(default_factory=dict)
    """Limits of figures of `summary.json` that most flights must keep, by name."""

    early_stop: EarlyStop | Annotated[bool, switch()] = False
    """End as soon as the answer is clear."""

    search: Search | None = None
    """Look for the worst instead of flying a design."""

    compare: Compare | None = None
    """Fly two variants and say what differs."""


@dataclass(frozen=True)
class Job:
    """One flight, as plain data: it travels to other processes and machines."""

    number: int
    mission: str
    """The mission file."""
    seed: int
    changes: tuple[str, ...]
    """As `--set` takes them."""
    provider: str | None = None
    app: tuple[str, ...] | None = None
    checkout: str | None = None
    """Folder of the firmware's checkout."""
    backend: str | None = None
    """Instead of the mission's, see `backend_of`."""

    @property
    def command(self) -> str:
        """The command that flies it again, alone."""
        import shlex

        words = [] if self.checkout is None else [f"{VARIABLE}={self.checkout}"]
        words += ["crazychoir", "fly", self.mission, "--seed", str(self.seed)]
        for change in self.changes:
            words += ["--set", change]
        if self.provider is not None:
            words += ["--provider", self.provider]
        for file in self.app or ():
            words += ["--app", file]
        if self.backend is not None:
            words += ["--backend", self.backend]
        return shlex.join(words)


@dataclass(frozen=True)
class Campaign:
    """What flies, decided."""

    name: str
    file: Path
    """The campaign file, or the mission file that it was made of."""
    mission_file: Path
    mission: Mission
    """The nominal mission."""
    settings: CampaignFile
    varied: tuple[Varied, ...]
    groups: tuple[tuple[tuple[str, ...], float], ...] = ()
    base: tuple[str, ...] = ()
    """Changes of all flights."""
    variant: Variant = field(default_factory=Variant)
    checkout: str | None = None
    """Folder of the firmware's checkout, if the variant names one."""
    backend: str | None = None
    """Instead of the mission's, see `backend_of`."""

    def rows(self) -> list[dict[str, Any]]:
        """Return the varied values of all flights, by key."""
        drawn = shares(self.settings.design, self.settings.flights, len(self.varied), self.settings.seed)
        return [self.values_at(row) for row in correlate(drawn, self.varied, self.groups)]

    def values_at(self, row: Sequence[float]) -> dict[str, Any]:
        """Return the varied values at shares of their distributions."""
        return {one.key: one.distribution.at(float(share)) for one, share in zip(self.varied, row, strict=True)}

    def job(self, number: int, values: Mapping[str, Any]) -> Job:
        """Return the flight of a number with these values; its seed depends on campaign and number alone."""
        seed = int(np.random.SeedSequence((self.settings.seed, number)).generate_state(1)[0])
        if "seed" in values:
            values = dict(values)
            seed = int(values.pop("seed"))
        changes = (*self.base, *self.settings.set, *self.variant.set, *self._changes(values))
        mission = self.mission_file if self.variant.mission is None else self.file.parent / self.variant.mission
        app = None if self.variant.app is None else tuple(str(self.file.parent / one) for one in self.variant.app)
        return Job(number, str(mission), seed, changes, self.variant.provider, app, self.checkout, self.backend)

    def _changes(self, values: Mapping[str, Any]) -> list[str]:
        """Return values as changes; those of one list of a vehicle's numbers are one change."""
        found: dict[str, Any] = {}
        for key, value in values.items():
            entry = _VEHICLE_ENTRY.fullmatch(key)
            if entry is None:
                found[key] = value
            else:
                numbers = found.setdefault(entry["list"], self._nominal_list(entry["drone"], entry["name"]))
                numbers[int(entry["axis"])] = value
        return [f"{key}={_flow(value)}" for key, value in found.items()]

    def _nominal_list(self, drone: str, name: str) -> list[float]:
        """Return what the mission says of a vehicle's list of numbers, or its platform."""
        place = re.fullmatch(r"drones\[(\d+)\]", drone)
        first = self.mission.fleet[int(place[1]) if place else 0]
        value = first.vehicle.get(name, parameters(first.platform)[name].value)
        return list(value)


def _flow(value: Any) -> str:
    """Return a value as YAML on one line, with all its digits."""
    if type(value) is float and math.isfinite(value):  # as most are: the emitter takes 0.5 ms
        text = repr(value)
        return text if "." in text else text.replace("e", ".0e")
    if type(value) is list and value and all(type(entry) is float for entry in value):
        return f"[{', '.join(map(_flow, value))}]"
    return yaml.safe_dump(value, default_flow_style=True, width=1_000_000).strip().removesuffix("\n...")


def load_campaign(path: Path, changes: Sequence[str] = (), **overrides: Any) -> Campaign:
    """Read a campaign file, or make a campaign of a mission file, and check all that can be checked before flights.

    Args:
        path: The file.
        changes: Changes of the mission, as `--set` takes them.
        overrides: ``flights``, ``seed`` or ``design``, stronger than the file; None leaves the file alone.

    Raises:
        MissionError: With one sentence that names file, key, value and what is allowed.
    """
    data = read_file(path)
    if not isinstance(data, Mapping):
        raise MissionError(f"{path} is {show(data)}, but must be a mapping such as extends: and flights:")
    is_mission = "drones" in data or "flight" in data
    given = {} if is_mission else dict(data)
    given |= {key: value for key, value in overrides.items() if value is not None}
    if is_mission:
        given["extends"] = path.name
    try:
        settings = CampaignFile.model_validate(given)
    except ValidationError as error:
        raise MissionError(f"{path}: {sentence_of(error)}") from None
    mission_file = path.parent / settings.extends
    all_changes = [*settings.set, *changes]
    backend = backend_of(mission_file, all_changes)
    nominal = load_mission(mission_file, changes=all_changes, backend=backend)
    base = tuple(changes)
    if isinstance(nominal.drones, Layout):
        base = (f"drones={_flow(_listed(nominal.drones))}", *base)
    try:
        varied, groups = _varied(nominal, settings)
    except MissionError as error:
        raise MissionError(f"{path}: {error}") from None
    name = settings.name or (nominal.name if is_mission else path.stem)
    return Campaign(name, path, mission_file, nominal, settings, varied, groups, base, backend=backend)


def backend_of(mission: Path, changes: Sequence[str]) -> str | None:
    """Return `SIMULATED` for a mission of real drones, which a campaign never moves; None leaves it its own.

    Raises:
        MissionError: If the file cannot be read.
    """
    data = read_all(read_file(mission), str(mission), mission.parent, changes).data
    return SIMULATED if data.get("backend") in ("hardware", "mixed") else None


def load_job(job: Job) -> Mission:
    """Return the mission of a flight.

    Raises:
        MissionError: If it cannot be flown.
    """
    return load_mission(
        job.mission, changes=job.changes, seed=job.seed, provider=job.provider, app=job.app, backend=job.backend
    )


def _listed(layout: Layout) -> list[dict[str, Any]]:
    """Return the drones of a layout one by one, so that each can be varied."""
    return [
        {key: list(value) if isinstance(value, tuple) else value
         for key, value in entry.model_dump(exclude_none=True, exclude_defaults=True).items()}
        for entry in layout.entries()
    ]  # fmt: skip


def _varied(
    nominal: Mission, settings: CampaignFile
) -> tuple[tuple[Varied, ...], tuple[tuple[tuple[str, ...], float], ...]]:
    if settings.vary is None:
        varied = default_spread(nominal)
    else:
        varied = [Varied(str(key), read_distribution(f"vary.{key}", one)) for key, one in settings.vary.items()]
    known, groups = {one.key for one in varied}, []
    for number_, group in enumerate(settings.correlated):
        where = f"correlated[{number_}]"
        for key in group.keys:
            if key not in known:
                raise MissionError(f"{where}.keys names '{key}', but must name keys of vary")
        rho = check_correlation(f"{where}.correlation", len(group.keys), group.correlation)
        groups.append((tuple(group.keys), rho))
    return tuple(varied), tuple(groups)


def check_ends(campaign: Campaign) -> None:
    """Refuse variations that the mission does not allow: each value at both ends of its distribution.

    Raises:
        MissionError: Naming the key and what is allowed.
    """
    middle = [0.5] * len(campaign.varied)
    for column, varied in enumerate(campaign.varied):
        for share in (0.0, 1.0):
            row = [*middle]
            row[column] = share
            job = campaign.job(0, campaign.values_at(row))
            try:
                load_job(job)
            except MissionError as error:
                raise MissionError(
                    f"{campaign.file}: vary.{varied.key} reaches {show(varied.distribution.at(share))}: {error}"
                ) from None
