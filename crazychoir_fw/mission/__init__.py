"""Missions: a flight as a YAML file, its check and its plan."""

from crazychoir_fw.mission.loader import load_mission, parse_mission
from crazychoir_fw.mission.schema import Mission

__all__ = ["Mission", "load_mission", "parse_mission"]
