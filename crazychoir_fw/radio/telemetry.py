"""What one drone tells: its log variables, and the odometry among them."""

from __future__ import annotations

import errno
import math
from collections.abc import Callable, Mapping, Sequence

from cflib.crazyflie.log import Log, LogConfig

from crazychoir_fw.radio.crazyflie import LinkedCrazyflie
from crazychoir_fw.radio.logs import DroneClock, LogBlock, LogValue, check_count, log_blocks, start_logs
from crazychoir_fw.radio.options import Options
from crazychoir_fw.radio.poses import Odometry, odometry_reader

_DEFAULT_LOG = {"stabilizer.roll": 5.0, "stabilizer.pitch": 5.0, "stabilizer.yaw": 5.0}
_SAFETY_HZ = 10.0  # odometry for the safety area, when none is asked for

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


_SILENCE_S = 1.5
_PERIODS = 3.0


class LogWatch:
    """Sees to it that a drone goes on logging.

    A drone that hears nothing for a second deletes its log blocks (docs/reference/crtp-cflib.md#3.4). When that was
    because this program stood still (it was stopped, collected garbage, or had no processor), the link lives on
    afterwards, cflib says nothing, and nothing is ever logged again. So when the fastest block is silent the drone is
    asked to start all of them, and those that it no longer has are created again.

    A block that a drone still has restarts its period when it is asked for. One that is slow, because simulated time
    is, would never end it; so every question doubles the time to the next one, and the time that passes between two
    answers of that block counts.

    Args:
        configs: Blocks that have been started, one or more.
        clock: Returns the time (s).
        renewed: Called in cflib's thread of the drone when blocks are created again, once per question.
    """

    def __init__(self, configs: Sequence[LogConfig], clock: Callable[[], float], renewed: Callable[[], None]) -> None:
        self._configs = configs
        self._clock = clock
        self._renewed = renewed
        fastest = min(configs, key=lambda config: config.period_in_ms)
        self._least_s = self._patience_s = max(_SILENCE_S, _PERIODS * fastest.period_in_ms / 1000.0)
        self._heard_at = self._asked_at = clock()
        self._is_told = False
        fastest.data_received_cb.add_callback(self._heard)
        for config in configs:
            # an answer that there is no such block comes from cflib's Log, a change of the flag from the block
            config.started_cb.add_callback(
                lambda teller, _, config=config: self._renew(config) if isinstance(teller, Log) else None
            )

    @property
    def due(self) -> float:
        """When to look (s)."""
        return max(self._heard_at, self._asked_at) + self._patience_s

    def look(self, now: float) -> None:
        """Ask for the blocks, if it is time (s) to."""
        if now < self.due:
            return
        self._asked_at = now
        self._patience_s *= 2.0
        self._is_told = False
        for config in self._configs:
            config.pending = 0  # of a question that was lost
            config.start()

    def _heard(self, *_: object) -> None:
        now = self._clock()
        self._patience_s = max(self._least_s, _PERIODS * (now - self._heard_at))
        self._heard_at = now

    def _renew(self, config: LogConfig) -> None:
        if config.err_no != errno.ENOENT or not config.added:  # refused for good, or under way
            return
        if not self._is_told:
            self._is_told = True
            self._renewed()
        config.added = config.started = False
        config.create()
