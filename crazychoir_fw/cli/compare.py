"""`crazychoir compare`: the log of a real flight beside the same commands in simulation."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.table import Table

from crazychoir_fw.cli.console import about_file, complain_of, console, echo_json, note, refuse
from crazychoir_fw.common.signals import unwind_at_signals

if TYPE_CHECKING:
    from crazychoir_fw.comparison.side_by_side import Comparison


@unwind_at_signals()
def compare(
    log: Annotated[
        Path,
        typer.Argument(help="CSV, NPZ, MCAP, rosbag2 folder, or binary log of a micro SD card.", metavar="LOG"),
    ],
    mission: Annotated[Path, typer.Option(help="Mission file: vehicle, software, positioning.", metavar="MISSION")],
    columns: Annotated[
        str | None,
        typer.Option(
            help="Which columns are what: crazyflie, nanobench, ros, or a YAML file.", metavar="PRESET|FILE.yaml"
        ),
    ] = None,
    drone: Annotated[str | None, typer.Option(help="Drone of mission and log; otherwise the first.")] = None,
    commands: Annotated[
        str | None, typer.Option(help="log: fly its setpoints (default, if it has some); mission: fly its phases.")
    ] = None,
    tune: Annotated[
        bool, typer.Option(help="Take thrust scale, trim and voltage from the hover of the real flight.")
    ] = True,
    changes: Annotated[
        list[str] | None, typer.Option("--set", help="Change one value of the mission.", metavar="KEY=VALUE")
    ] = None,
    seed: Annotated[int | None, typer.Option(help="Seed of the simulated noise.")] = None,
    out: Annotated[Path | None, typer.Option(help="Folder of the results; otherwise out/compare/LOG.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Fly the commands of a real flight in simulation, and show real over simulated: table, picture, page."""
    from crazychoir_fw.common.errors import CrazychoirError
    from crazychoir_fw.comparison.log_flight import load_flight
    from crazychoir_fw.comparison.report import SUMMARY, remarks_of, write_results
    from crazychoir_fw.comparison.side_by_side import COMMANDS, compare_flight
    from crazychoir_fw.mission.loader import load_mission

    if commands is not None and commands not in COMMANDS:
        refuse(f"--commands is '{commands[:40]}', allowed: {', '.join(COMMANDS)}")
    try:
        loaded = load_mission(mission, changes=changes or [], seed=seed, backend="sim")
        names = [one.id for one in loaded.fleet]
        if drone is not None and drone not in names:
            refuse(f"--drone is '{drone[:40]}', but {mission} has {', '.join(names)}")
        flight = load_flight(log, columns, drone)
        found = compare_flight(flight, loaded, drone, commands, tune)
    except CrazychoirError as error:
        complain_of(error)
        raise typer.Exit(2) from None
    folder = out or Path("out") / "compare" / flight.name
    first = loaded.fleet[names.index(found.drone)]
    told = {
        "log": str(log),
        "mission": str(mission),
        "drone": f"{first.id}, {first.platform}, provider {first.provider}, {first.controller or 'pid'}",
        "positioning": str(first.positioning or "mocap"),
    }
    try:
        page = write_results(found, folder, told)
    except OSError as error:
        refuse(about_file(error, folder))
    if as_json:
        import json

        echo_json(json.loads((folder / SUMMARY).read_text(encoding="utf-8")))
        return
    for remark in remarks_of(found):
        note(remark)
    _show(found)
    console.print(f"Picture and page: {page}", markup=False, highlight=False, soft_wrap=True)


def _show(found: "Comparison") -> None:
    from crazychoir_fw.comparison.report import hover_sentence, rows_of

    begin, end = found.phases.compared
    title = f"{found.flight.name}, {begin:.1f} to {end:.1f} s, commands of the {found.commands}"
    table = Table(title=title, title_justify="left")
    table.add_column("")
    for name in ("real", "simulated", "difference"):
        table.add_column(name, justify="right")
    for row in rows_of(found):
        table.add_row(f"{row.name} [{row.unit}]".replace("[", r"\["), row.real, row.simulated, row.difference)
    console.print(table)
    sentence = hover_sentence(found)
    if sentence is not None:
        console.print(f"Taken {sentence}", markup=False, highlight=False, soft_wrap=True)
