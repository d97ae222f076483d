"""The command line: `crazychoir fly`, `run`, `serve`, `replay`, `info`, `variables`, `vehicle` and others.

One module per command. Whatever is slow to import, a command imports when it runs.
"""

import functools
import sys
from collections.abc import Callable
from typing import Annotated, Any

import typer

from crazychoir_fw.cli.app import app as app_commands
from crazychoir_fw.cli.campaign import campaign
from crazychoir_fw.cli.compare import compare
from crazychoir_fw.cli.export import export
from crazychoir_fw.cli.film import film
from crazychoir_fw.cli.firmware import firmware
from crazychoir_fw.cli.fly import fly
from crazychoir_fw.cli.gui import gui
from crazychoir_fw.cli.info import info
from crazychoir_fw.cli.new import new
from crazychoir_fw.cli.plain_help import PlainGroup
from crazychoir_fw.cli.preflight import preflight
from crazychoir_fw.cli.press import press
from crazychoir_fw.cli.radio_budget import radio_budget
from crazychoir_fw.cli.replay import replay
from crazychoir_fw.cli.ros import ros
from crazychoir_fw.cli.run import run
from crazychoir_fw.cli.schema import schema
from crazychoir_fw.cli.serve import serve
from crazychoir_fw.cli.shim import install_shim
from crazychoir_fw.cli.variables import variables
from crazychoir_fw.cli.vehicle import vehicle
from crazychoir_fw.cli.view import ViewCommand
from crazychoir_fw.common.early_signals import import_first, interrupt_again

_FLIGHT = ("crazychoir_fw.mission.loader", "crazychoir_fw.flight.engine", "crazychoir_fw.recording.log_stream")
_SLOW = {
    "fly": _FLIGHT,
    "run": _FLIGHT,
    "replay": _FLIGHT,
    "serve": (*_FLIGHT, "crazychoir_fw.crtp.server"),
    "gui": (*_FLIGHT, "crazychoir_fw.gui.server", "crazychoir_fw.gui.session", "crazychoir_fw.gui.opening"),
}
"""Modules of commands that take seconds to import."""
_ROS = ("crazychoir_fw.ros.manager", "crazychoir_fw.ros.hosting")

app = typer.Typer(
    cls=PlainGroup,
    help="Swarms of Crazyflies in MuJoCo, flown by their own onboard software.",
    no_args_is_help=True,
    pretty_exceptions_show_locals=False,
)


def _show_version(is_wanted: bool) -> None:
    if is_wanted:
        from crazychoir_fw.common.version import __version__

        typer.echo(f"crazychoir {__version__}")
        raise typer.Exit


def _imported(command: Callable[..., Any]) -> Callable[..., Any]:
    """Return a command that imports its slow modules first, while Ctrl-C may still end it at once."""

    @functools.wraps(command)
    def run_imported(**options: Any) -> Any:
        over_ros = _ROS if {"--ros", "--ros-join"} & set(sys.argv) else ()
        import_first(*_SLOW[command.__name__], *over_ros)
        return command(**options)

    return run_imported


@app.callback()
def _options(
    ctx: typer.Context,
    version: Annotated[
        bool, typer.Option("--version", callback=_show_version, is_eager=True, help="Show the version and exit.")
    ] = False,
) -> None:
    """Swarms of Crazyflies in MuJoCo, flown by their own onboard software."""
    if ctx.invoked_subcommand not in _SLOW:
        interrupt_again()


app.command(cls=ViewCommand)(_imported(fly))
app.command(cls=ViewCommand)(_imported(run))
app.command(cls=ViewCommand)(_imported(serve))
app.command()(preflight)
app.command()(_imported(gui))
app.command()(new)
app.command(context_settings={"ignore_unknown_options": True})(press)
app.command()(_imported(replay))
app.command()(compare)
app.command()(film)
app.command()(export)
app.command()(info)
app.command()(variables)
app.command()(vehicle)
app.command()(schema)
app.command()(radio_budget)
app.add_typer(app_commands, name="app")
app.add_typer(campaign, name="campaign")
firmware.command()(install_shim)
app.add_typer(ros, name="ros")
app.add_typer(firmware, name="firmware")

__all__ = ["app"]
