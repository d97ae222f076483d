"""What a flight of layers comes down to: figures of each drone and of all, criteria, and what went wrong."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from crazychoir_fw.flight.agents import guidance_of, leads, metrics_of, names_of
from crazychoir_fw.flight.criteria import Judge, Window
from crazychoir_fw.flight.experiment import Experiment
from crazychoir_fw.flight.summary import Assessment, collision_failures, rounded
from crazychoir_fw.mission.schema import LayeredMission

if TYPE_CHECKING:
    from crazychoir_fw.recording.flight_log import FlightLog


def assess_layers(
    mission: LayeredMission, experiment: Experiment, log: FlightLog, windows: Sequence[Window]
) -> Assessment:
    """Return what a flight came down to."""
    judge = Judge(log, windows, metrics_of(mission))
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
    figures = {"bearing_error_deg": None, "bearing_error_max_deg": None, **judge.figures_of_laws()}
    return {key: None if value is None else rounded(value) for key, value in figures.items()}


def _role(mission: LayeredMission, i: int) -> str:
    layer = guidance_of(mission, i)
    if layer.formation is None and not layer.leaders:
        return "-"
    return "leader" if leads(mission, i) else "follower"
