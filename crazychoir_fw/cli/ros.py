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
        import crazychoir_fw.ros  # noqa: F401 - says how to install it, and keeps discovery on this machine
    except ImportError as error:
        complain(str(error))
        raise typer.Exit(BAD_INPUT) from None
    import rclpy
    from rclpy.context import Context

    from crazychoir_fw.ros.buttons import Buttons

    context = Context()
    rclpy.init(args=[], context=context, domain_id=domain)
    try:
        count = Buttons(services=False, context=context).press_when_heard(button, urgent=button == "stop")
        console.print(f"{button}: heard by {count} nodes")
    except CrazychoirError as error:
        complain_of(error)
        raise typer.Exit(BAD_INPUT) from None
    finally:
        rclpy.try_shutdown(context=context)
