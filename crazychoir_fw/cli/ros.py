"""`crazychoir ros`: the buttons of a swarm of ROS 2 nodes."""

from typing import Annotated

import typer

from crazychoir_fw.cli.console import BAD_INPUT, complain, console

ros = typer.Typer(help="Buttons of a swarm of ROS 2 nodes.", no_args_is_help=True)

Domain = Annotated[int | None, typer.Option(help="ROS domain; otherwise ROS_DOMAIN_ID.", min=0, max=232)]
Drones = Annotated[
    str | None,
    typer.Option(help="Names, with commas between them; otherwise all drones that are found.", metavar="NAMES"),
]


@ros.command()
def takeoff(domain: Domain = None) -> None:
    """All drones take off."""
    _press("takeoff", domain)


@ros.command()
def land(domain: Domain = None) -> None:
    """All drones land."""
    _press("land", domain)


@ros.command()
def stop(domain: Domain = None) -> None:
    """Motors of all drones off, at once."""
    _press("stop", domain)


@ros.command()
def start(domain: Domain = None) -> None:
    """The experiment starts."""
    _press("start", domain)


@ros.command()
def arm(drones: Drones = None, domain: Domain = None) -> None:
    """Drones may start their motors."""
    _care("arm", True, drones, domain)


@ros.command()
def disarm(drones: Drones = None, domain: Domain = None) -> None:
    """Drones may start their motors no more."""
    _care("arm", False, drones, domain)


@ros.command()
def reboot(drones: Drones = None, domain: Domain = None) -> None:
    """Onboard software starts again, of drones that do not fly."""
    _care("reboot", False, drones, domain)


def _press(button: str, domain: int | None) -> None:
    from crazychoir_fw.common.errors import CrazychoirError

    try:
        # says how to install what is missing, and keeps discovery on this machine
        from crazychoir_fw.ros.buttons import press_once

        count = press_once(button, domain)
    except (CrazychoirError, ImportError) as error:
        complain(str(error))
        raise typer.Exit(BAD_INPUT) from None
    console.print(f"{button}: heard by {count} nodes")


def _care(name: str, is_armed: bool, drones: str | None, domain: int | None) -> None:
    from crazychoir_fw.common.errors import CrazychoirError

    try:
        from crazychoir_fw.ros.arming_services import request_once

        chosen = [word.strip() for word in drones.split(",")] if drones else []
        answers = request_once(name, is_armed, chosen, domain)
    except (CrazychoirError, ImportError) as error:
        complain(str(error))
        raise typer.Exit(BAD_INPUT) from None
    for drone, answer in answers.items():
        console.print(f"{drone}: {answer}", markup=False)
