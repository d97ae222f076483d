"""Swarms of Crazyflies in MuJoCo, flown by their own onboard software."""

from crazychoir_fw.version import __version__

__all__ = ["__version__"]
