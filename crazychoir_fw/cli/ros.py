"""`crazychoir ros`: the buttons of a swarm of ROS 2 nodes."""

from typing import Annotated

import typer

from crazychoir_fw.cli.console import BAD_INPUT, complain, complain_of, console

ros = typer.Typer(help="Buttons of a swarm of ROS 2 nodes.", no_args_is_help=True)

Domain = Annotated[int | None, typer.Option(help="ROS domain; otherwise ROS_DOMAIN_ID.", min=0, max=232)]


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


def _press(button: str, domain: int | None) -> None:
    from crazychoir_fw.errors import CrazychoirError

    try:
        # says how to install what is missing, and keeps discovery on this machine
        from crazychoir_fw.ros.buttons import press_once
    except ImportError as error:
        complain(str(error))
        raise typer.Exit(BAD_INPUT) from None
    try:
        count = press_once(button, domain)
    except CrazychoirError as error:
        complain_of(error)
        raise typer.Exit(BAD_INPUT) from None
    console.print(f"{button}: heard by {count} nodes")
