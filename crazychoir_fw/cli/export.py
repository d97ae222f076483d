"""`crazychoir export`: a log in the formats of other tools."""

from pathlib import Path
from typing import Annotated

import typer

from crazychoir_fw.cli.console import about_file, complain_of, console, refuse
from crazychoir_fw.common.signals import unwind_at_signals


@unwind_at_signals()
def export(
    log: Annotated[Path, typer.Argument(help="Log of a flight (NPZ), or the folder with its log.npz.", metavar="LOG")],
    mcap: Annotated[
        Path,
        typer.Option(help="MCAP file with ROS 2 messages, for Foxglove, PlotJuggler and rosbag.", metavar="FILE.mcap"),
    ],
) -> None:
    """Write a log as a file that other tools open."""
    from crazychoir_fw.common.errors import CrazychoirError
    from crazychoir_fw.recording.mcap_file import write_mcap
    from crazychoir_fw.simulation.replay import load_flight

    if mcap.suffix.lower() != ".mcap":
        refuse(f"--mcap is {mcap}, but must end in .mcap")
    try:
        write_mcap(load_flight(log), mcap)
    except CrazychoirError as error:
        complain_of(error)
        raise typer.Exit(2) from None
    except OSError as error:
        refuse(about_file(error, mcap))
    console.print(f"Written to {mcap} ({mcap.stat().st_size / 1024:.0f} KiB)", markup=False, highlight=False)
