"""Swarms of Crazyflies in MuJoCo, flown by their own onboard software.

Importing the package registers the engine plugin ``crazychoir.crazyflie`` with MuJoCo: from then on any MJCF file
that names it flies.
"""

from pathlib import Path

from crazychoir_fw.common.early_signals import end_at_once
from crazychoir_fw.common.version import __version__

end_at_once()  # before all that takes its time
try:
    from crazychoir_fw.onboard.core import register_plugin
except ModuleNotFoundError as error:
    if error.name != "crazychoir_fw._core":
        raise
    raise ImportError(
        f"crazychoir_fw is imported from its sources in {Path(__file__).parents[1]}, which are not built: start Python "
        "in another folder to use the installed package, or build the sources with pip install -e ."
    ) from None

register_plugin()

__all__ = ["__version__"]
