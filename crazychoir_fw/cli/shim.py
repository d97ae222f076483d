"""`crazychoir firmware install-shim`: the plain name `cffirmware` for this environment."""

from typing import Annotated

import typer

from crazychoir_fw.cli.console import about_file, console, refuse


def install_shim(
    remove: Annotated[bool, typer.Option("--remove", help="Take the name away again.")] = False,
) -> None:
    """Let `import cffirmware` find crazychoir_fw.cffirmware in this environment."""
    from crazychoir_fw.cffirmware import shim
    from crazychoir_fw.common.errors import CrazychoirError

    try:
        done = shim.remove() if remove else shim.install()
    except CrazychoirError as error:
        refuse(str(error))
    except OSError as error:
        refuse(about_file(error, None))
    if done is None:
        console.print("no shim is installed", soft_wrap=True)
        return
    console.print(f"{'removed' if remove else 'wrote'} {done.path}", soft_wrap=True, highlight=False)
    if done.real_build is not None and not remove:
        console.print(
            f"note: in this shell, `import {shim.NAME}` still finds a real build, {done.real_build}",
            soft_wrap=True,
            highlight=False,
        )
