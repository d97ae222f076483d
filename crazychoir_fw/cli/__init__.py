"""The command line: `crazychoir fly MISSION.yaml`, `crazychoir info`, `variables`, `app` and `firmware`.

One module per command. Whatever is slow to import, a command imports when it runs.
"""

import typer

from crazychoir_fw.cli.app import app as app_commands
from crazychoir_fw.cli.firmware import firmware
from crazychoir_fw.cli.fly import FlyCommand, fly
from crazychoir_fw.cli.info import info
from crazychoir_fw.cli.shim import install_shim
from crazychoir_fw.cli.variables import variables

app = typer.Typer(
    help="Swarms of Crazyflies in MuJoCo, flown by their own onboard software.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_show_locals=False,
)
app.command(cls=FlyCommand)(fly)
app.command()(info)
app.command()(variables)
app.add_typer(app_commands, name="app")
firmware.command()(install_shim)
app.add_typer(firmware, name="firmware")

__all__ = ["app"]
