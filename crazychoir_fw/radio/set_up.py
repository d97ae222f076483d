"""What a drone is told after every connection, before it flies: parameters, and that earlier set-points have ended."""

from __future__ import annotations

import time
from collections.abc import Mapping

from crazychoir_fw.radio.crazyflie import LinkedCrazyflie
from crazychoir_fw.radio.parameters import ParameterValue, set_parameters
from crazychoir_fw.radio.supervisor import IS_FLYING, supervisor_bits

_RESET = "kalman.resetEstimation"
_RESET_S = 0.1  # between both writes of a reset of the estimator


def set_up(
    cf: LinkedCrazyflie,
    who: str,
    presets: Mapping[str, ParameterValue],
    own: Mapping[str, ParameterValue],
    timeout_s: float,
    *,
    resets_estimator: bool,
) -> None:
    """Write parameters; a drone that flies is not disturbed beyond that.

    Args:
        cf: A connected drone.
        who: Name and URI, for errors.
        presets: Parameters that its set-points need, where this firmware has them.
        own: Parameters of the user, which win.
        timeout_s: How long one may take (s).
        resets_estimator: Whether the Kalman filter of a drone on the floor begins anew.

    Raises:
        CrazychoirError: If there is no such parameter, a value does not fit, or the drone does not confirm.
    """
    bits = supervisor_bits(cf)
    is_flying = bits is not None and bool(bits & IS_FLYING)
    needed = {name: value for name, value in presets.items() if name not in own}
    set_parameters(cf, who, needed, timeout_s, optional=True)
    set_parameters(cf, who, own, timeout_s)
    if is_flying:
        return
    if resets_estimator:
        for value in (1, 0):
            set_parameters(cf, who, {_RESET: value}, timeout_s, optional=True)
            time.sleep(_RESET_S)
    # whatever program was connected before: its last set-point no longer keeps the planner from flying
    cf.commander.send_notify_setpoint_stop()
