"""The high-level commander under the names of `pycffirmware`, which upstream's module does not have.

It asks the planner of the provider; what it does with the answers is that of the firmware
(docs/reference/planner-commander.md#7), with a clock that the caller sets.
"""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

_PREFIX = "crtpCommanderHighLevel"
_DEFAULT_SPEED = 0.5  # [m/s], parameters hlCommander.vtoff and vland
_EVERY = 10  # steps of the 1 kHz loop


class HighLevelCommander:
    """Take-off, landing and go-to of one drone, as setpoints.

    Heights and positions in meters, yaw in radians, durations in seconds. Commands return what the planner says: 0, or
    1 when it refuses.
    """

    firm: Any = None  # classes and functions of the provider, set by `high_level_names`

    def __init__(self) -> None:
        self.Init()

    def Init(self) -> None:
        """Start over: stopped, at the origin, at time 0."""
        self._planner = self.firm.planner()
        self.firm.plan_init(self._planner)
        self._position = self.firm.vzero()
        self._velocity = self.firm.vzero()
        self._yaw = 0.0
        self._now = 0.0

    def UpdateTime(self, t: float) -> None:
        """Set the clock [s]."""
        self._now = float(t)

    def TellState(self, state: Any) -> None:
        """Let the next plan start at an estimate."""
        self._position = self.firm.vec2svec(state.position)
        self._velocity = self.firm.vec2svec(state.velocity)
        self._yaw = math.radians(state.attitude.yaw)

    def GetSetpoint(self, setpoint: Any, state: Any, stabilizerStep: int = 0) -> bool:
        """Write the setpoint of now; returns whether there is one. Members that a plan does not name stay."""
        if stabilizerStep % _EVERY:
            return False
        firm = self.firm
        goal = firm.plan_current_goal(self._planner, self._now)
        stopped, disabled = firm.plan_is_stopped(self._planner), firm.plan_is_disabled(self._planner)
        if stopped or disabled:
            self.TellState(state)
            if stopped:
                setpoint._c[0] = firm.setpoint_t()._c[0]
            return stopped
        if not firm.is_traj_eval_valid(goal):
            firm.plan_disable(self._planner)
            return False
        self._write(setpoint, goal)
        self._position, self._velocity, self._yaw = firm.vec(goal.pos), firm.vec(goal.vel), goal.yaw
        return True

    def _write(self, setpoint: Any, goal: Any) -> None:
        firm = self.firm
        setpoint.position = firm.svec2vec(goal.pos)
        setpoint.velocity = firm.svec2vec(goal.vel)
        setpoint.acceleration = firm.svec2vec(goal.acc)
        if hasattr(firm.setpoint_t, "jerk") and hasattr(firm.traj_eval, "jerk"):
            setpoint.jerk = firm.svec2vec(goal.jerk)
        setpoint.attitude.yaw = firm.degrees(goal.yaw)
        rate = setpoint.attitudeRate
        rate.roll, rate.pitch, rate.yaw = (firm.degrees(element) for element in goal.omega)
        mode = setpoint.mode
        mode.x = mode.y = mode.z = mode.yaw = firm.modeAbs
        mode.roll = mode.pitch = mode.quat = firm.modeDisable

    def IsStopped(self) -> bool:
        """Return whether the motors shall be off."""
        return self.firm.plan_is_stopped(self._planner)

    def Disable(self) -> None:
        """Give up control."""
        self.firm.plan_disable(self._planner)

    def Stop(self) -> int:
        """Stop the motors."""
        self.firm.plan_stop(self._planner)
        return 0

    def TakeoffYaw(self, height: float, duration: float, yaw: float) -> int:
        """Rise to a height and turn to a yaw."""
        return self.firm.plan_takeoff(self._planner, self._position, self._yaw, height, yaw, duration, self._now)

    def Takeoff(self, height: float, duration: float) -> int:
        """Rise to a height."""
        return self.TakeoffYaw(height, duration, self._yaw)

    def TakeoffWithVelocity(self, height: float, velocity: float, relative: bool) -> int:
        """Rise at a speed [m/s], that of the firmware if not positive; relative: by a height."""
        goal = height + self._position.z if relative else height
        return self.Takeoff(goal, self._duration(goal, velocity))

    def LandYaw(self, height: float, duration: float, yaw: float) -> int:
        """Sink to a height and turn to a yaw; then the motors stop."""
        return self.firm.plan_land(self._planner, self._position, self._yaw, height, yaw, duration, self._now)

    def Land(self, height: float, duration: float) -> int:
        """Sink to a height; then the motors stop."""
        return self.LandYaw(height, duration, self._yaw)

    def LandWithVelocity(self, height: float, velocity: float, relative: bool) -> int:
        """Sink at a speed [m/s], that of the firmware if not positive; relative: by a height."""
        goal = self._position.z - height if relative else height
        return self.Land(goal, self._duration(goal, velocity))

    def _duration(self, height: float, velocity: float) -> float:
        return abs(height - self._position.z) / (velocity if velocity > 0 else _DEFAULT_SPEED)

    def GoTo(self, x: float, y: float, z: float, yaw: float, duration: float, relative: bool) -> int:
        """Fly to a position and yaw; relative ones count from the present goal."""
        return self.GoTo2(x, y, z, yaw, duration, relative, False)

    def GoTo2(self, x: float, y: float, z: float, yaw: float, duration: float, relative: bool, linear: bool) -> int:
        """Fly to a position and yaw; linear: at constant speed."""
        firm, goal = self.firm, self.firm.mkvec(x, y, z)
        if firm.plan_is_stopped(self._planner) or firm.plan_is_disabled(self._planner):
            start = firm.traj_eval_zero()
            start.pos, start.vel, start.yaw = self._position, self._velocity, self._yaw
            return firm.plan_go_to_from(self._planner, start, relative, linear, goal, yaw, duration, self._now)
        return firm.plan_go_to(self._planner, relative, linear, goal, yaw, duration, self._now)


def high_level_names(firm: dict[str, Any]) -> dict[str, Any]:
    """Return the class of a provider, and its methods bound to the one commander of the module."""
    cls = type("HighLevelCommander", (HighLevelCommander,), {"firm": SimpleNamespace(**firm)})
    commander = cls()
    methods = [name for name in vars(HighLevelCommander) if not name.startswith("_") and name != "firm"]
    return {"HighLevelCommander": cls} | {_PREFIX + name: getattr(commander, name) for name in methods}
