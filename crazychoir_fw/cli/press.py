"""`crazychoir press`: what the buttons of the page do, from a terminal or a script."""

import json
import os
import urllib.error
import urllib.request
import uuid
from typing import Annotated, Any

import typer

from crazychoir_fw.cli.console import BAD_INPUT, complain, console

_BUTTONS = ("takeoff", "land", "stop", "start", "arm", "disarm", "reboot", "pause", "goto", "speed", "set", "rewind")
_PATIENCE_S = 35.0


def press(
    button: Annotated[str, typer.Argument(help=", ".join(_BUTTONS), metavar="BUTTON")],
    values: Annotated[
        list[str] | None,
        typer.Argument(help="goto: X Y Z [SECONDS]; speed: FACTOR; set: PARAMETER VALUE; rewind: SECONDS [BRANCH]."),
    ] = None,
    drones: Annotated[str | None, typer.Option(help="Names, with commas between them; otherwise all drones.")] = None,
    address: Annotated[str, typer.Option(help="Where the page is.")] = "http://127.0.0.1:8080",
    token: Annotated[str | None, typer.Option(help="Token of the page; otherwise $CRAZYCHOIR_TOKEN.")] = None,
) -> None:
    """Press a button of a page that `crazychoir gui` serves."""
    try:
        command = command_of(button, list(values or []))
    except ValueError as error:
        complain(str(error))
        raise typer.Exit(BAD_INPUT) from None
    if command["name"] not in ("speed", "rewind"):
        command["drones"] = None if drones is None else [name.strip() for name in drones.split(",")]
    body = json.dumps({"id": uuid.uuid4().hex, "command": command}).encode()
    headers = {"content-type": "application/json"}
    if token := token or os.environ.get("CRAZYCHOIR_TOKEN"):
        headers["authorization"] = f"Bearer {token}"
    if not address.startswith(("http://", "https://")):
        complain(f"--address {address}: allowed: http://HOST:PORT")
        raise typer.Exit(BAD_INPUT)
    request = urllib.request.Request(f"{address.rstrip('/')}/api/command", body, headers)
    try:
        with urllib.request.urlopen(request, timeout=_PATIENCE_S) as response:
            console.print(json.load(response)["text"], markup=False, soft_wrap=True)
    except urllib.error.HTTPError as error:
        text = error.read().decode(errors="replace")
        complain(json.loads(text)["text"] if text.startswith("{") else text)
        raise typer.Exit(1) from None
    except (OSError, ValueError) as error:
        complain(f"there is no page at {address}: {error}; start one with crazychoir gui MISSION.yaml")
        raise typer.Exit(BAD_INPUT) from None


def command_of(button: str, values: list[str]) -> dict[str, Any]:
    """Return the command of a button, as the endpoint takes it.

    Raises:
        ValueError: If there is no such button, or its values are none.
    """
    if button in ("takeoff", "land", "stop", "start", "reboot") and not values:
        return {"name": button}
    if button in ("arm", "disarm") and not values:
        return {"name": "arm", "armed": button == "arm"}
    if button == "pause" and not values:
        return {"name": "speed", "factor": 0.0}
    if button == "set" and len(values) == 2:
        return {"name": "set_parameter", "parameter": values[0], "value": _numbers(values[1:])[0]}
    if button == "speed" and len(values) == 1:
        return {"name": "speed", "factor": _numbers(values)[0]}
    if button == "goto" and len(values) in (3, 4):
        return {"name": "goto", **dict(zip(("x", "y", "z", "duration"), _numbers(values), strict=False))}
    if button == "rewind" and len(values) in (1, 2):
        time, branch = (*_numbers(values), 0.0)[:2]
        return {"name": "rewind", "time": time, "branch": int(branch)}
    if button not in _BUTTONS:
        raise ValueError(f"there is no button '{button}', allowed: {', '.join(_BUTTONS)}")
    raise ValueError(f"{button} does not take {' '.join(values) or 'nothing'}; see crazychoir press --help")


def _numbers(values: list[str]) -> list[float]:
    try:
        return [float(value) for value in values]
    except ValueError:
        raise ValueError(f"{' '.join(values)}: allowed: numbers") from None
