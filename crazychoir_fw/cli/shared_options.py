"""Options that several commands have in common."""

from typing import Annotated

import typer

Seed = Annotated[int | None, typer.Option(min=0, max=2**32 - 1, help="Seed instead of the mission's.")]
Threads = Annotated[int | None, typer.Option(min=1, max=64, help="Worker threads.")]
Provider = Annotated[str | None, typer.Option(help="Provider of the onboard software.")]
UriBase = Annotated[
    str | None,
    typer.Option(
        help="URI of the first drone for --backend hardware; the others have the next ports or addresses.",
        metavar="URI",
    ),
]
PROCESSES = "per-node"
"""What `Processes` is unless an option says otherwise."""
Processes = Annotated[
    str,
    typer.Option(
        help="With --ros, one process per drone and layer, per drone, or for all layers.",
        metavar="per-node|per-drone|one",
    ),
]
Restart = Annotated[bool, typer.Option("--restart", help="With --ros, start processes again that have ended.")]


def need_ros(**given: bool) -> None:
    """Refuse options that count with --ros only: a flight must not ignore an option.

    Args:
        given: By option, whether it is there.

    Raises:
        typer.BadParameter: If one is.
    """
    for name, is_given in given.items():
        if is_given:
            raise typer.BadParameter("counts with --ros only", param_hint=f"--{name}")
