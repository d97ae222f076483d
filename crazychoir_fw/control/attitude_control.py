"""Geometric attitude law: the error of rotation matrices becomes body rates (docs/reference/crazychoir.md#4.4)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.common.messages import Pose, Reference
from crazychoir_fw.control.gains import ATTITUDE_GAINS, AttitudeGains, chosen_gains
from crazychoir_fw.control.strategies import AttitudeCtrlStrategy
from crazychoir_fw.onboard.arrays import doubles, filled_by_core

Array = NDArray[np.float64]

_MIN_COSINE = 1e-6  # of the pitch: Euler angles have no rates when the nose points straight up


class GeometryAttitudeCtrl(AttitudeCtrlStrategy):
    """Turns a drone towards an attitude R_d that itself turns at w_d (zero where it is not known).

    E = (R_d' R - R' R_d) / 2, e_R = (E32, E13, E21), pqr = -k_r e_R - k_w (w - R' R_d w_d) + R' R_d w_d
    (``bindings/laws/attitude_error.c``)

    These are body rates, as a loop of body rates wants them. The original multiplied them with a matrix that was meant
    for rates of Euler angles and had a wrong entry; `legacy` does so too. A pose without body rates is taken for one
    at rest.
    """

    def __init__(
        self,
        update_frequency: float = 100.0,
        vicon: bool = False,
        *,
        gains: str | AttitudeGains | None = None,
        legacy: bool = False,
    ) -> None:
        """Choose gains.

        Args:
            update_frequency: How often `control` is called (Hz).
            vicon: Short for ``gains="vicon"``.
            gains: ``webots`` (default), ``vicon``, ``mujoco`` or gains of your own.
            legacy: Return the numbers of the original.

        Raises:
            UnknownNameError: If there is no such gain set.
        """
        super().__init__(update_frequency)
        self.gains = chosen_gains(type(self).__name__, ATTITUDE_GAINS, gains, vicon)
        self.legacy = legacy
        self._has_k_w = any(self.gains.k_w)

    def control(self, current_pose: Pose, desired_attitude: Array, desired_reference: Reference) -> Array:
        """See `AttitudeCtrlStrategy`."""
        del desired_reference
        orientation = np.asarray(current_pose.orientation, float)
        lead = desired_attitude.shape[:-2]
        if lead != orientation.shape[:-1]:
            lead = np.broadcast_shapes(lead, orientation.shape[:-1])  # one attitude for many poses
        angular = current_pose.angular if self._has_k_w else None
        parts = (
            doubles(orientation, (*lead, 4)),
            doubles(desired_attitude, (*lead, 3, 3)),
            ffi.NULL if angular is None else doubles(angular, (*lead, 3)),
            ffi.NULL if self.desired_rates is None else doubles(self.desired_rates, (*lead, 3)),
            self.gains.k_r,
            self.gains.k_w,
        )
        rates = np.empty((*lead, 3))
        error = ffi.new("cf_attitude_error_t *", parts)  # refers to the parts, and does not keep them
        lib.cf_attitude_rates(rates.size // 3, error, filled_by_core(rates))
        return _legacy(current_pose.rotation, rates) if self.legacy else rates


def _legacy(R: Array, rates: Array) -> Array:
    """Return what the original made of body rates: entry (2, 3) is the sine of the pitch in place of the roll."""
    minus_sin_pitch, r21, r22 = np.moveaxis(R[..., 2, :], -1, 0)
    cos_pitch = np.maximum(np.hypot(r21, r22), _MIN_COSINE)
    sin_roll, cos_roll = r21 / cos_pitch, r22 / cos_pitch
    p, q, r = np.moveaxis(rates, -1, 0)
    turn = (sin_roll * q + cos_roll * r) / cos_pitch
    return np.stack([p - turn * minus_sin_pitch, cos_roll * q + minus_sin_pitch * r, turn], axis=-1)
