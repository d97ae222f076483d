"""`crazychoir firmware parity`: two providers on the same inputs, and how far they differ."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich import box
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn
from rich.table import Table
from rich.text import Text

from crazychoir_fw.cli.console import BAD_INPUT, about_file, complain_of, complaints, console, echo_json, refuse
from crazychoir_fw.common.signals import unwind_at_signals

if TYPE_CHECKING:
    from crazychoir_fw.parity.functions import Comparison
    from crazychoir_fw.parity.run import Parity

DIFFERENT = 1
_STYLES = {"identical": "green", "equal within tolerance": "blue", "different": "red", "missing": "yellow"}
_MAX_ROWS = 24
_BASE = "base"


@unwind_at_signals()
def parity(
    checkout: Annotated[
        Path | None,
        typer.Option(
            "--checkout",
            "--path",
            help="Folder of the checkout; otherwise that of CRAZYFLIE_FIRMWARE, else the submodule firmware/.",
        ),
    ] = None,
    platform: Annotated[str, typer.Option(help="Airframe: cf2 or cf21bl.")] = "cf2",
    reference: Annotated[str, typer.Option(help="Provider that is right by definition.")] = "builtin",
    candidate: Annotated[
        str, typer.Option(help="Provider that is compared with it, such as bitcraze or bitcraze:modules.")
    ] = "bitcraze",
    base: Annotated[
        Path | None,
        typer.Option(help="Checkout that is right by definition, instead of --reference: the base branch's, say."),
    ] = None,
    out: Annotated[Path, typer.Option(help="Folder for parity.html and parity.json.")] = Path("out/parity"),
    seconds: Annotated[
        float, typer.Option(min=0.1, max=60.0, metavar="SECONDS", help="How long to fly at most.")
    ] = 18.0,
    seed: Annotated[int, typer.Option(min=0, max=2**32 - 1, help="Seed of all noise.")] = 1,
    same_parameters: Annotated[
        bool, typer.Option("--same-parameters", help="Give the candidate the reference's factory values first.")
    ] = False,
    flights: Annotated[bool, typer.Option("--flights/--no-flights", help="Compare whole flights as well.")] = True,
    record: Annotated[Path | None, typer.Option(help="Keep the recorded inputs in this file (NPZ).")] = None,
    inputs: Annotated[Path | None, typer.Option(help="Replay inputs that were kept with --record.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON for programs.")] = False,
) -> None:
    """Compare two providers: every function on recorded inputs, then whole flights in lockstep.

    Leaves with 0 when they are equal within tolerance, with 1 when they differ, with 2 when they cannot be compared.
    """
    from crazychoir_fw.common.errors import CrazychoirError

    try:
        with _progress() as show:
            result = _compare(
                checkout,
                platform,
                (reference, candidate),
                base,
                seconds,
                seed,
                same_parameters,
                flights,
                record,
                inputs,
                show,
            )
        from crazychoir_fw.parity.report import write_report

        page, _ = write_report(result, out)
    except CrazychoirError as error:
        complain_of(error)
        raise typer.Exit(BAD_INPUT) from None
    except OSError as error:
        refuse(about_file(error, out))
    if as_json:
        echo_json(result.as_json())
    else:
        _print(result, page)
    raise typer.Exit(result.exit_code)


def _compare(
    checkout: Path | None,
    platform: str,
    words: tuple[str, str],
    base: Path | None,
    seconds: float,
    seed: int,
    has_same_parameters: bool,
    flies: bool,
    record_to: Path | None,
    replay_from: Path | None,
    show: Callable[[str, float], None],
) -> "Parity":
    from crazychoir_fw.firmware.levels import ALGORITHMS, BITCRAZE, level_of
    from crazychoir_fw.parity.inputs import load as load_inputs
    from crazychoir_fw.parity.inputs import record
    from crazychoir_fw.parity.run import run_parity
    from crazychoir_fw.parity.side import Side

    first = _provider(words[0], platform, checkout, show) if base is None else _base(base, platform, show)
    sides = [Side(first, platform), Side(_provider(words[1], platform, checkout, show), platform)]
    if replay_from is not None:
        recorded = load_inputs(replay_from)
    else:
        recorded = record(sides[0], seconds, seed, progress=lambda share: show("recording flights", share))
    if record_to is not None:
        recorded.save(record_to)
    level = level_of(words[1])
    algorithms = None
    if level not in (None, ALGORITHMS):
        algorithms = Side(_provider(BITCRAZE, platform, checkout, show), platform)
    return run_parity(
        sides[0],
        sides[1],
        seconds=seconds,
        seed=seed,
        inputs=recorded,
        has_same_parameters=has_same_parameters,
        flies=flies,
        progress=show,
        algorithms=algorithms,
    )


def _base(folder: Path, platform: str, show: Callable[[str, float], None]) -> int:
    """Return the number of a checkout's provider under a name of its own, beside that of the candidate."""
    from crazychoir_fw.firmware.build import build_provider
    from crazychoir_fw.firmware.checkout import locate
    from crazychoir_fw.onboard.core import load_library

    def building(what: str, done: int, total: int) -> None:
        show(what, done / total if total else 0.0)

    return load_library(replace(build_provider(locate(folder), platform, progress=building), name=_BASE))


