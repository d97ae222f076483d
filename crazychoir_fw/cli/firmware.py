"""`crazychoir firmware`: compile a checkout of the real firmware, see what there is, forget it."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn
from rich.text import Text

from crazychoir_fw.cli.console import complain_of, console, echo_json, refuse
from crazychoir_fw.cli.parity import parity
from crazychoir_fw.cli.tables import facts_table

if TYPE_CHECKING:
    from crazychoir_fw.firmware.library import Library

BUILD_FAILED = 1
COMPLETE = "complete"

firmware = typer.Typer(
    help="The real firmware: compile a checkout of bitcraze/crazyflie-firmware and see what there is.",
    no_args_is_help=True,
)
firmware.command()(parity)

PathOption = Annotated[
    Path | None,
    typer.Option(help="Folder of the checkout; otherwise that of CRAZYFLIE_FIRMWARE, else the submodule firmware/."),
]


@firmware.command()
def build(
    path: PathOption = None,
    platform: Annotated[str, typer.Option(help="Airframe: cf2, cf21bl or bolt.")] = "cf2",
    config: Annotated[
        Path | None, typer.Option(help="Configuration header (autoconf.h) to use instead of the stock one.")
    ] = None,
    level: Annotated[
        str | None,
        typer.Option(help="How much shall fly: algorithms, modules, stabilizer, or all, the highest that compiles."),
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Compile everything again.")] = False,
    verbose: Annotated[bool, typer.Option("--verbose", help="Show flags, configuration and compiler output.")] = False,
) -> None:
    """Compile a checkout to provider libraries: its algorithms alone, and as much of it as compiles."""
    import time

    from crazychoir_fw.common.errors import BuildError, CrazychoirError
    from crazychoir_fw.firmware import levels
    from crazychoir_fw.firmware.build import build_provider
    from crazychoir_fw.firmware.checkout import locate
    from crazychoir_fw.firmware.library import BUILD_LOG

    known = (*levels.LEVELS, levels.ALL)
    if level is not None and level not in known:
        refuse(f"--level is '{level}', allowed: {', '.join(known)}")
    wanted = (levels.ALGORITHMS, levels.ALL) if level is None else (level,)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn())
    began = time.perf_counter()
    try:
        checkout = locate(path)
        with Progress(*columns, console=console, transient=True) as bar:
            task = bar.add_task("looking", total=None)

            def show_progress(what: str, done: int, total: int) -> None:
                bar.update(task, description=what, completed=done, total=total)

            libraries = [
                build_provider(checkout, platform, configured=config, level=one, force=force, progress=show_progress)
                for one in wanted
            ]
    except BuildError as error:
        complain_of(error)
        raise typer.Exit(BUILD_FAILED) from None
    except CrazychoirError as error:
        refuse(str(error))
    for library in libraries:
        if verbose:
            # not through rich, which would wrap and color it
            typer.echo((library.path.parent / BUILD_LOG).read_text(encoding="utf-8"))
        _print_library(library)
    console.print(f"ready after {time.perf_counter() - began:.1f} s", style="dim")


@firmware.command()
def show(
    path: PathOption = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON for programs.")] = False,
) -> None:
    """Show the checkout and the libraries that are ready."""
    facts = _facts(path)
    if as_json:
        echo_json(facts)
        return
    shown = ("checkout", "version", "compiler", "cache")
    console.print(facts_table({key: str(facts[key] or "none") for key in shown}))
    if facts["state"] != COMPLETE:
        # in one line, because it has a command to copy
        console.print(Text(facts["state"], style="yellow"), soft_wrap=True)
    latest = latest_libraries(facts["libraries"], facts["checkout"])
    for identity in latest:
        console.print()
        _print_identity(identity)
    if more := len(facts["libraries"]) - len(latest):
        console.print(f"\nand {more} more, older ones or of other checkouts and apps: see --json", style="dim")


@firmware.command()
def clean() -> None:
    """Delete all kept objects and libraries."""
    from crazychoir_fw.common.errors import CrazychoirError
    from crazychoir_fw.firmware.cache import cache_root
    from crazychoir_fw.firmware.cache import clean as clean_cache

    try:
        size = clean_cache()
    except CrazychoirError as error:
        refuse(str(error))
    except OSError as error:
        refuse(f"{error.filename} cannot be deleted: {error.strerror}")
    console.print(f"{size / 1e6:.1f} MB deleted in {escape(str(cache_root()))}", soft_wrap=True)


def _facts(path: Path | None) -> dict[str, Any]:
    """Return what there is; nothing of it is an error here."""
    from crazychoir_fw.common.errors import CrazychoirError
    from crazychoir_fw.firmware.cache import cache_root
    from crazychoir_fw.firmware.checkout import locate, open_checkout
    from crazychoir_fw.firmware.library import kept_libraries
    from crazychoir_fw.firmware.toolchain import find_compiler

    facts: dict[str, Any] = {"checkout": None, "version": None, "state": COMPLETE, "cache": str(cache_root())}
    try:
        facts["checkout"] = str(locate(path))
        facts["version"] = open_checkout(path).version() or "no repository of its own"
    except CrazychoirError as error:
        facts["state"] = str(error)
    try:
        facts["compiler"] = find_compiler().version
    except CrazychoirError as error:
        facts["compiler"] = str(error)
    facts["libraries"] = [{**one.identity, "path": str(one.path)} for one in kept_libraries(cache_root())]
    return facts


def latest_libraries(identities: list[dict[str, Any]], checkout: str | None) -> list[dict[str, Any]]:
    """Return the libraries of a checkout without apps, per platform and level the one that was used last.

    Args:
        identities: What the libraries were built from, the one used last first.
        checkout: Folder of the checkout.
    """
    latest: dict[tuple[str, str], dict[str, Any]] = {}
    for identity in identities:
        if identity["checkout"] == checkout and checkout is not None and not identity["apps"]:
            latest.setdefault((identity["platform"], identity["level"]), identity)
    return [latest[key] for key in sorted(latest)]


def _print_library(library: "Library") -> None:
    _print_identity({**library.identity, "path": str(library.path)})
    for note in library.identity["notes"]:
        console.print(Text(note, style="yellow"), soft_wrap=True)


def _print_identity(identity: dict[str, Any]) -> None:
    """Print what a library was built from."""
    name = " ".join(filter(None, [identity["provider"], identity["version"], identity["platform"]]))
    rows = {
        "library": name,
        "checkout": identity["checkout"],
        "sources": identity["sources"],
        "features": ", ".join(identity["features"]),
        "without": ", ".join(identity["missing_features"]),
        "level": identity["level"],
        "modules": ", ".join(identity["modules"]),
        "added": ", ".join(Path(name).stem for name in identity["extra_sources"]),
        "apps": ", ".join(identity["apps"]),
        "compiler": identity["compiler"],
        "flags": identity["flags"],
    }
    console.print(facts_table({key: str(value) for key, value in rows.items() if value}))
    # in one line, because it is there to be copied
    console.print(Text.assemble((f" {'file':<8}", "bold"), f"  {identity['path']}"), soft_wrap=True)
