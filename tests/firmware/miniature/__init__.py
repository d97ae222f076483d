"""A miniature of bitcraze/crazyflie-firmware, laid out by tests. See layout.py."""

from miniature.layout import RELEASES, SETUP_PY, lay_out

__all__ = ["RELEASES", "SETUP_PY", "lay_out"]
