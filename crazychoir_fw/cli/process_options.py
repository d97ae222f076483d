"""Options of commands that start a mission as ROS 2 processes."""

from typing import Annotated

import typer

Processes = Annotated[
    str,
    typer.Option(
        help="With --ros, one process per drone and layer, per drone, or for all layers.",
        metavar="per-node|per-drone|one",
    ),
]
Restart = Annotated[bool, typer.Option("--restart", help="With --ros, start processes again that have ended.")]
