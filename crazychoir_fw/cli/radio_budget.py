"""`crazychoir radio-budget`: how many drones one Crazyradio can serve."""

from typing import TYPE_CHECKING, Annotated

import typer
from rich import box
from rich.table import Table

from crazychoir_fw.cli.console import console, refuse

if TYPE_CHECKING:
    from crazychoir_fw.crtp.link_model.budget import Budget

COUNTS = (1, 2, 4, 6, 8, 10, 12, 15, 20, 25, 30, 40)
STYLES = {"fits": "green", "tight": "yellow", "too much": "red"}


def radio_budget(
    drones: Annotated[
        int | None, typer.Option("--count", min=1, max=1000, help="Drones on one radio; without it, a table.")
    ] = None,
    setpoints: Annotated[
        float, typer.Option(min=0, max=1000, metavar="HZ", help="Setpoints to each drone (Hz).")
    ] = 10.0,
    logs: Annotated[
        list[float] | None,
        typer.Option(min=0, max=1000, metavar="HZ", help="Full log packets of each drone (Hz); repeatable."),
    ] = None,
    poses: Annotated[
        float, typer.Option(min=0, max=1000, metavar="HZ", help="External poses to each drone (Hz).")
    ] = 0.0,
    data_rate: Annotated[str, typer.Option(help="Bits per second.", metavar="250K|1M|2M")] = "2M",
    loss: Annotated[float, typer.Option(min=0, max=1, metavar="SHARE", help="Share of lost transmissions.")] = 0.0,
) -> None:
    """Estimate how many drones one Crazyradio can serve, and how late their setpoints come."""
    from crazychoir_fw.common.errors import CrazychoirError
    from crazychoir_fw.crtp.link_model import RadioConfig
    from crazychoir_fw.crtp.link_model.budget import LogBlock, budget

    blocks = [LogBlock(rate) for rate in ([10.0] if logs is None else logs)]
    try:
        radio = RadioConfig(drones=["*"], data_rate=data_rate, loss=loss)
        rows = [
            budget(radio, count, setpoints, logs=blocks, poses_hz=poses)
            for count in (COUNTS if drones is None else (drones,))
        ]
    except CrazychoirError as error:
        refuse(str(error))
    streams = f"setpoints {setpoints:g} Hz, logs {' + '.join(f'{block.rate_hz:g}' for block in blocks)} Hz"
    streams += f", poses {poses:g} Hz" if poses else ""
    console.print(_table(rows, f"One Crazyradio, {data_rate}, {streams}, {100 * loss:g} % loss"))


def _table(rows: "list[Budget]", title: str) -> Table:
    table = Table(title=title, box=box.SIMPLE_HEAD, collapse_padding=True, pad_edge=False)
    for heading in ("drones", "turns\nused (%)", "busy\n(%)", "setpoint\nmean (ms)", "setpoint\n95 % (ms)"):
        table.add_column(heading, justify="right", no_wrap=True)
    table.add_column("log packet\nmean (ms)", justify="right", no_wrap=True)
    table.add_column("")
    for row in rows:
        times = (_milliseconds(value) for value in (row.up_mean_ms, row.up_p95_ms, row.down_mean_ms))
        shares = (f"{100 * row.utilization:.0f}", f"{100 * row.busy:.0f}")
        table.add_row(str(row.drones), *shares, *times, f"[{STYLES[row.verdict]}]{row.verdict}[/]")
    return table


def _milliseconds(value: float) -> str:
    return "-" if value == float("inf") else f"{value:.1f}"
