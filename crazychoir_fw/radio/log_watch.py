"""Log blocks that a drone has deleted, although its link lives on, are started again."""

from __future__ import annotations

import errno
from collections.abc import Callable, Sequence

from cflib.crazyflie.log import Log, LogConfig

_SILENCE_S = 1.5
_PERIODS = 3.0


class LogWatch:
    """Sees to it that a drone goes on logging.

    A drone that hears nothing for a second deletes its log blocks (docs/reference/crtp-cflib.md#3.4). When that was
    because this program stood still (it was stopped, collected garbage, or had no processor), the link lives on
    afterwards, cflib says nothing, and nothing is ever logged again. So when the fastest block is silent the drone is
    asked to start all of them, and those that it no longer has are made anew.

    A block that a drone still has begins its period anew when it is asked for. One that is slow, because simulated time
    is, would never end it; so every question doubles the time to the next one, and the time that passes between two
    answers of that block counts.

    Args:
        configs: Blocks that have been started, one or more.
        clock: Returns the time (s).
        renewed: Called in cflib's thread of the drone when blocks are made anew, once per question.
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
