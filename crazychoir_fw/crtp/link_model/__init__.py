"""How good the simulated radio is."""

from crazychoir_fw.crtp.link_model.link import Direction, Link, PerfectLink

__all__ = ["Direction", "Link", "PerfectLink"]
