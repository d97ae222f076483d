"""One question to a provider, and its answer as signals."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw._core import lib
from crazychoir_fw.parity.inputs import FlightInputs
from crazychoir_fw.parity.side import Block, LogGatherer, Side


@dataclass(frozen=True)
class CaseRequest:
    """The side under test, and which of its log variables are to be watched."""

    side: Side
    logs: tuple[str, ...] = ()

    def boot(self, flight: FlightInputs | None = None) -> Block:
        """Return a fresh block, with the parameters that were set before that flight."""
        block = self.side.boot()
        for name, value in (flight.parameters if flight is not None else {}).items():
            if name in self.side.parameter_table:
                block.set_parameter(name, value)
        return block

    def gatherer(self, block: Block, samples: int) -> LogGatherer:
        """Return what reads the watched log variables of a block."""
        return LogGatherer(self.side, block, list(self.logs), samples)


@dataclass
class Outcome:
    """What a provider answered, sample by sample."""

    ticks: NDArray[Any]
    """What each sample is called, shape (T,): the tick of the flight (ms), or its number."""
    signals: dict[str, NDArray[Any]]
    """Each of shape (T,)."""
    failure: str | None = None
    """Why the provider gave up, as a sentence, or None."""


@dataclass(frozen=True)
class Case:
    """One question."""

    group: str
    """What is tried: ``controller``, ``power``, ``kalman``, ``complementary``, ``planner``, ``collision avoidance``."""
    name: str
    about: str
    """What the inputs are, in a few words."""
    run: Callable[[CaseRequest], Outcome]
    needs: tuple[str, ...] = ()
    """Functions of the provider's table that are called."""
    controller: str | None = None
    """Word of the controller that is needed."""
    log_groups: tuple[str, ...] = ()
    """Groups of log variables that belong to what is tried."""
    by_number: bool = field(default=False)
    """Samples are counted, they have no time."""

    def is_possible(self, side: Side) -> bool:
        """Return whether a provider has everything that is needed."""
        return side.has(*self.needs) and (self.controller is None or side.has_controller(self.controller))


def control_signals(controls: NDArray[Any]) -> dict[str, NDArray[Any]]:
    """Return the outputs of a controller in the view that its mode gives them; 0 while another mode is on."""
    mode = controls["controlMode"]
    raw = np.ascontiguousarray(controls["normalizedForces"])  # shape (T, 4), the 16 bytes that all views share
    found: dict[str, NDArray[Any]] = {"control.controlMode": mode}
    legacy = mode == lib.controlModeLegacy
    if legacy.any():
        moments = raw.view(np.int16)
        for i, name in enumerate(("roll", "pitch", "yaw")):
            found[f"control.{name}"] = np.where(legacy, moments[:, i], 0).astype(np.int16)
        found["control.thrust"] = np.where(legacy, raw[:, 2], 0).astype(np.float32)
    in_newton = mode == lib.controlModeForceTorque
    if in_newton.any():
        for i, name in enumerate(("thrustSi", "torqueX", "torqueY", "torqueZ")):
            found[f"control.{name}"] = np.where(in_newton, raw[:, i], 0).astype(np.float32)
    in_shares = (mode == lib.controlModeForce) | (mode == lib.controlModePWM)
    if in_shares.any():
        for i in range(4):
            found[f"control.normalizedForces.{i}"] = np.where(in_shares, raw[:, i], 0).astype(np.float32)
    return found


def joined(outcomes: list[Outcome]) -> Outcome:
    """Return several outcomes one after the other, with samples counted from 0; a signal that one lacks is 0 there."""
    lengths = [len(outcome.ticks) for outcome in outcomes]
    names = list(dict.fromkeys(name for outcome in outcomes for name in outcome.signals))
    dtypes = {name: values.dtype for outcome in outcomes for name, values in outcome.signals.items()}
    signals = {
        name: np.concatenate(
            [
                outcome.signals.get(name, np.zeros(length, dtypes[name]))
                for outcome, length in zip(outcomes, lengths, strict=True)
            ]
        )
        for name in names
    }
    failure = next((outcome.failure for outcome in outcomes if outcome.failure), None)
    return Outcome(np.arange(sum(lengths)), signals, failure)
