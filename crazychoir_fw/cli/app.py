"""`crazychoir app`: look whether a controller or an estimator of your own compiles, and what it brings."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from crazychoir_fw.cli.console import BAD_INPUT, complain_of, console
from crazychoir_fw.cli.tables import facts_table

if TYPE_CHECKING:
    from crazychoir_fw.firmware.apps import App

app = typer.Typer(help="Your own C: controllers and estimators with the firmware's names.", no_args_is_help=True)


@app.callback()
def _group() -> None:
    """Keep `build` a command of its own: typer would take a single one for the whole."""


@app.command()
def build(
    files: Annotated[list[Path], typer.Argument(help="C files of one app.", metavar="APP.c [MORE.c]...")],
    platform: Annotated[str, typer.Option(help="Airframe: cf2 or cf21bl.")] = "cf2",
    provider: Annotated[str, typer.Option(help="What is around your code: builtin or bitcraze.")] = "builtin",
    path: Annotated[Path | None, typer.Option(help="Folder of the firmware's checkout, for bitcraze.")] = None,
) -> None:
    """Compile an app, and show what it brings and how to fly it."""
    import shlex
    import time

    from crazychoir_fw.common.errors import CrazychoirError
    from crazychoir_fw.firmware.apps import build_app
    from crazychoir_fw.firmware.checkout import VARIABLE

    began = time.perf_counter()
    try:
        with console.status("compiling"):
            built = build_app(files, platform, "bitcraze" if path is not None else provider, path)
        rows = _rows(built, platform)
    except CrazychoirError as error:
        complain_of(error)
        raise typer.Exit(BAD_INPUT) from None
    if built.warnings:
        typer.echo(built.warnings.rstrip(), err=True)
    console.print(facts_table(rows))
    words = " --provider bitcraze" if built.library.identity["checkout"] else ""
    named = f"{VARIABLE}={shlex.quote(str(path.absolute()))} " if path is not None else ""
    options = " ".join(f"--app {shlex.quote(str(file))}" for file in files)
    console.print(f"built in {time.perf_counter() - began:.1f} s, fly it with", style="dim")
    console.print(f"{named}crazychoir fly MISSION.yaml{words} {options}", soft_wrap=True, markup=False, highlight=False)


@app.command("from-policy")
def from_policy(
    policy: Annotated[Path, typer.Argument(help="Policy: .npz, .onnx, .zip (Stable-Baselines3) or .pt (torch).")],
    out: Annotated[Path, typer.Option(help="Folder to write to.")] = Path("policy_app"),
    name: Annotated[str, typer.Option(help="Name of the C file and of its parameters.")] = "policy",
    task: Annotated[
        str | None, typer.Option(help="What it was trained for, if the file does not say: Hover, ...")
    ] = None,
    rate_hz: Annotated[int | None, typer.Option(help="How often it acts, if not as that task says.")] = None,
    normalization: Annotated[
        Path | None, typer.Option(help="Archive (.npz) with mean and var, if the network has none within.")
    ] = None,
    activation: Annotated[str, typer.Option(help="Between layers of a .zip or .pt: tanh or relu.")] = "tanh",
) -> None:
    """Write a trained policy as a C controller for the firmware's app layer, and show what it costs there."""
    import dataclasses
    import shlex

    from crazychoir_fw.common.errors import CrazychoirError, UnknownNameError
    from crazychoir_fw.learning import tasks
    from crazychoir_fw.learning.policy import cost_of, read_policy, write_app

    try:
        trained = None
        if task is not None:
            if task not in tasks.names():
                raise UnknownNameError(f"there is no task '{task}', allowed: {', '.join(tasks.names())}")
            trained = getattr(tasks, task)()
            trained = trained if rate_hz is None else dataclasses.replace(trained, rate_hz=rate_hz)
        network = read_policy(policy, trained, normalization, activation)
        path = write_app(network, out, name, origin=policy.name)
    except CrazychoirError as error:
        complain_of(error)
        raise typer.Exit(BAD_INPUT) from None
    cost = cost_of(network)
    layers = " -> ".join(str(size) for size in [network.observation.size, *(len(one.bias) for one in network.layers)])
    seen = ", ".join(network.observation.blocks)
    console.print(facts_table({"network": layers, "sees": seen, "does": network.action.kind, **cost.rows}))
    for doubt in cost.doubts:
        typer.echo(f"doubtful: {doubt}", err=True)
    console.print(f"{path} is written, fly it with", style="dim")
    command = f"crazychoir fly MISSION.yaml --app {shlex.quote(str(path))}"
    console.print(command, soft_wrap=True, markup=False, highlight=False)


def _rows(built: "App", platform: str) -> dict[str, str]:
    """Return what there is to say about an app."""
    from crazychoir_fw.onboard.core import load_library
    from crazychoir_fw.onboard.variables import factory_values, log_table, parameter_table

    number = load_library(built.library)
    parameters = {name: row for name, row in parameter_table(number).items() if name.split(".")[0] in built.groups}
    logs = [name for name in log_table(number) if name.split(".")[0] in built.groups]
    values = factory_values(platform, parameters, number)
    return {
        "library": f"{built.library.name} {platform}",
        "compiler": str(built.library.identity["compiler"]),
        "brings": " and ".join(built.hooks),
        "state": f"{built.state_bytes} bytes per drone",
        "parameters": ", ".join(f"{name} = {value:.7g}" for name, value in values.items()) or "none",
        "logs": ", ".join(logs) or "none",
    }
