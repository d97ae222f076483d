"""`python -m crazychoir_fw.ros`: single processes of a mission, for launch files and people."""

from __future__ import annotations

import signal
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

app = typer.Typer(help="Processes of ROS 2 nodes.", no_args_is_help=True, add_completion=False)

File = Annotated[Path, typer.Argument(help="Mission file (YAML) with layers.", metavar="MISSION.yaml")]


@app.command()
def layers(
    mission: File,
    drone: Annotated[list[str] | None, typer.Option(help="Id of a drone; repeatable. All without it.")] = None,
    layer: Annotated[
        list[str] | None,
        typer.Option(help="guidance, planning, control, avoidance or sensing; repeatable. All without it."),
    ] = None,
    lockstep: Annotated[bool, typer.Option(help="Whether guidance answers each tick.")] = False,
    leave_after: Annotated[
        float, typer.Option(help="Seconds after which it ends when nobody publishes /clock any more; 0 is never.")
    ] = 10.0,
) -> None:
    """Be some layers of some drones until interrupted, or until the simulation has gone."""
    from crazychoir_fw.ros.parts import LAYERS, Part, common_layers
    from crazychoir_fw.ros.process import run_part

    loaded = _load(mission)
    names = [one.id for one in loaded.fleet]
    every = (*LAYERS, *common_layers(loaded))
    drones, chosen = _chosen(drone, names), _chosen(layer, every)
    numbers = tuple(i for i, name in enumerate(names) if name in drones)
    part = Part("/".join([*(drone or []), *(layer or [])]) or "layers", numbers, chosen)
    raise typer.Exit(run_part(loaded, part, lockstep, leave_after=leave_after or None))


@app.command()
def simulation(
    mission: File,
    speed: Annotated[float, typer.Option(help="Simulated seconds per second; 0 is as fast as possible.")] = 1.0,
    lockstep: Annotated[bool, typer.Option(help="Whether time waits for the commands of all drones.")] = False,
) -> None:
    """Host the drones of a mission: odometry out, commands in, until interrupted. Buttons come from outside."""
    import rclpy

    from crazychoir_fw.flight.backends import make_backend
    from crazychoir_fw.ros.parts import one_command
    from crazychoir_fw.ros.process import make_executor
    from crazychoir_fw.ros.simulation import Pace, SimulationNode

    loaded = _load(mission)
    rclpy.init(args=[])
    context = rclpy.get_default_context()
    signal.signal(signal.SIGTERM, lambda *_: context.try_shutdown())
    executor = make_executor(context)
    node = SimulationNode(
        make_backend(loaded),
        command=one_command(loaded),
        rate=loaded.layers.rate,
        pace=Pace(speed or None, lockstep),
    )
    executor.add_node(node)
    try:
        node.run(executor)
    except KeyboardInterrupt:
        pass
    finally:
        rclpy.try_shutdown()


def _chosen(given: list[str] | None, known: Sequence[str]) -> tuple[str, ...]:
    """Return the known words that were given, in the order of *known*; all of them if none was."""
    for word in given or ():
        if word not in known:
            raise typer.BadParameter(f"'{word}', allowed: {', '.join(known)}")
    return tuple(word for word in known if not given or word in given)


def _load(path: Path):
    from crazychoir_fw.common.errors import CrazychoirError
    from crazychoir_fw.mission import load_mission
    from crazychoir_fw.ros.manager import RosOptions, check

    try:
        return check(load_mission(path), RosOptions())
    except CrazychoirError as error:
        raise typer.BadParameter(str(error)) from None


if __name__ == "__main__":
    app(prog_name="python -m crazychoir_fw.ros")
