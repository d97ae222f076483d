"""When the supervisor takes a drone on the floor through a reset, which no message tells.

It does so 30 s after the drone became ready without flying, again and again, and 3 s after a landing; a drone that must
be armed is disarmed then. For some 0.1 s the motors may not run and commands of the planner are refused; and a command
that the planner got just before is dropped (docs/reference/planner-commander.md#14.2, #14.5, #14.6).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from crazychoir_fw._core import lib

if TYPE_CHECKING:
    from crazychoir_fw.simulation.drone import Drone

_SUPERVISOR_TICKS = 40  # from one look of the supervisor to the next
_PASSES_THROUGH = (
    lib.supervisorStateReset,
    lib.supervisorStatePreFlChecksNotPassed,
    lib.supervisorStatePreFlChecksPassed,
)


def is_about_to_reset(drone: Drone) -> bool:
    """Tell whether the motors would have to turn earlier than they can, to be seen in flight before a reset."""
    onboard = drone.struct.onboard
    supervisor, now = onboard.supervisor, onboard.tick
    if supervisor.state == lib.supervisorStateLanded:
        return bool(now - supervisor.landing_tick > supervisor.landedTimeout - _SUPERVISOR_TICKS)
    if supervisor.state == lib.supervisorStateReadyToFly:
        return bool(now - supervisor.arming_tick > supervisor.prefltTimeout - _SUPERVISOR_TICKS)
    return False


def is_resetting(drone: Drone) -> bool:
    """Tell whether the drone is in the middle of a reset: within 0.2 s its motors may run again, or it can be armed."""
    supervisor = drone.struct.onboard.supervisor
    return supervisor.state in _PASSES_THROUGH and not supervisor.is_tumbled
