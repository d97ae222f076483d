"""What the page asks of single drones beside the layers: state, parameters, log variables, arming, onboard memory."""

from crazychoir_fw.flight.access.access import Access, DroneState, Variable
from crazychoir_fw.flight.access.opening import open_access

__all__ = ["Access", "DroneState", "Variable", "open_access"]
