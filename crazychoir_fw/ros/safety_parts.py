"""Nodes of a mission around controllers: with a filter inside, in front of one, or with none."""

from __future__ import annotations

from typing import Any

from crazychoir_fw.flight import agents
from crazychoir_fw.ros.controller import CrazyflieController
from crazychoir_fw.ros.neighbor_sensing import ClosestRobotGetter
from crazychoir_fw.ros.safety import (
    CollisionAvoidance,
    DesiredVelocityController,
    EveryRound,
    SafeController,
)


def make_control_node(mission: Any, *, agent_id: int, **common: Any) -> CrazyflieController:
    """Return the controller of a drone as a node."""
    layers = mission.layers
    controller = agents.make_controller(mission, agent_id)
    if layers.control.rate not in (None, layers.rate):
        controller = EveryRound(controller, layers.rate)
    kind: type[CrazyflieController] = CrazyflieController
    if layers.safety is not None:
        kind = DesiredVelocityController if layers.control.command == "vel" else SafeController
    return kind(controller=controller, agent_id=agent_id, **common)


def make_avoidance_node(mission: Any, **common: Any) -> CollisionAvoidance:
    """Return the filter behind a controller as a node: at the rate of the rounds, each of which needs an answer."""
    avoidance = agents.make_collision_avoidance(mission)
    return CollisionAvoidance(node_frequency=float(mission.layers.rate), avoidance=avoidance, **common)


def make_sensing_node(mission: Any, **common: Any) -> ClosestRobotGetter:
    """Return the node that finds the neighbors of all drones."""
    layer = mission.layers.safety
    rate = float(layer.sensing_rate or mission.layers.rate)
    return ClosestRobotGetter(layer.sensing_distance, agents=range(len(mission.fleet)), freq=rate, **common)
