"""How good the simulated radio is."""

from crazychoir_fw.crtp.link_model.config import RadioConfig
from crazychoir_fw.crtp.link_model.link import Arrival, Direction, Link, PerfectLink
from crazychoir_fw.crtp.link_model.radios import SimulatedRadios

__all__ = ["Arrival", "Direction", "Link", "PerfectLink", "RadioConfig", "SimulatedRadios"]
