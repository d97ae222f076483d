"""`crazychoir press`: what the buttons of the page do, from a terminal or a script."""

import os
from typing import Annotated, Any

import typer

from crazychoir_fw.cli.console import BAD_INPUT, complain, console
from crazychoir_fw.cli.gui import DEFAULT_PORT

_BUTTONS = (
    "takeoff",
    "land",
    "stop",
    "start",
    "starts",
    "mission",
    "arm",
    "disarm",
    "reboot",
    "pause",
    "goto",
    "speed",
    "set",
    "rewind",
)


def press(
    button: Annotated[str, typer.Argument(help=", ".join(_BUTTONS), metavar="BUTTON")],
    values: Annotated[
        list[str] | None,
        typer.Argument(
            help="goto: X Y Z [SECONDS]; speed: FACTOR; set: PARAMETER VALUE; "
            "rewind: SECONDS [BRANCH], otherwise of the one that flies."
        ),
    ] = None,
    drones: Annotated[
        str | None, typer.Option(help="Names, with commas between them; otherwise all drones.", metavar="NAMES")
    ] = None,
    port: Annotated[
        int, typer.Option(min=1, max=65535, metavar="PORT", help="Port of a page on this machine.")
    ] = DEFAULT_PORT,
    address: Annotated[
        str | None, typer.Option(help="Where the page is, if not on this machine.", metavar="http://HOST:PORT")
    ] = None,
    token: Annotated[str | None, typer.Option(help="Token of the page; otherwise $CRAZYCHOIR_TOKEN.")] = None,
) -> None:
    """Press a button of a page that `crazychoir gui` serves."""
    try:
        command = command_of(button, list(values or []))
    except ValueError as error:
        complain(str(error))
        raise typer.Exit(BAD_INPUT) from None
    if command["name"] not in ("speed", "rewind", "mission"):
        command["drones"] = None if drones is None else [name.strip() for name in drones.split(",")]
    address = _address_of(address, port)
    headers = {"content-type": "application/json"}
    if token := token or os.environ.get("CRAZYCHOIR_TOKEN"):
        headers["authorization"] = f"Bearer {token}"
    from crazychoir_fw.cli.page_client import answer_to

    console.print(answer_to(command, address, headers), markup=False, soft_wrap=True)


def _address_of(address: str | None, port: int) -> str:
    """Return where the page is; exits if the options do not say so."""
    if address is not None and port != DEFAULT_PORT:
        complain("--port and --address both say where the page is; give one of them")
        raise typer.Exit(BAD_INPUT)
    address = address or f"http://127.0.0.1:{port}"
    if not address.startswith(("http://", "https://")):
        complain(f"--address {address}: allowed: http://HOST:PORT")
        raise typer.Exit(BAD_INPUT)
    return address


def command_of(button: str, values: list[str]) -> dict[str, Any]:
    """Return the command of a button, as the endpoint takes it.

    Raises:
        ValueError: If there is no such button, or its values are none.
    """
    match button, values:
        case "takeoff" | "land" | "stop" | "start" | "starts" | "mission" | "reboot", []:
            return {"name": button}
        case "arm" | "disarm", []:
            return {"name": "arm", "armed": button == "arm"}
        case "pause", []:
            return {"name": "speed", "factor": 0.0}
        case "set", [parameter, value]:
            return {"name": "set_parameter", "parameter": parameter, "value": _numbers([value])[0]}
        case "speed", [_]:
            return {"name": "speed", "factor": _numbers(values)[0]}
        case "goto", [_, _, _] | [_, _, _, _]:
            return {"name": "goto", **dict(zip(("x", "y", "z", "duration"), _numbers(values), strict=False))}
        case "rewind", [_]:
            return {"name": "rewind", "time": _numbers(values)[0]}
        case "rewind", [_, branch]:
            if not branch.isdecimal():
                raise ValueError(f"branch {branch} must be a whole number, 0 or more")
            return {"name": "rewind", "time": _numbers(values)[0], "branch": int(branch)}
    if button not in _BUTTONS:
        raise ValueError(f"there is no button '{button}', allowed: {', '.join(_BUTTONS)}")
    raise ValueError(f"{button} does not take {' '.join(values) or 'nothing'}; see crazychoir press --help")


def _numbers(values: list[str]) -> list[float]:
    try:
        return [float(value) for value in values]
    except ValueError:
        raise ValueError(f"{' '.join(values)}: allowed: numbers") from None
