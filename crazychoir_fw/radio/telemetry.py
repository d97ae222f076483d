"""What one drone tells: its log variables, and the odometry among them."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from crazychoir_fw.radio.crazyflie import LinkedCrazyflie
from crazychoir_fw.radio.log_watch import LogWatch
from crazychoir_fw.radio.logs import DroneClock, LogBlock, LogValue, check_count, log_blocks, start_logs
from crazychoir_fw.radio.odometry import Odometry, odometry_reader
from crazychoir_fw.radio.options import Options

_DEFAULT_LOG = {"stabilizer.roll": 5.0, "stabilizer.pitch": 5.0, "stabilizer.yaw": 5.0}
_SAFETY_HZ = 10.0  # odometry for the safety area, when nobody else wants some

Values = dict[str, float | int]


class Telemetry:
    """Starts the logs of one drone at every connection, and whenever it has lost them; keeps what they say.

    Args:
        who: Name and URI, for errors.
        options: What to log.
        logged: Called with values by ``group.name`` and the drone's time (s).
        moved: Called with odometry.
        happened: Called with kind and text when logs were lost.
    """

    def __init__(
        self,
        who: str,
        options: Options,
        logged: Callable[[Values, float], None],
        moved: Callable[[Odometry], None],
        happened: Callable[[str, str], None],
    ) -> None:
        self._who = who
        self._options = options
        self._logged = logged
        self._moved = moved
        self._happened = happened
        self._clock = options.clock
        self._drone_clock = DroneClock()
        self._watch: LogWatch | None = None
        self.latest: dict[str, LogValue] = {}
        self.odometry: Odometry | None = None

    def begin(self, cf: LinkedCrazyflie) -> None:
        """Start the logs of a new connection, where there are to be some.

        Raises:
            CrazychoirError: If the drone has no such variables, too few blocks, or does not confirm.
        """
        options, who = self._options, self._who
        self._drone_clock = DroneClock()
        self._watch = None
        if not options.logger:
            return
        toc, timeout = cf.log.toc, options.confirm_timeout_s
        blocks = log_blocks(who, _DEFAULT_LOG if options.log is None else options.log, toc)
        odometry_hz = options.odometry_hz
        if options.safety_area is not None:
            odometry_hz = max(odometry_hz, _SAFETY_HZ)
        extra: list[LogBlock] = []
        names, read = odometry_reader(toc)
        if odometry_hz > 0.0:
            extra = log_blocks(who, dict.fromkeys(names, odometry_hz), toc)
        check_count(who, [*blocks, *extra])
        configs = start_logs(cf, who, blocks, self._take_values, timeout)
        configs += start_logs(cf, who, extra, lambda stamp, values: self._take_odometry(stamp, values, read), timeout)
        if configs:
            self._watch = LogWatch(configs, self._clock, self._lost)

    def look(self, now: float) -> float:
        """See to it that the drone logs, and return when to look again (s)."""
        watch = self._watch
        if watch is None:
            return math.inf
        watch.look(now)
        return watch.due

    def _lost(self) -> None:
        self._happened("logs", "the drone had deleted its log blocks, after a second without a packet: started again")

    def _take_values(self, stamp_ms: int, values: Values) -> None:
        time_s, received_s = self._drone_clock.seconds(stamp_ms), self._clock()
        self.latest.update({name: LogValue(value, time_s, received_s) for name, value in values.items()})
        self._logged(values, time_s)

    def _take_odometry(
        self,
        stamp_ms: int,
        values: Values,
        read: Callable[[Mapping[str, float], float, float], Odometry],
    ) -> None:
        self.odometry = read(values, self._drone_clock.seconds(stamp_ms), self._clock())
        self._moved(self.odometry)
