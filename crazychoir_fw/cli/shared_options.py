"""Options that several commands have in common."""

from typing import Annotated

import typer

UriBase = Annotated[
    str | None,
    typer.Option(
        help="URI of the first drone for --backend hardware; the others have the next ports or addresses.",
        metavar="URI",
    ),
]
Processes = Annotated[
    str,
    typer.Option(
        help="With --ros, one process per drone and layer, per drone, or for all layers.",
        metavar="per-node|per-drone|one",
    ),
]
Restart = Annotated[bool, typer.Option("--restart", help="With --ros, start processes again that have ended.")]
