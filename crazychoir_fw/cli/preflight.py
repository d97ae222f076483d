"""`crazychoir preflight`: are the drones on the floor those that were tested? GO or NO-GO."""

from collections.abc import Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.table import Table

from crazychoir_fw.cli.console import BAD_INPUT, complain_of, console, echo_json, refuse
from crazychoir_fw.cli.shared_options import UriBase

if TYPE_CHECKING:
    from crazychoir_fw.mission.schema import LayeredMission
    from crazychoir_fw.preflight.check import Check
    from crazychoir_fw.preflight.parameters import Difference

_NO_GO = 1


def preflight(
    mission: Annotated[Path, typer.Argument(help="Mission file (YAML) with layers.", metavar="MISSION.yaml")],
    uri_base: UriBase = None,
    changes: Annotated[
        list[str] | None, typer.Option("--set", help="Change one value of the mission.", metavar="KEY=VALUE")
    ] = None,
    apply: Annotated[
        bool, typer.Option("--apply", help="Set parameters that differ, until the drones are switched off.")
    ] = False,
    spin: Annotated[
        bool, typer.Option("--spin", help="Test propellers and batteries: MOTORS TURN, hands off the drones.")
    ] = False,
    results: Annotated[
        Path | None, typer.Option("--campaign", help="Folder of the campaign's results; otherwise out/NAME.")
    ] = None,
    skip: Annotated[
        list[str] | None,
        typer.Option(help="A check that does not count, such as campaign; repeatable.", metavar="CHECK"),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Compare drones over the radio with the mission that they are to fly: GO or NO-GO.

    Leaves with 0 for GO, 1 for NO-GO, 2 where that could not be decided: a drone does not answer, a file is wrong.
    """
    from crazychoir_fw.common.errors import CrazychoirError

    try:
        from crazychoir_fw.campaign.standing import standing
        from crazychoir_fw.preflight.drones import look_at

        loaded = _load(mission, uri_base, changes or [])
        tested = standing(mission, changes or [], results or Path("out") / loaded.name)
        found = look_at(loaded, applies=apply, spins=spin)
    except CrazychoirError as error:
        complain_of(error)
        raise typer.Exit(BAD_INPUT) from None
    checks = _without([*found.checks, tested], skip or [])
    reasons = [f"{line.name}: {line.text}" for line in checks if not line.ok]
    answer = "NO-GO" if reasons else "GO"
    if as_json:
        lists = {"checks": list(map(asdict, checks)), "parameters": list(map(asdict, found.differences))}
        echo_json({"answer": answer, "mission": str(mission), "reasons": reasons, **lists})
    else:
        _show(checks, found.differences)
        console.print(answer, style="bold red" if reasons else "bold green", end=" ")
        console.print("; ".join(reasons) or "all checks are good", markup=False, highlight=False, soft_wrap=True)
    raise typer.Exit(_NO_GO if reasons else 0)


def _load(path: Path, uri_base: str | None, changes: list[str]) -> "LayeredMission":
    """Read a mission for the drones over the radio: all of them, but those of a mixed one that are simulated."""
    from crazychoir_fw.mission.documents import read_all, read_file
    from crazychoir_fw.mission.loader import load_mission
    from crazychoir_fw.mission.schema import LayeredMission

    told = read_all(read_file(path), str(path), path.parent, changes).data
    backend = None if told.get("backend") == "mixed" else "hardware"
    loaded = load_mission(path, uri_base, changes=changes, backend=backend)
    if not isinstance(loaded, LayeredMission):  # pragma: no cover - the loader says it before
        refuse(f"{path} has no layers, which the backend hardware flies")
    return loaded


def _without(checks: "Sequence[Check]", skipped: list[str]) -> "list[Check]":
    names = [line.name for line in checks]
    for name in skipped:
        if name not in names:
            refuse(f"--skip is '{name[:40]}', but must be one of {', '.join(names)}")
    return [replace(line, ok=True, text=f"skipped; {line.text}") if line.name in skipped else line for line in checks]


def _show(checks: "Sequence[Check]", differences: "Sequence[Difference]") -> None:
    from rich.text import Text

    if differences:
        table = Table("parameter", "drones", "they have", "mission", "", title="Parameters", title_justify="left")
        alike: dict[tuple[str, float, float, str], list[str]] = {}
        for one in differences:
            words = [word for word in ("persistent", "asked", "applied") if getattr(one, f"is_{word}")]
            alike.setdefault((one.name, one.found, one.wanted, ", ".join(words)), []).append(one.drone)
        for (name, found, wanted, marks), drones in alike.items():
            table.add_row(name, ", ".join(drones), f"{found:g}", f"{wanted:g}", marks)
        console.print(table)
    table = Table("", "check", "found")
    for line in checks:
        mark = Text("ok", style="green") if line.ok else Text("NO", style="bold red")
        table.add_row(mark, line.name, Text(line.text))
    console.print(table)
