"""`crazychoir variables`: the parameters and log variables of a drone, with their values after boot."""

from fnmatch import fnmatchcase
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.table import Table
from rich.text import Text

from crazychoir_fw.cli.console import console, echo_json, refuse

if TYPE_CHECKING:
    from crazychoir_fw.onboard.variables import Variable


def variables(
    pattern: Annotated[str, typer.Argument(help="Names to show, e.g. 'kalman.*' or '*vbat*'.")] = "*",
    logs: Annotated[bool, typer.Option("--logs", help="Log variables instead of parameters.")] = False,
    platform: Annotated[str, typer.Option(help="Airframe whose factory values are shown.")] = "cf2",
    provider: Annotated[str, typer.Option(help="Provider: builtin, or bitcraze for the real firmware.")] = "builtin",
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON for programs.")] = False,
) -> None:
    """List parameters (or log variables) by name: type, factory value, flags."""
    from crazychoir_fw.common.errors import CrazychoirError
    from crazychoir_fw.firmware.providers import load
    from crazychoir_fw.onboard.variables import factory_values, log_table, parameter_table

    try:
        number = load(provider, platform)
        table = log_table(number) if logs else parameter_table(number)
        values = factory_values(platform, table, number)
    except CrazychoirError as error:
        refuse(str(error))
    rows = [_row(variable, values[name], logs) for name, variable in table.items() if fnmatchcase(name, pattern)]
    if as_json:
        echo_json(rows)
        return
    _print(rows, logs)


def _row(variable: "Variable", value: float | int, is_log: bool) -> dict[str, Any]:
    row: dict[str, Any] = {"name": variable.name, "type": variable.dtype.name}
    if not is_log:
        row["value"] = value
        row["read_only"] = variable.is_read_only
        row["persistent"] = variable.is_persistent
    row["core"] = variable.is_core
    return row


def _print(rows: list[dict[str, Any]], is_log: bool) -> None:
    table = Table(box=None)
    for title in ("log variable", "type", "") if is_log else ("parameter", "type", "factory value", ""):
        table.add_column(title, justify="right" if title == "factory value" else "left", no_wrap=True)
    for row in rows:
        words = [word.replace("_", "-") for word in ("core", "persistent", "read_only") if row.get(word)]
        value = [] if is_log else [f"{row['value']:.7g}"]
        table.add_row(Text(row["name"], style="bold"), row["type"], *value, Text(" ".join(words), style="dim"))
    console.print(table)
    kind = "log variable" if is_log else "parameter"
    console.print(f"{len(rows)} {kind}{'' if len(rows) == 1 else 's'}", style="dim")
