"""`crazychoir vehicle`: the numbers of a platform, with unit and source."""

from fnmatch import fnmatchcase
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.table import Table
from rich.text import Text

from crazychoir_fw.cli.console import console, echo_json, refuse

if TYPE_CHECKING:
    from crazychoir_fw.onboard.vehicles import Parameter, Value


def vehicle(
    platform: Annotated[
        str, typer.Argument(help="cf2 or cf21bl; or kit, legacy or nanobench, for what they change of cf2.")
    ] = "cf2",
    pattern: Annotated[str, typer.Argument(help="Names to show, e.g. 'wind.*'.")] = "*",
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON for programs.")] = False,
) -> None:
    """List the numbers of a vehicle: value, unit, allowed range, meaning, source."""
    from crazychoir_fw.common.errors import CrazychoirError
    from crazychoir_fw.onboard.vehicles import NAMED, changes_of, parameters

    try:
        table = changes_of(platform) if platform in NAMED else parameters(platform)
    except CrazychoirError as error:
        refuse(f"{error}; names of parameters come second, as in: crazychoir vehicle cf2 'wind.*'")
    rows = [parameter for name, parameter in table.items() if fnmatchcase(name, pattern)]
    if not rows:
        groups = dict.fromkeys(f"{name.split('.')[0]}.*" if "." in name else name for name in table)
        refuse(f"{platform} has no parameter '{pattern}', there are: {', '.join(groups)}")
    if as_json:
        echo_json([_row(parameter) for parameter in rows])
        return
    _print(rows)
    if platform not in NAMED:
        console.print(f"Vehicles that change cf2 in part: {', '.join(NAMED)}", style="dim")


def _row(parameter: "Parameter") -> dict[str, Any]:
    return {**vars(parameter), "allowed": parameter.allowed}


def _print(rows: "list[Parameter]") -> None:
    table = Table(box=None, pad_edge=False)
    table.add_column("parameter", no_wrap=True)
    for title in ("value", "allowed", "meaning", "source"):
        table.add_column(title, overflow="fold")
    for parameter in rows:
        unit = "" if parameter.unit in ("", "1") else f" {parameter.unit}"
        source = f"{parameter.source}; {parameter.note}" if parameter.note else parameter.source
        allowed = " | ".join(parameter.choices) or f"{parameter.lowest:g} to {parameter.highest:g}"
        table.add_row(
            Text(parameter.name, style="bold"),
            _text(parameter.value) + unit,
            allowed,
            parameter.meaning,
            Text(source, style="dim"),
        )
    console.print(table)
    console.print(f"{len(rows)} parameter{'' if len(rows) == 1 else 's'}", style="dim")


def _text(value: "Value") -> str:
    if isinstance(value, tuple):
        return ", ".join(f"{number:.5g}" for number in value)
    return value if isinstance(value, str) else f"{value:.7g}"
