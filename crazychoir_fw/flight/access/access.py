"""`Access`: what can be asked of drones of any backend; what a backend does not know is NaN, empty, or refused."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.errors import CrazychoirError, StateError, UnknownNameError
from crazychoir_fw.common.messages import Pose
from crazychoir_fw.flight.agent import DronePhase
from crazychoir_fw.onboard.descriptions import describe_variable

if TYPE_CHECKING:
    from crazychoir_fw.flight.agent import Agent
    from crazychoir_fw.mission.plan import Upload
    from crazychoir_fw.planning import Polynomial

_MAX_PROBLEMS = 5  # sentences in one message
_PLAIN_LOGS = (
    *("position.x", "position.y", "position.z", "velocity.x", "velocity.y", "velocity.z"),
    *("rates.x", "rates.y", "rates.z"),
)


@dataclass(frozen=True)
class DroneState:
    """How a drone is, for its card."""

    supervisor: str = ""
    """State of the supervisor in words."""
    battery_v: float = float("nan")
    """Voltage (V)."""
    estimate_error_m: float = float("nan")
    """Distance between estimate and truth (m); NaN where the backend has no truth."""
    link: str = ""
    """How the link is, in words."""
    failure: str = ""
    """Why it cannot fly, a sentence."""
    motors: tuple[float, ...] = ()
    """Duty of each motor, 0 to 1; empty where it is not known."""


@dataclass(frozen=True)
class Variable:
    """A parameter of a drone."""

    name: str
    type: str
    value: float | int
    read_only: bool
    default: float | int = float("nan")
    """Value right after boot; NaN where only the drone knows it."""

    def as_dict(self) -> dict[str, Any]:
        """Return it as plain data, with unit and description."""
        about = describe_variable(self.name, "parameters")
        value, default = (one if np.isfinite(one) else None for one in (self.value, self.default))
        return {"name": self.name, "type": self.type, "value": value, "read_only": self.read_only,
                "default": default, "unit": about.unit, "description": about.text}  # fmt: skip


class Access:
    """Drones that have no onboard software, as those of the integrator, or none that is reached."""

    no_rewind: str | None = None
    """Why the flight cannot be rewound, a sentence."""

    no_speed: str | None = None
    """Why time goes on as it does, whatever is asked for, a sentence."""

    where = ""
    """By which way the page knows the drones, if not by itself, in words."""

    knows_truth = True
    """Where drones are is where they are, and not what they believe."""

    has_software = False
    """There is onboard software, which is armed and rebooted."""

    flies_plans = False
    """It takes the commands of a mission without layers: `upload_plan` and `command`."""

    def __init__(self, backend: Any) -> None:
        self.backend = backend
        self.names: list[str] = list(backend.names)

    def is_slow(self, index: int) -> bool:
        """Return whether a drone's parameters arrive with a delay; do not read them between rounds then."""
        del index
        return False

    def true_pose(self) -> Pose:
        """Return the true poses, or the measured ones without a simulation, arrays of shape (N, ...)."""
        return self.backend.poses()

    def references(self) -> NDArray[np.float64] | None:
        """Return where the planners on board want the drones (m, world), shape (N, 3)."""
        return None

    def state(self, index: int) -> DroneState:
        """Return how a drone is."""
        del index
        is_seen = getattr(self.backend, "is_real_time", False)
        return DroneState("only seen" if is_seen else "integrator: a point mass without onboard software")

    def batteries(self) -> NDArray[np.float64]:
        """Return the voltages (V), shape (N,)."""
        return np.full(len(self.names), np.nan)

    def refusal(self, index: int) -> str | None:
        """Return why a drone cannot take off, a sentence, or None."""
        del index
        return None

    def missing(self) -> dict[str, str]:
        """Return why the page lacks ``arm``, ``parameters`` or ``plots``, a sentence each."""
        return {}

    def cannot_follow(self, index: int) -> str | None:
        """Return why a drone without trajectory handler cannot fly a curve, a sentence, or None."""
        return f"{self.names[index]}: a drone of this backend has no trajectory memory"

    def arm(self, index: int, is_armed: bool) -> None:
        """Arm or disarm."""
        raise StateError(f"{self.names[index]}: a drone of this backend has nothing to arm")

    def reboot(self, index: int) -> str:
        """Start the onboard software again; returns what to expect, in a few words."""
        raise StateError(f"{self.names[index]}: a drone of this backend has no software that could start again")

    def stop_now(self, indices: list[int]) -> None:
        """Stop motors at once from any thread, where a round may take long. The flight does it once more."""

    def parameters(self, index: int) -> list[Variable]:
        """Return all parameters with their values."""
        del index
        return []

    def set_parameter(self, index: int, name: str, value: float) -> float:
        """Write a parameter, and return what the drone has then."""
        raise UnknownNameError(f"{self.names[index]}: a drone of this backend has no parameters, and no '{name}'")

    def log_names(self) -> list[str]:
        """Return the names of all log variables."""
        return list(_PLAIN_LOGS)

    def log_value(self, index: int, name: str) -> float:
        """Return the value of a log variable.

        Raises:
            UnknownNameError: If there is none of that name.
        """
        if name not in _PLAIN_LOGS:
            raise UnknownNameError(f"{self.names[index]}: there is no log variable '{name}'")
        group, axis = name.split(".")
        pose = self.backend.poses()
        values = {"position": pose.position, "velocity": pose.velocity, "rates": pose.angular}[group]
        return float("nan") if values is None else float(values[index]["xyz".index(axis)])

    def console(self, index: int) -> str:
        """Return what the onboard software printed recently."""
        del index
        return ""

    def upload_plan(self, uploads: Sequence[Upload]) -> None:
        """Write the trajectories of a mission without layers into the memories of all drones."""
        raise StateError("drones of this backend take no plans")

    def command(self, index: int, verb: str, arguments: Mapping[str, Any]) -> None:
        """Give a command of a mission without layers to the planner on board, such as ``go_to``."""
        raise StateError(f"{self.names[index]}: a drone of this backend takes no plans, and no {verb}")

    def begin_upload(self, index: int, curve: Polynomial) -> None:
        """Begin to write a trajectory into the memory on board."""
        del curve
        raise StateError(f"{self.names[index]}: a drone of this backend has no trajectory memory")

    def is_uploaded(self, index: int) -> bool:
        """Return whether the trajectory is there.

        Raises:
            CrazychoirError: If it could not be written; the text says why.
        """
        del index
        return True

    def fly_uploaded(self, index: int) -> None:
        """Fly the uploaded trajectory from now on."""
        raise StateError(f"{self.names[index]}: a drone of this backend has no trajectory memory")


def reboot_all(agents: Sequence[Agent], access: Access) -> str:
    """Reboot the drones of agents; returns what to expect, in a few words.

    Raises:
        StateError: If one of them flies, and nothing is done; or if some could not be rebooted, and the others were.
    """
    for agent in agents:
        if agent.is_up:
            raise StateError(f"{agent.name} flies; LAND or STOP it before REBOOT")
    expected, problems = [], []
    for agent in agents:
        try:
            expected.append(access.reboot(agent.index))
        except CrazychoirError as error:  # the others are not to wait for this one
            problems.append(str(error))
            continue
        agent.phase, agent.failure, agent.reference = DronePhase.GROUND, None, None
    if problems:
        raise StateError("; ".join(problems[:_MAX_PROBLEMS]))
    return ", ".join(dict.fromkeys(expected))
