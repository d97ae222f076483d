"""A folder of flights that failed once: all of them must succeed."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated

from pydantic import Field, ValidationError

from crazychoir_fw.campaign.campaign import Job, backend_of
from crazychoir_fw.campaign.engines import Engine
from crazychoir_fw.campaign.flight import Record
from crazychoir_fw.common.constraints import whole
from crazychoir_fw.common.errors import MissionError
from crazychoir_fw.mission.documents import read_file
from crazychoir_fw.mission.loader import sentence_of
from crazychoir_fw.mission.section import Section
from crazychoir_fw.mission.wording import show


class FlightFile(Section):
    """One flight that failed once."""

    regression: list[str]
    """Why it failed."""
    mission: str
    """Mission file, seen from this file."""
    seed: Annotated[int, whole(0, 2**32 - 1)]
    set: list[str] = Field(default_factory=list)
    provider: str | None = None
    app: list[str] | None = None


def read_flights(folder: Path) -> dict[Path, Job]:
    """Return the flights of a folder by their files.

    Raises:
        MissionError: If it has none, or a file is none.
    """
    found: dict[Path, Job] = {}
    for number, path in enumerate(sorted(folder.glob("*.yaml"))):
        data = read_file(path)
        if not isinstance(data, Mapping) or "regression" not in data:
            raise MissionError(f"{path} is {show(data)}, but must be a flight that a search has found")
        try:
            given = FlightFile.model_validate(data)
        except ValidationError as error:
            raise MissionError(f"{path}: {sentence_of(error)}") from None
        app = None if given.app is None else tuple(given.app)
        mission = path.parent / given.mission
        found[path] = Job(
            number, str(mission), given.seed, tuple(given.set), given.provider, app,
            backend=backend_of(mission, given.set),
        )  # fmt: skip
    if not found:
        raise MissionError(f"{folder} has no flights, such as name.yaml, that a search has found")
    return found


def fly_again(flights: Mapping[Path, Job], engine: Engine) -> dict[Path, Record]:
    """Fly all of them; returns records by file."""
    paths = {job.number: path for path, job in flights.items()}
    records = engine((job, {}) for job in flights.values())
    return {paths[record.number]: record for record in sorted(records, key=lambda one: one.number)}
