"""Log variables of a drone: spread over blocks, started, and received."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from cflib.crazyflie import Crazyflie
from cflib.crazyflie.log import Log, LogConfig, LogTocElement

from crazychoir_fw.common.errors import RadioError, RangeError, UnknownNameError
from crazychoir_fw.radio.parameters import element_of, suggestion

_MS_PER_SECOND = 1000.0
_STAMP_RANGE = 1 << 24  # the drone stamps with 24 bits of milliseconds


class LogValue(NamedTuple):
    """What a drone last said about one variable."""

    value: float | int
    time_s: float
    """Time since the drone started (s), by its own clock."""
    received_s: float
    """Time of reception (s), by the clock of the handler (`time.monotonic`)."""


@dataclass(frozen=True)
class LogBlock:
    """Variables that are sampled and sent together."""

    names: tuple[str, ...]
    period_ms: int


def log_blocks(who: str, variables: Mapping[str, float], toc: object) -> list[LogBlock]:
    """Spread variables over blocks of at most 26 bytes, one or more for each rate.

    Args:
        who: Name and URI, for errors.
        variables: Rate (Hz) by ``group.name``. A drone samples every 10, 20, … 2540 ms: the nearest is taken.
        toc: cflib's table of contents.

    Raises:
        UnknownNameError: If the drone has no such variable.
        RangeError: If a rate is out of range, or these are more than a drone can log.
    """
    by_period: dict[int, list[tuple[str, int]]] = {}
    for name, rate_hz in variables.items():
        element = element_of(toc, name)
        if element is None:
            raise UnknownNameError(f"{who}: there is no log variable '{name}'{suggestion(name, toc)}")
        size = LogTocElement.get_size_from_id(LogTocElement.get_id_from_cstring(element.ctype))
        by_period.setdefault(_period_ms(who, name, rate_hz), []).append((name, size))
    blocks: list[LogBlock] = []
    for period, sized in sorted(by_period.items()):
        names: list[str] = []
        room = LogConfig.MAX_LEN
        for name, size in sized:
            if size > room:
                blocks.append(LogBlock(tuple(names), period))
                names, room = [], LogConfig.MAX_LEN
            names.append(name)
            room -= size
        blocks.append(LogBlock(tuple(names), period))
    return blocks


def _period_ms(who: str, name: str, rate_hz: float) -> int:
    if not (isinstance(rate_hz, int | float) and math.isfinite(rate_hz) and rate_hz > 0.0):
        raise RangeError(f"{who}: log variable '{name}': rate is {rate_hz!r}, allowed: 0.394 to 100 Hz")
    period = round(_MS_PER_SECOND / rate_hz / 10.0) * 10
    if not 10 <= period <= 2540:
        raise RangeError(f"{who}: log variable '{name}': rate is {rate_hz!r}, allowed: 0.394 to 100 Hz")
    return period


def start_logs(
    cf: Crazyflie,
    who: str,
    blocks: Sequence[LogBlock],
    received: Callable[[int, dict[str, float | int]], None],
    timeout_s: float,
) -> list[LogConfig]:
    """Start blocks, and wait until the drone has confirmed each.

    Args:
        cf: A connected drone.
        who: Name and URI, for errors.
        blocks: What to log.
        received: Called with the drone's stamp (ms, 24 bits) and values, in cflib's thread of this drone.
        timeout_s: How long one block may take (s).

    Raises:
        RadioError: If the drone refuses one, or does not confirm.
    """
    return [_start(cf, who, block, received, timeout_s) for block in blocks]


def check_count(who: str, blocks: Sequence[LogBlock]) -> None:
    """Refuse more than a drone can log.

    Raises:
        RangeError: If these are more blocks or variables.
    """
    count = sum(len(block.names) for block in blocks)
    if len(blocks) > Log.MAX_BLOCKS or count > Log.MAX_VARIABLES:
        raise RangeError(
            f"{who}: {count} log variables make {len(blocks)} blocks, "
            f"allowed: {Log.MAX_VARIABLES} variables in {Log.MAX_BLOCKS} blocks"
        )


def _start(
    cf: Crazyflie,
    who: str,
    block: LogBlock,
    received: Callable[[int, dict[str, float | int]], None],
    timeout_s: float,
) -> LogConfig:
    config = LogConfig(name=block.names[0], period_in_ms=block.period_ms)
    for name in block.names:
        config.add_variable(name)
    answered = threading.Event()
    refusals: list[str] = []

    def refused(_config: LogConfig, reason: str) -> None:
        refusals.append(reason)
        answered.set()

    def started(*arguments: object) -> None:
        if arguments[-1]:
            answered.set()

    config.data_received_cb.add_callback(lambda stamp, values, _config: received(stamp, values))
    config.error_cb.add_callback(refused)
    config.started_cb.add_callback(started)
    cf.log.add_config(config)
    config.start()
    if not answered.wait(timeout_s):
        raise RadioError(f"{who}: log block of {', '.join(block.names)} was not confirmed within {timeout_s:g} s")
    if refusals:
        raise RadioError(f"{who}: log block of {', '.join(block.names)} was refused: {refusals[0]}")
    return config


class DroneClock:
    """Makes steady seconds of the drone's stamps, which wrap around every 4.7 hours."""

    def __init__(self) -> None:
        self._last: int | None = None
        self._total_ms = 0

    def seconds(self, stamp_ms: int) -> float:
        """Return the time since the drone started (s), for a stamp at most 2.3 h from the last one."""
        if self._last is None:
            self._total_ms = stamp_ms
        else:
            passed = (stamp_ms - self._last) % _STAMP_RANGE
            self._total_ms += passed if passed < _STAMP_RANGE // 2 else passed - _STAMP_RANGE
        self._last = stamp_ms
        return self._total_ms / _MS_PER_SECOND
