"""Geometric attitude law: the error of rotation matrices becomes body rates (features dossier 4.4)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.control.components import join, larger, rotation, split, sqrt
from crazychoir_fw.control.gains import ATTITUDE_GAINS, AttitudeGains, chosen_gains
from crazychoir_fw.control.strategies import AttitudeCtrlStrategy
from crazychoir_fw.messages import Pose, Reference

Array = NDArray[np.float64]

_LEAST_COSINE = 1e-6  # of the pitch: Euler angles have no rates when the nose points straight up


class GeometryAttitudeCtrl(AttitudeCtrlStrategy):
    """Turns a drone towards an attitude R_d that itself turns at w_d (zero where it is not known).

    E = (R_d' R - R' R_d) / 2, e_R = (E32, E13, E21), pqr = -k_r e_R - k_w (w - R' R_d w_d) + R' R_d w_d

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
        self._half_k_r = 0.5 * np.array(self.gains.k_r)
        self._k_w = np.array(self.gains.k_w)
        self._ahead = 1.0 + self._k_w

    def control(self, current_pose: Pose, desired_attitude: Array, desired_reference: Reference) -> Array:
        """See `AttitudeCtrlStrategy`."""
        del desired_reference
        R = rotation(np.asarray(current_pose.orientation))
        turn = np.swapaxes(desired_attitude, -1, -2) @ R
        flat = turn.reshape(*turn.shape[:-2], 9)
        _, m01, m02, m10, _, m12, m20, m21, _ = split(flat)
        rates = -self._half_k_r * join((m21 - m12, m02 - m20, m10 - m01), flat.shape[:-1])
        if current_pose.angular is not None:
            rates = rates - self._k_w * current_pose.angular
        if self.desired_rates is not None:
            seen = (np.swapaxes(turn, -1, -2) @ self.desired_rates[..., None])[..., 0]
            rates = rates + self._ahead * seen
        return _legacy(R, rates) if self.legacy else rates


def _legacy(R: Array, rates: Array) -> Array:
    """Return what the original made of body rates: entry (2, 3) is the sine of the pitch in place of the roll."""
    minus_sin_pitch, r21, r22 = split(R[..., 2, :])
    cos_pitch = larger(sqrt(r21 * r21 + r22 * r22), _LEAST_COSINE)
    sin_roll, cos_roll = r21 / cos_pitch, r22 / cos_pitch
    p, q, r = split(rates)
    turn = (sin_roll * q + cos_roll * r) / cos_pitch
    return join((p - turn * minus_sin_pitch, cos_roll * q + minus_sin_pitch * r, turn), rates.shape[:-1])
