"""What a flight of layers comes down to: figures of each drone and of all, criteria, and what went wrong."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from crazychoir_fw.flight.agents import guidance_of, leads, names_of
from crazychoir_fw.flight.criteria import Judge, Window
from crazychoir_fw.flight.experiment import Experiment
from crazychoir_fw.flight.formation_metrics import shape_of
from crazychoir_fw.flight.summary import Assessment, collision_failures, rounded
from crazychoir_fw.mission.schema import LayeredMission
from crazychoir_fw.mission.surveillance import surveillance_of

if TYPE_CHECKING:
    from crazychoir_fw.recording.flight_log import FlightLog


def assess_layers(
    mission: LayeredMission, experiment: Experiment, log: FlightLog, windows: Sequence[Window]
) -> Assessment:
    """Return what a flight came down to."""
    judge = Judge(log, windows, shape_of(mission))
    judge.surveillance = surveillance_of(mission)
    verdicts = judge.verdicts(mission.criteria, names_of(mission), mission.may_fail)
    failures, expected = [], []
    for agent in experiment.agents:
        if agent.failure is not None:
            (expected if agent.name in mission.may_fail else failures).append(agent.failure)
    failures += experiment.service_failures
    world = getattr(experiment.backend, "world", None)
    for name, sentence in collision_failures(mission, () if world is None else world.events):
        (expected if name in mission.may_fail else failures).append(sentence)
    failures += [verdict.sentence for verdict in verdicts if not verdict.passed]
    return Assessment(_drones(mission, experiment, judge), failures, expected, verdicts, _swarm(judge), judge)


def _drones(mission: LayeredMission, experiment: Experiment, judge: Judge) -> list[dict[str, Any]]:
    rms, largest = judge.tracking()
    figures = {
        "position_error_m": judge.position_errors(),
        "rms_error_m": rms,
        "max_error_m": largest,
        "least_distance_m": judge.least_distances(),
    }
    return [
        {
            "role": _role(mission, agent.index),
            **{key: rounded(values[agent.index]) for key, values in figures.items()},
            "phase": agent.phase.value,
        }
        for agent in experiment.agents
    ]


def _swarm(judge: Judge) -> dict[str, Any]:
    bearings = judge.final_bearing_errors()
    is_known = bearings is not None and len(bearings) > 0
    return {
        "bearing_error_deg": rounded(np.mean(bearings)) if is_known else None,
        "bearing_error_max_deg": rounded(np.max(bearings)) if is_known else None,
    }


def _role(mission: LayeredMission, i: int) -> str:
    layer = guidance_of(mission, i)
    if layer.formation is None and not layer.leaders:
        return "-"
    return "leader" if leads(mission, i) else "follower"
