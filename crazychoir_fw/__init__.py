"""Swarms of Crazyflies in MuJoCo, flown by their own onboard software.

Importing the package registers the engine plugin ``crazychoir.crazyflie`` with MuJoCo: from then on any MJCF file
that names it flies.
"""

from crazychoir_fw.common.version import __version__
from crazychoir_fw.onboard.core import register_plugin

register_plugin()

__all__ = ["__version__"]
