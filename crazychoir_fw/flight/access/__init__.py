"""What the page asks of single drones beside the layers: state, parameters, log variables, arming, onboard memory."""

from __future__ import annotations

from typing import Any

from crazychoir_fw.flight.access.access import Access, DroneState, Variable, reboot_all

__all__ = ["Access", "DroneState", "Variable", "open_access", "reboot_all"]


def open_access(backend: Any) -> Access:
    """Return the access to the drones of a backend."""
    if getattr(backend, "is_over_ros", False):
        from crazychoir_fw.flight.access.ros import RosAccess

        return RosAccess(backend)
    if hasattr(backend, "mirror"):
        from crazychoir_fw.flight.access.mixed import MixedAccess

        return MixedAccess(backend, open_access)
    if hasattr(backend, "world"):
        from crazychoir_fw.flight.access.sim import SimAccess

        return SimAccess(backend)
    if hasattr(backend, "handler"):
        from crazychoir_fw.flight.access.hardware import HardwareAccess

        return HardwareAccess(backend)
    return Access(backend)
