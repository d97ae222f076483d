"""Missions: a flight as a YAML file, its check, its plan, its flight and its summary."""

from crazychoir_fw.mission.loader import load_mission, parse_mission
from crazychoir_fw.mission.schema import Mission

__all__ = ["Mission", "load_mission", "parse_mission"]
