"""`crazychoir run`: let the drones of an MJCF file fly themselves."""

from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from crazychoir_fw.cli.console import BAD_INPUT, FLIGHT_FAILED, complain, complain_of, console, note
from crazychoir_fw.cli.shared_options import Threads
from crazychoir_fw.cli.view import View, open_view, require_way

if TYPE_CHECKING:
    from crazychoir_fw.flight.engine import Observer
    from crazychoir_fw.simulation import World

_FRAME_TICKS = 20


def run(
    model: Annotated[Path, typer.Argument(help="Model with Crazyflies in it (MJCF).", metavar="MODEL.xml")],
    seconds: Annotated[
        float, typer.Option(min=0.0, max=86400.0, metavar="SECONDS", help="How long to fly, once they can.")
    ] = 10.0,
    view: View = None,
    seed: Annotated[int, typer.Option(min=0, max=2**32 - 1, help="Seed of the noise.")] = 0,
    threads: Threads = None,
) -> None:
    """Fly the drones of a model, each by the motor control that its body names."""
    from crazychoir_fw.common.errors import CrazychoirError
    from crazychoir_fw.simulation import World

    require_way(view)
    watched: AbstractContextManager[Observer | None] = nullcontext(None)
    try:
        world = World.from_mjcf(model, seed, threads)
        for doubt in world.doubts():
            note(doubt)
        if view is not None:
            watched = open_view(view, lambda line: console.print(line, soft_wrap=True, markup=False))
        world.wait_until_ready()
        with watched as show:
            _fly(world, seconds, show)
    except CrazychoirError as error:
        complain_of(error)
        raise typer.Exit(BAD_INPUT) from None
    _report(world)


def _fly(world: "World", seconds: float, show: "Observer | None") -> None:
    from crazychoir_fw.flight.engine import Progress

    ticks = round(seconds * 1000)
    if show is None:
        world.step(ticks)
        return
    show(world, Progress(0.0, seconds, 0.0))
    for flown in range(0, ticks, _FRAME_TICKS):
        frame = min(_FRAME_TICKS, ticks - flown)
        world.step(frame)
        show(world, Progress((flown + frame) / 1000, seconds, 0.0))


def _report(world: "World") -> None:
    """Print where everybody is, and what went wrong."""
    for drone in world.drones:
        name = type(drone.motor_ctrl).__name__ if drone.motor_ctrl is not None else "nobody"
        x, y, z = drone.true_position.round(2) + 0.0  # not -0.00
        console.print(
            f"{drone.id}: {drone.supervisor_state} at {x:.2f}, {y:.2f}, {z:.2f} m, flown by {name}",
            markup=False,
            soft_wrap=True,
        )
    failures = [drone.failure for drone in world.drones if drone.failure is not None]
    for failure in failures:
        complain(failure)
    if failures:
        raise typer.Exit(FLIGHT_FAILED)
