"""Writes a commented campaign file beside a mission: a starting point that flies at once."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path

from jinja2 import Environment, PackageLoader, StrictUndefined

from crazychoir_fw.campaign.campaign import backend_of
from crazychoir_fw.campaign.spread import Varied, default_spread
from crazychoir_fw.common.errors import StateError
from crazychoir_fw.mission.distributions import Distribution
from crazychoir_fw.mission.loader import load_mission
from crazychoir_fw.mission.schema import LayeredMission, Mission


def write_campaign(mission_file: Path, out: Path | None = None) -> Path:
    """Write a campaign file; returns its path.

    Args:
        mission_file: The mission that it flies.
        out: The file; otherwise NAME_campaign.yaml beside the mission.

    Raises:
        MissionError: If the mission cannot be flown.
        StateError: If the file is there already.
        OSError: If it cannot be written.
    """
    mission = load_mission(mission_file, backend=backend_of(mission_file, ()))
    path = out or mission_file.with_name(f"{mission_file.stem}_campaign.yaml")
    spread = default_spread(mission)
    first = [one for one in spread if one.key.startswith("drones[0].")]
    environment = Environment(loader=PackageLoader("crazychoir_fw.campaign", "."), undefined=StrictUndefined)
    text = environment.get_template("campaign.yaml.jinja").render(
        mission=mission.name,
        extends=json.dumps(_seen_from(mission_file, path.parent)),
        lines=_lines(first),
        others=len(spread) - len(first),
        limits=list(_limits(mission)),
    )
    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(text)
    except FileExistsError:
        raise StateError(f"{path} is there already, and stays as it is: give another name with --out") from None
    return path


def _seen_from(file: Path, folder: Path) -> str:
    """Return a file as it is named in another one: relative where it lies below, as a whole elsewhere."""
    file, folder = file.resolve(), folder.resolve()
    return str(file.relative_to(folder) if file.is_relative_to(folder) else file)


def _limits(mission: Mission) -> Iterator[str]:
    """Yield quantiles with the limits that each flight has anyway."""
    for name, limit in mission.criteria if isinstance(mission, LayeredMission) else ():
        if isinstance(limit, int | float) and not isinstance(limit, bool):
            yield f"{name}: {{quantile: 0.95, {'min' if name.startswith('min_') else 'max'}: {limit:g}}}"


def _lines(spread: Sequence[Varied]) -> list[str]:
    return [f"{one.key}: {written(one.distribution)}  # {' '.join(one.source.split())}" for one in spread]


def written(distribution: Distribution) -> str:
    """Return a distribution as it stands in a campaign file, on one line."""
    numbers = distribution.numbers
    if distribution.kind == "choice":
        return f"{{choice: {json.dumps(list(distribution.options))}}}"
    if distribution.kind == "normal":
        inner = f"normal: {{mean: {numbers[0]:.6g}, std: {numbers[1]:.6g}}}"
    else:
        inner = f"{distribution.kind}: [{', '.join(f'{number:.6g}' for number in numbers)}]"
    ends = {"low": distribution.low, "high": distribution.high}
    cut = [f"{key}: {end:.6g}" for key, end in ends.items() if abs(end) != float("inf")]
    return f"{{{', '.join([inner, *cut])}}}"
