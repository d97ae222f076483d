"""`crazychoir fly --watch`: edit, save, and see it fly."""

from collections.abc import Collection
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from crazychoir_fw.cli.attempt import FlightRequest, attempt
from crazychoir_fw.cli.console import console
from crazychoir_fw.cli.watch import repeat_on_save, seconds_since_save
from crazychoir_fw.firmware.levels import level_of
from crazychoir_fw.mission.documents import files_of

if TYPE_CHECKING:
    from crazychoir_fw.mission.schema import Mission


def fly_again_on_save(request: FlightRequest) -> None:
    """Fly, and again whenever one of the files was saved, until Ctrl-C."""
    inputs = Inputs(request)

    def fly(changed: Collection[Path]) -> None:
        if changed:
            console.rule(f"{_names(changed)} changed", style="dim")
        attempt(request, inputs.of)
        elapsed = seconds_since_save(changed)
        pace = f"{elapsed:.1f} s from save to result, " if elapsed is not None else ""
        console.print(f"{pace}waiting for a change of {_names(inputs.named)} (Ctrl-C ends)", style="dim", markup=False)

    try:
        repeat_on_save(fly, inputs.files)
    except KeyboardInterrupt:
        console.print("ended")


class Inputs:
    """The files that a flight depends on."""

    def __init__(self, request: FlightRequest) -> None:
        self._mission = request.mission
        self._apps = {Path(path) for path in request.overrides["app"] or ()}
        self._checkout: Path | None = None

    def of(self, mission: "Mission") -> None:
        """Look at a mission: it names apps, and perhaps flies a checkout."""
        self._apps = {Path(path) for drone in mission.fleet for path in drone.app}
        self._checkout = None
        if any(level_of(drone.provider) is not None for drone in mission.fleet):
            from crazychoir_fw.common.errors import CheckoutError
            from crazychoir_fw.firmware.checkout import locate

            # where there is none, the flight is about to say so
            with suppress(CheckoutError):
                self._checkout = locate()

    @property
    def named(self) -> list[Path]:
        """The files that the user named, for people."""
        checkout = [self._checkout] if self._checkout is not None else []
        return [self._mission, *sorted(self._apps), *checkout]

    def files(self) -> set[Path]:
        """Return all files, with headers and other sources beside the apps, and what lies beside the mission."""
        missions = files_of(self._mission)
        files = {*missions, *self._apps}
        for folder in {mission.parent for mission in missions}:
            for suffix in (".csv", ".xml"):
                files.update(folder.glob(f"*{suffix}"))
        for folder in {path.parent for path in self._apps}:
            files.update(folder.glob("*.[ch]"))
        if self._checkout is not None:
            files.update((self._checkout / "src").rglob("*.[ch]"))
            files.update(self._checkout.glob("bindings/*.py"))
        return files


def _names(paths: Collection[Path]) -> str:
    """Return the names of some files, the first three of many."""
    names = [path.name for path in paths]
    return ", ".join(names[:3]) + (f" and {len(names) - 3} more" if len(names) > 3 else "")
