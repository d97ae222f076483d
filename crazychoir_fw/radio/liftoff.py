"""A drone that got a take-off command, and whether it takes off."""

from __future__ import annotations

import math
from collections.abc import Callable

_LOOK_S = 0.3  # motors turn, and the supervisor has looked


class Liftoff:
    """Checks that a drone on the floor takes off after the command, and retries the command otherwise.

    Its supervisor takes it through a reset 30 s after it became ready without flying, again and again, and 3 s after a
    landing (docs/reference/planner-commander.md#14.2, #14.5, #14.6). For some 0.1 s the planner on board refuses
    commands then; one that came a moment before is dropped, and a drone that must be armed is disarmed. No message
    tells, so that of thirty drones every eighth take-off would leave one on the floor. So the sender of the
    command looks whether it was followed, and else gives it again. It knows neither radio nor clock.

    Args:
        patience_s: How long a drone may stay on the floor (s).
    """

    def __init__(self, patience_s: float) -> None:
        self._patience_s = patience_s
        self._again: Callable[[], None] | None = None
        self._until = math.inf
        self.due = math.inf
        """When to look (s)."""
        self.has_happened = False
        """Whether the drone has been seen flying since `forget`."""

    @property
    def is_expected(self) -> bool:
        """Whether a take-off was asked for and has not been seen."""
        return self._again is not None

    def expect(self, again: Callable[[], None], now: float) -> None:
        """Expect a take-off.

        Args:
            again: Gives the command again, which is harmless where it was followed.
            now: Time of the command (s).
        """
        if self.has_happened:
            return
        self._again = again
        self.due, self._until = now + _LOOK_S, now + max(self._patience_s, _LOOK_S)

    def forget(self) -> None:
        """Clear the expectation: the drone need not fly, or stands on the floor again."""
        self._again = None
        self.due = self._until = math.inf
        self.has_happened = False

    def look(self, is_flying: bool | None, may_fly: bool, now: float) -> bool:
        """Give the command again, if it was not followed.

        Args:
            is_flying: Whether the drone flies; None when that is unknown.
            may_fly: Whether its motors may run.
            now: Time (s).

        Returns:
            False when it stays on the floor for good, as far as this goes.
        """
        if self._again is None:
            return True
        self.due = now + _LOOK_S
        if is_flying:
            self._again, self.due, self.has_happened = None, math.inf, True
        elif now >= self._until:
            self.forget()
            return is_flying is None
        elif is_flying is not None and may_fly:
            self._again()
        return True
