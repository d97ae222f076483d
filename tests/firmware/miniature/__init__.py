"""A miniature of bitcraze/crazyflie-firmware, laid out by tests. See layout.py."""

from miniature.forks import FORKS
from miniature.layout import RELEASES, SETUP_PY, lay_out

__all__ = ["FORKS", "RELEASES", "SETUP_PY", "lay_out"]
