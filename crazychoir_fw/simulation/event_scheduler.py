"""What Python does at simulated times: faults, plugins and replays hook in here.

A world without appointments never leaves MuJoCo; one with some stops at their ticks only.
"""

from __future__ import annotations

import bisect
from collections.abc import Callable
from dataclasses import dataclass

from crazychoir_fw.common.errors import RangeError

Appointment = Callable[[], None]
"""Called when the world has reached its tick, before the next one begins."""


@dataclass(frozen=True)
class _Periodic:
    period: int  # [ticks]
    phase: int  # [ticks]
    call: Appointment

    def next_after(self, tick: int) -> int:
        return tick + self.period - (tick - self.phase) % self.period


class EventScheduler:
    """Appointments by tick. At one tick, single ones come before periodic ones, each in the order of their coming.

    Not part of a snapshot: a world that goes back in time meets again what is on the agenda then.
    """

    def __init__(self) -> None:
        self._ticks: list[int] = []
        self._calls: list[Appointment] = []
        self._done = 0  # single appointments that are over
        self._periodic: list[_Periodic] = []
        self._now = 0
        self._next_periodic: int | None = 0  # not later than it is; the present tick: not known; None: there is none
        self.when_sought: list[Callable[[int], None]] = []
        """Called with the tick after a jump to another time."""

    def at(self, tick: int, call: Appointment) -> None:
        """Have `call` called when the world reaches a tick; at the present one, before the next step.

        Raises:
            RangeError: If the tick is in the past.
        """
        if tick < self._now:
            raise RangeError(f"appointment at tick {tick}: allowed: the present tick {self._now} or later")
        place = max(bisect.bisect_right(self._ticks, tick), self._done)
        self._ticks.insert(place, tick)
        self._calls.insert(place, call)

    def every(self, period: int, call: Appointment, phase: int = 0) -> Callable[[], None]:
        """Have `call` called at every tick that is `phase` plus a multiple of `period`, from the next one on.

        Returns:
            A function that takes the appointment off the agenda.

        Raises:
            RangeError: If the period is no positive number of ticks.
        """
        if period < 1:
            raise RangeError(f"period of {period} ticks, allowed: 1 or more")
        entry = _Periodic(period, phase, call)
        self._periodic.append(entry)
        self._next_periodic = self._now  # to be found again

        def cancel() -> None:
            if entry in self._periodic:
                self._periodic.remove(entry)
                self._next_periodic = self._now

        return cancel

    @property
    def periods(self) -> list[int]:
        """Periods (ticks) of all periodic appointments, in the order of their coming."""
        return [entry.period for entry in self._periodic]

    def next_stop(self, limit: int) -> int:
        """Return the first tick after the present one with an appointment, at most `limit`."""
        stop = limit
        if self._done < len(self._ticks):
            stop = min(stop, max(self._ticks[self._done], self._now))
        # a served swarm has hundreds of entries, and at most stops none of them is due
        if self._next_periodic is not None and self._next_periodic <= self._now:
            self._next_periodic = min((entry.next_after(self._now) for entry in self._periodic), default=None)
        return stop if self._next_periodic is None else min(stop, self._next_periodic)

    def keep(self, tick: int) -> None:
        """Call what has an appointment at this tick or was left over before it."""
        before, self._now = self._now, tick
        self._keep_single()
        if tick > before and self._next_periodic is not None and tick >= self._next_periodic:
            for entry in list(self._periodic):
                # a scene whose steps are longer than a tick leaves some out
                if entry.next_after(before) <= tick:
                    entry.call()
            self._keep_single()  # what was appointed just now

    def _keep_single(self) -> None:
        while self._done < len(self._ticks) and self._ticks[self._done] <= self._now:
            call = self._calls[self._done]
            self._done += 1
            call()

    def seek(self, tick: int) -> None:
        """Go to another time: what is due later is due again, what was due until then is over."""
        self._now = tick
        self._done = bisect.bisect_right(self._ticks, tick)
        self._next_periodic = tick
        for call in self.when_sought:
            call(tick)
