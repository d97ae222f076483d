"""`crazychoir campaign`: many flights that differ as real ones do, and GO or NO-GO."""

import os
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from crazychoir_fw.cli.console import BAD_INPUT, about_file, complain, complain_of, complaints, console
from crazychoir_fw.common.signals import unwind_at_signals

if TYPE_CHECKING:
    from crazychoir_fw.campaign.campaign import Campaign
    from crazychoir_fw.campaign.run import Outcome

INTERRUPTED = 128 + signal.SIGINT
_PROCESSORS = os.cpu_count() or 1
_STYLES = {"GO": "bold green", "NO-GO": "bold red"}


class _Commands(typer.core.TyperGroup):
    """`crazychoir campaign FILE` is short for `crazychoir campaign fly FILE`."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        if args and args[0] not in self.commands and args[0] not in ("--help", "-h"):
            args = ["fly", *args]
        return super().parse_args(ctx, args)


campaign = typer.Typer(
    cls=_Commands,
    help="Many flights that differ as real ones do: GO or NO-GO. `crazychoir campaign FILE` flies.",
    no_args_is_help=True,
)
Out = Annotated[Path | None, typer.Option(help="Folder of the results; otherwise out/NAME.")]
Workers = Annotated[
    int | None, typer.Option(min=1, max=1024, help="Worker processes; otherwise one per processor.", metavar="COUNT")
]


@campaign.command()
def fly(
    file: Annotated[
        Path,
        typer.Argument(help="Campaign or mission file (YAML), or a folder of regressions.", metavar="CAMPAIGN.yaml"),
    ],
    flights: Annotated[int | None, typer.Option(min=1, help="How many flights, instead of the file's.")] = None,
    seed: Annotated[int | None, typer.Option(min=0, max=2**32 - 1, help="Seed, instead of the file's.")] = None,
    design: Annotated[str | None, typer.Option(help="monte_carlo, latin_hypercube, sobol, saltelli or grid.")] = None,
    changes: Annotated[
        list[str] | None, typer.Option("--set", help="Change one value of the mission.", metavar="KEY=VALUE")
    ] = None,
    workers: Workers = None,
    out: Out = None,
    resume: Annotated[bool, typer.Option("--resume/--anew", help="Go on with the flights of the folder.")] = True,
    ray: Annotated[
        str | None,
        typer.Option("--ray", help="Fly on a Ray cluster: its address, or `local` for one that is started here."),
    ] = None,
) -> None:
    """Fly a campaign, and write report.html, summary.json, junit.xml, flights.csv.

    Leaves with 0 for GO, 1 for NO-GO, 2 where that could not be decided or nothing could be flown.
    """
    from crazychoir_fw.common.errors import CrazychoirError

    try:
        from crazychoir_fw.campaign.campaign import load_campaign
        from crazychoir_fw.campaign.library import require_library
        from crazychoir_fw.campaign.report import write_results
        from crazychoir_fw.campaign.run import exit_code, run

        require_library()
        if file.is_dir():
            raise typer.Exit(_fly_regressions(file, workers or _PROCESSORS))
        whole = load_campaign(file, changes or (), flights=flights, seed=seed, design=design)
        folder = out or Path("out") / whole.name
        if not resume:
            _forget(folder)
        with unwind_at_signals(), _engine(whole, workers or _PROCESSORS, ray) as engine:
            if whole.settings.search is not None:
                raise typer.Exit(_search(whole, folder, engine))
            if whole.settings.compare is not None:
                raise typer.Exit(_compare(whole, folder, engine))
            with _progress(whole.name) as tell:
                outcome = run(whole, folder, engine, tell)
        page = write_results(outcome)
    except CrazychoirError as error:
        complain_of(error)
        raise typer.Exit(BAD_INPUT) from None
    except OSError as error:
        complaints.print(f"{error.filename or file}: {error.strerror}", markup=False)
        raise typer.Exit(BAD_INPUT) from None
    except KeyboardInterrupt:  # before the first flight, or while results are written
        complaints.print("Interrupted: the same command goes on with what is there", markup=False)
        raise typer.Exit(INTERRUPTED) from None
    _show(outcome, page)
    raise typer.Exit(exit_code([outcome]))


def _engine(whole: "Campaign", workers: int, ray: str | None) -> Any:
    if ray is None:
        from crazychoir_fw.campaign.engines import Processes

        return Processes(workers)
    from crazychoir_fw.campaign.ray_engine import RayEngine

    return RayEngine(ray, whole)


def _fly_regressions(folder: Path, workers: int) -> int:
    """Fly all flights of a folder that failed once; returns the exit code."""
    from crazychoir_fw.campaign.engines import Processes
    from crazychoir_fw.campaign.regressions import fly_again, read_flights

    with unwind_at_signals(), Processes(workers) as engine:
        flown = fly_again(read_flights(folder), engine)
    table = Table("flight", "end", "why")
    for path, record in flown.items():
        table.add_row(path.name, record.outcome, "; ".join(record.failures))
    console.print(table)
    good = all(record.passed for record in flown.values())
    _answer("GO" if good else "NO-GO", f"{sum(one.passed for one in flown.values())} of {len(flown)} flights succeed")
    return 0 if good else 1


def _search(whole: "Campaign", folder: Path, engine: Any) -> int:
    """Look for the smallest deviation that fails; returns the exit code."""
    from crazychoir_fw.campaign.search import Search, write_finding

    with _progress(f"{whole.name}: search") as tell:
        search = Search(whole, engine, tell)
        finding = search.run()
    if finding is None:
        _answer("GO", f"no flight of {len(search.records)} failed")
        return 0
    table = Table("varied", "value", "distribution", title="Enough to fail", title_justify="left")
    values = dict(zip((one.key for one in whole.varied), whole.values_at(finding.shares).values(), strict=True))
    texts = {one.key: one.distribution.text for one in whole.varied}
    for key in finding.keys:
        value = values[key]
        table.add_row(key, f"{value:.5g}" if isinstance(value, float) else str(value), texts[key])
    console.print(table)
    _answer("NO-GO", f"{finding.distance:.2f} standard deviations suffice: {'; '.join(finding.record.failures)}")
    path = write_finding(whole, finding, folder)
    console.print(f"Kept as {path}; crazychoir campaign {path.parent} flies it", markup=False, soft_wrap=True)
    return 1


def _compare(whole: "Campaign", folder: Path, engine: Any) -> int:
    """Fly both sides of a comparison, and say what differs; returns the exit code."""
    from crazychoir_fw.campaign.compare import compare, variants_of
    from crazychoir_fw.campaign.report import write_comparison, write_results
    from crazychoir_fw.campaign.run import exit_code, run

    outcomes = {}
    for name, campaign in variants_of(whole).items():
        with _progress(f"{whole.name}: {name}") as tell:
            outcomes[name] = run(campaign, folder / name, engine, tell)
        engine.close()  # the other side may load other libraries of the same name
        write_results(outcomes[name])
    both = compare(outcomes["before"], outcomes["after"])
    table = Table("figure", "before", "after", "difference, 95 %", title="What differs", title_justify="left")
    for one in both.differences[:12]:
        style = "bold" if one.is_clear else "dim"
        interval = f"{one.low:+.4g} to {one.high:+.4g}"
        table.add_row(one.figure, f"{one.before:.4g}", f"{one.after:.4g}", interval, style=style)
    console.print(table)
    if both.broken:
        console.print("Broken: flights " + ", ".join(map(str, both.broken[:20])))
    _answer(both.answer, both.sentence)
    console.print(f"The report is {write_comparison(both, folder)}", markup=False, highlight=False, soft_wrap=True)
    if any(outcome.interrupted for outcome in outcomes.values()):
        return 2
    return {"GO": 0, "NO-GO": 1}.get(both.answer, exit_code([both.after]))


@contextmanager
def _progress(name: str) -> Iterator[Any]:
    columns = (
        TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TextColumn("{task.fields[rate]}"),
        TimeRemainingColumn(),
    )  # fmt: skip
    with Progress(*columns, console=console) as bar:
        task = bar.add_task(name, total=None, rate="getting ready")

        def tell(over: int, passed: int, total: int) -> None:
            bar.update(task, completed=over, total=total, rate=f"{passed / over:.1%} succeed")

        yield tell


def _forget(folder: Path) -> None:
    from crazychoir_fw.campaign.table import FILE

    for end in ("", "-wal", "-shm"):
        (folder / f"{FILE}{end}").unlink(missing_ok=True)


def _answer(answer: str, reasons: str) -> None:
    console.print(answer, style=_STYLES.get(answer, "bold yellow"), end=" ")
    console.print(reasons, markup=False, highlight=False, soft_wrap=True)


def _show(outcome: "Outcome", page: Path) -> None:
    """Print the verdict, what moves what, and the worst flights."""
    from crazychoir_fw.campaign.sensitivity import blame
    from crazychoir_fw.campaign.worst import worst_of

    verdict = outcome.verdict
    table = Table("flight", "end", "margin", "why", title="Worst flights", title_justify="left")
    for record in worst_of(outcome.records, 5):
        margin = record.figures.get("margin")
        why = "; ".join(record.failures)
        table.add_row(str(record.number), record.outcome, "" if margin is None else f"{margin:+.2f}", why)
    found = blame(outcome.campaign, outcome.records)[:5]
    if found:
        moves = Table("varied", "figure", "correlation", title="What moves what", title_justify="left")
        for one in found:
            moves.add_row(one.key, one.figure, f"{one.rank:+.2f}")
        console.print(moves)
    console.print(table)
    _answer(verdict.answer, "; ".join(verdict.reasons))
    if outcome.interrupted:
        console.print("Interrupted: the same command goes on with what is there", style="yellow")
    console.print(f"The report is {page}", markup=False, highlight=False, soft_wrap=True)


@campaign.command()
def refly(
    folder: Annotated[Path, typer.Argument(help="Folder of a campaign.", metavar="FOLDER")],
    number: Annotated[int, typer.Argument(min=0, help="Number of the flight.", metavar="NUMBER")],
    out: Out = None,
    film: Annotated[bool, typer.Option("--film", help="Film it.")] = False,
) -> None:
    """Fly one flight of a campaign again, alone, with the same bits, and write its log, plot and film."""
    from crazychoir_fw.cli.attempt import FlightRequest, attempt
    from crazychoir_fw.cli.film import FilmRequest
    from crazychoir_fw.common.errors import CrazychoirError

    try:
        from crazychoir_fw.campaign.flight import fly_whole, record_of
        from crazychoir_fw.campaign.table import read_flight

        record, job = read_flight(folder, number)
        again = record_of(job, record.values, fly_whole(job))
    except CrazychoirError as error:
        complain_of(error)
        raise typer.Exit(BAD_INPUT) from None
    same = again.digest == record.digest
    console.print(job.command, markup=False, highlight=False, soft_wrap=True)
    console.print("The same bits as in the campaign" if same else "Other bits than in the campaign: something changed")
    request = FlightRequest(
        Path(job.mission), FilmRequest() if film else None, None, out or folder / f"flight_{number}", 1,
        {"seed": job.seed, "changes": list(job.changes), "provider": job.provider, "app": job.app,
         "backend": job.backend},
    )  # fmt: skip
    raise typer.Exit(attempt(request))


@campaign.command()
def init(
    mission: Annotated[Path, typer.Argument(help="Mission file (YAML).", metavar="MISSION.yaml")],
    out: Annotated[
        Path | None, typer.Option(help="The file; otherwise NAME_campaign.yaml beside the mission.", metavar="FILE")
    ] = None,
) -> None:
    """Write a commented campaign file beside a mission; a file that is there stays as it is."""
    from crazychoir_fw.common.errors import CrazychoirError

    try:
        from crazychoir_fw.campaign.library import require_library
        from crazychoir_fw.campaign.starting import write_campaign

        require_library()
        path = write_campaign(mission, out)
    except CrazychoirError as error:
        complain_of(error)
        raise typer.Exit(BAD_INPUT) from None
    except OSError as error:
        complain(about_file(error, out))
        raise typer.Exit(BAD_INPUT) from None
    console.print(f"{path}", markup=False, highlight=False, soft_wrap=True)
    console.print(f"fly it with: crazychoir campaign {path}", markup=False, highlight=False, soft_wrap=True)
