"""What a pilot looks at before drones take off: one line each, good or not."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.errors import StateError
from crazychoir_fw.flight.agents import starts_of
from crazychoir_fw.flight.roll_call import NOTHING_FLIES
from crazychoir_fw.gui.radio_preflight import radio_checks
from crazychoir_fw.preflight.check import Check, check, safety_area

if TYPE_CHECKING:
    from crazychoir_fw.flight.access import Access, DroneState
    from crazychoir_fw.flight.agent import Agent
    from crazychoir_fw.gui.session import Session

LEAST_BATTERY_V = 3.7
"""Voltage at rest below which a battery does not last for a flight (V)."""
START_M = 0.3
"""Distance (m) of a drone from the start of its mission, beyond which it stands elsewhere."""
NEAR_M = 0.3
"""Distance of two drones (m), below which their take-off is unsafe."""
ESTIMATE_M = 0.1
"""Distance of an estimate from the truth (m), where the truth is known, beyond which the estimator has not settled."""


def preflight(session: Session) -> list[dict[str, Any]]:
    """Return the list, as plain data; called between two rounds of a flight that is ready."""
    if session.access is None or session.experiment is None:
        return []
    return [asdict(line) for line in _checks(session, session.access, session.experiment.agents)]


def _checks(session: Session, access: Access, agents: Sequence[Agent]) -> Iterable[Check]:
    names = session.names
    yield from radio_checks(session)
    if session.experiment is not None and hasattr(session.experiment.backend, "before_flight"):
        yield from _roll_call(session)
    states = [access.state(i) for i in range(len(names))]
    reasons = [a.failure or s.failure or access.refusal(a.index) for a, s in zip(agents, states, strict=True)]
    yield check("drones", [str(reason) for reason in reasons if reason], f"{len(names)} ready")
    yield from _onboard(names, access, states)

    position = np.asarray(access.true_pose().position)
    unknown = [names[i] for i in np.flatnonzero(~np.isfinite(position).all(axis=1))]
    yield check("positions", [f"{name} is not seen" for name in unknown], "all are known")
    yield from _places(session, position)


def _onboard(names: Sequence[str], access: Access, states: Sequence[DroneState]) -> Iterable[Check]:
    """Look at batteries and estimators, where the backend knows them."""
    voltages = access.batteries()
    if np.isfinite(voltages).any():
        low = [f"{names[i]} has {v:.2f} V" for i, v in enumerate(voltages) if v < LEAST_BATTERY_V]
        yield check("batteries", low, f"{np.nanmin(voltages):.2f} V or more")

    errors = [state.estimate_error_m for state in states]
    if np.isfinite(errors).any():
        off = [f"{names[i]} is off by {100 * e:.0f} cm" for i, e in enumerate(errors) if e > ESTIMATE_M]
        yield check("estimators", off, f"off by {100 * float(np.nanmax(errors)):.1f} cm at most")


def _roll_call(session: Session) -> Iterable[Check]:
    """Say what keeps drones over the radio on the floor, as TAKE-OFF and MISSION would."""
    try:
        session.call_roll(range(len(session.names)), settle_s=0.0)
    except StateError as error:
        yield check("roll call", [str(error).removeprefix(NOTHING_FLIES)], "")
    else:
        yield check("roll call", [], "those answer that are meant")


def _places(session: Session, position: NDArray[np.float64]) -> Iterable[Check]:
    """Compare where the drones stand with the mission, with each other, and with the safety area."""
    names, mission = session.names, session.mission
    away = np.linalg.norm((position - starts_of(mission))[:, :2], axis=1)
    elsewhere = [f"{names[i]} stands {away[i]:.2f} m from its start" for i in np.flatnonzero(away > START_M)]
    yield check("starts", elsewhere, f"within {START_M:g} m of those of the mission")

    if len(names) > 1:
        gaps = np.linalg.norm(position[:, None] - position[None], axis=2)
        gaps[np.isnan(gaps) | np.eye(len(names), dtype=bool)] = np.inf
        i, j = np.unravel_index(gaps.argmin(), gaps.shape)
        near = [f"{names[i]} and {names[j]} are {gaps[i, j]:.2f} m apart"] if gaps[i, j] < NEAR_M else []
        yield check("distances", near, f"{gaps[i, j]:.2f} m or more")

    area = mission.hardware.safety_area
    if area is not None:
        yield safety_area(area, names, position)