def _provider(word: str, platform: str, checkout: Path | None, show: Callable[[str, float], None]) -> int:
    """Return the number of a provider, built and loaded if need be."""
    from crazychoir_fw.firmware.build import build_provider
    from crazychoir_fw.firmware.checkout import locate
    from crazychoir_fw.firmware.levels import BITCRAZE
    from crazychoir_fw.firmware.providers import load
    from crazychoir_fw.onboard.core import load_library

    def building(what: str, done: int, total: int) -> None:
        show(what, done / total if total else 0.0)

    if word == BITCRAZE and checkout is not None:
        # that one, whatever else is loaded under this name
        return load_library(build_provider(locate(checkout), platform, progress=building))
    return load(word, platform, checkout, building)


@contextmanager
def _progress() -> Iterator[Callable[[str, float], None]]:
    """Show a bar on stderr, so that stdout holds the result alone."""
    columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn())
    with Progress(*columns, console=complaints, transient=True) as bar:
        task = bar.add_task("getting ready", total=1.0)
        yield lambda what, share: bar.update(task, description=what, completed=share)


def _print(result: "Parity", page: Path) -> None:
    from crazychoir_fw.parity.report import headline

    console.print(_summary(result))
    if (modules := result.modules()) and result.functions_of:
        words = (
            Text.assemble(f"{name} ", (verdict.value, _STYLES[verdict.value])) for name, verdict in modules.items()
        )
        console.print(Text("modules: ").append(Text(", ").join(words)))
    rows = [comparison for comparison in result.comparisons if comparison.verdict.value not in ("identical", "missing")]
    if result.functions_of:
        console.print(Text(f"functions are those of {result.functions_of}, flights those of the candidate"))
    if rows:
        rows.sort(key=lambda comparison: comparison.worst.severity if comparison.worst else (9, 0.0, 0), reverse=True)
        console.print(_worst(rows[:_MAX_ROWS]))
        if len(rows) > _MAX_ROWS:
            console.print(f"and {len(rows) - _MAX_ROWS} more", style="dim")
    word = result.verdict.value
    console.print(Text.assemble((word, f"bold {_STYLES[word]}"), f": {headline(result)}"))
    console.print(Text(f"see {page}"), soft_wrap=True)


def _summary(result: "Parity") -> Table:
    # a version may be the hash of a whole checkout
    names = [
        f"{side['provider']} {str(side.get('version', ''))[:16]}".strip()
        for side in (result.candidate, result.reference)
    ]
    table = Table(title=f"{names[0]} against {names[1]} on {result.platform}", box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column("what", no_wrap=True)
    words = list(result.counts())
    for word in words:
        table.add_column(word.replace(" within ", "\nwithin "), justify="right", style=_STYLES[word])
    for group, comparisons in result.groups().items():
        counts = result.counts(comparisons)
        table.add_row(group, *(str(counts[word] or "") for word in words))
    return table


def _worst(rows: list["Comparison"]) -> Table:
    from crazychoir_fw.parity.report import figure, tick

    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, collapse_padding=True)
    for heading in ("where", "worst signal"):
        table.add_column(heading, overflow="fold")
    for heading in ("ulps", "largest", "first"):
        table.add_column(heading, justify="right", no_wrap=True)
    for row in rows:
        style = _STYLES[row.verdict.value]
        worst = row.worst
        where = Text(f"{row.group} {row.name}", style=style)
        if row.failures or worst is None:
            table.add_row(where, Text("; ".join(row.failures.values())), "", "", "")
            continue
        first = tick(worst.first_tick, row.is_by_number)
        table.add_row(where, Text(worst.signal), figure(worst.max_ulps), figure(worst.max_absolute), first)
    return table
