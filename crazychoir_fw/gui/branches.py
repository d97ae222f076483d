"""The past of a flight: where drones were, and moments to go back to; one branch for each future that was flown."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.errors import StateError

if TYPE_CHECKING:
    from crazychoir_fw.common.checkpoint import Checkpoint
    from crazychoir_fw.flight.start_transit import StartTransit
    from crazychoir_fw.gui.flying import Flying
    from crazychoir_fw.gui.mission_run import MissionRun

MAX_MOMENTS = 400
"""Of a branch: when there are more, every second one is forgotten."""
MAX_BRANCHES = 8
_MAX_SAMPLES = 36_000  # an hour at 10 Hz


class Sample(NamedTuple):
    """What N drones did at an instant."""

    position: NDArray[np.float32]
    """(N, 3), m, world."""
    orientation: NDArray[np.float32]
    """(N, 4), xyzw."""
    velocity: NDArray[np.float32]
    """(N, 3), m/s, world; NaN where no velocity is known."""
    reference: NDArray[np.float32]
    """(N, 3), m, world; NaN where there is none."""
    watched: dict[tuple[int, str], float] | None
    """Log variables that a browser plotted then, by drone and name."""


class SampleStream(Protocol):
    """Where samples are written while the drones fly."""

    def sample(self, session: Any, time: float, sample: Sample) -> None:
        """Take a sample of a session."""

    def begin_again(self, samples: Iterable[tuple[float, Sample]]) -> None:
        """Go on after a rewind."""


@dataclass
class Moment:
    """An instant to go back to."""

    time: float
    checkpoint: Checkpoint | None
    """What the flight was."""
    flying: Flying | StartTransit | MissionRun | None
    """The curves, or the mission, that were on their way."""


@dataclass
class Branch:
    """One future."""

    number: int
    parent: int | None = None
    begin: float = 0.0
    """When it left its parent (s)."""
    moments: list[Moment] = field(default_factory=list)
    times: list[float] = field(default_factory=list)
    """Of the samples (s)."""
    samples: list[Sample] = field(default_factory=list)
    """What the drones did."""
    marks: list[dict[str, Any]] = field(default_factory=list)
    """What was commanded, for the timeline."""

    def sample(self, time: float, sample: Sample) -> None:
        """Remember what the drones do."""
        if len(self.times) >= _MAX_SAMPLES:
            del self.times[::2], self.samples[::2]
        self.times.append(time)
        self.samples.append(sample)

    def add(self, moment: Moment) -> None:
        """Remember an instant."""
        self.moments.append(moment)
        if len(self.moments) > MAX_MOMENTS:
            # the first one stays, and the latest are the most wanted
            half = MAX_MOMENTS // 2
            self.moments[1:half] = self.moments[1:half:2]

    @property
    def end(self) -> float:
        """Time of the last sample (s)."""
        return self.times[-1] if self.times else self.begin

    def about(self) -> dict[str, Any]:
        """Return it as plain data, for the timeline."""
        return {
            "number": self.number,
            "parent": self.parent,
            "begin": round(self.begin, 3),
            "end": round(self.end, 3),
            "moments": len(self.moments),
            "marks": self.marks[-200:],
        }


class Branches:
    """All futures that were flown; one of them is being flown."""

    def __init__(self) -> None:
        self.present = Branch(0)
        self.all: dict[int, Branch] = {0: self.present}
        self._next = 1

    def find(self, number: int, time: float) -> tuple[Branch, Moment]:
        """Return the moment of a branch that is nearest before a time (s), and whose it is: perhaps its parent's.

        Raises:
            StateError: If there is none.
        """
        branch = self.all.get(number)
        if branch is None:
            raise StateError(f"there is no branch {number}, but {', '.join(map(str, self.all))}")
        while True:
            earlier = [moment for moment in branch.moments if moment.time <= time + 1e-6]
            if earlier:
                return branch, earlier[-1]
            if branch.parent is None or branch.parent not in self.all:
                if branch.moments:
                    return branch, branch.moments[0]
                raise StateError("there is no moment to go back to yet; fly a second, and try again")
            branch = self.all[branch.parent]

    def leave(self, parent: Branch, moment: Moment) -> Branch:
        """Begin a new branch at a moment of another one."""
        branch = Branch(self._next, parent.number, moment.time, [moment])
        self._next += 1
        self.all[branch.number] = branch
        self.present = branch
        for number in [n for n in self.all if n != branch.number][: max(0, len(self.all) - MAX_BRANCHES)]:
            del self.all[number]
        return branch

    def about(self) -> list[dict[str, Any]]:
        """Return all as plain data."""
        return [branch.about() for branch in list(self.all.values())]

    def lineage(self, number: int) -> tuple[list[float], list[Sample]]:
        """Return times (s) and samples of a branch, after those of the branches that it comes from.

        Raises:
            StateError: If there is no such branch.
        """
        times: list[float] = []
        samples: list[Sample] = []
        for branch, end in reversed(self._ancestors(number)):
            own = [(time, sample) for time, sample in zip(branch.times[:], branch.samples[:], strict=False)
                   if time <= end and (not times or time > times[-1])]  # fmt: skip
            times += [time for time, _ in own]
            samples += [sample for _, sample in own]
        return times, samples

    def marks_of(self, number: int) -> list[dict[str, Any]]:
        """Return what was commanded in a branch, and before it in those that it comes from."""
        return [
            mark for branch, end in reversed(self._ancestors(number)) for mark in branch.marks if mark["time"] <= end
        ]

    def _ancestors(self, number: int) -> list[tuple[Branch, float]]:
        """Return a branch and those that it comes from, with the time (s) up to which each of them belongs to it."""
        branch = self.all.get(number)
        if branch is None:
            raise StateError(f"there is no branch {number}, but {', '.join(map(str, self.all))}")
        found, end = [], np.inf
        while branch is not None:
            found.append((branch, end))
            end = min(end, branch.begin)
            branch = None if branch.parent is None else self.all.get(branch.parent)
        return found

    def path(self, number: int, begin: float = 0.0, most: int = 3000) -> dict[str, Any]:
        """Return where the drones were in a branch: times (s), shape (T,), and positions (m), shape (T, N, 3).

        None stands for the position of a drone without any pose so far, because JSON has no NaN.

        Raises:
            StateError: If there is no such branch.
        """
        branch = self.all.get(number)
        if branch is None:
            raise StateError(f"there is no branch {number}, but {', '.join(map(str, self.all))}")
        times, samples = branch.times[:], branch.samples[:]
        count = min(len(times), len(samples))
        chosen: Sequence[int] = [k for k in range(count) if times[k] >= begin]
        chosen = chosen[:: max(1, -(-len(chosen) // most))]
        return {
            "branch": number,
            "times": [round(times[k], 3) for k in chosen],
            "positions": [[_known(place) for place in np.round(samples[k].position, 3).tolist()] for k in chosen],
        }


def _known(place: list[float]) -> list[float] | None:
    return place if all(map(math.isfinite, place)) else None
