"""`RadioHandlerXYZ`: go-to by the planner on board."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.finite import finite, three
from crazychoir_fw.radio.crazyflie import LinkedCrazyflie
from crazychoir_fw.radio.drone import RadioDrone
from crazychoir_fw.radio.handler import RadioHandler
from crazychoir_fw.radio.modes import Mode
from crazychoir_fw.radio.uploads import HIGHEST_ID, checked_pieces, upload
from crazychoir_fw.radio.vel import KALMAN, POSE_DEVIATION, SELF_POSITIONED

_SAMPLES = 20  # of a piece, when it is looked whether it stays inside


class XYZDrone(RadioDrone):
    """Takes a point and a duration."""

    presets: ClassVar[Mapping[str, Any]] = {
        "commander.enHighLevel": 1,
        "stabilizer.estimator": KALMAN,
        "locSrv.extQuatStdDev": POSE_DEVIATION,
    }
    needs_position = True
    silences: ClassVar[tuple[str, ...]] = ("nothing",)

    def command(self, x: float, y: float, z: float, duration: float, yaw: float = 0.0) -> bool:
        """Fly to a point and stay there; also from the floor. The planner on board holds it without further packets.

        The first command waits until the motors may run, up to `ready_timeout_s`, arming the drone where it must be.

        Args:
            x: Along x (m, world).
            y: Along y (m, world).
            z: Height (m, world).
            duration: Time to get there (s), above 0.
            yaw: Heading at the end (rad).

        Returns:
            Whether it is taken.

        Raises:
            RangeError: If one of them is no finite number, the duration is not positive, or the point is outside of a
                safety area that refuses.
            StateError: If the motors may not run; the text says why.
        """
        who = self._call("command")
        x, y, z, duration, yaw = finite(who, x=x, y=y, z=z, duration=duration, yaw=yaw)
        if not duration > 0.0:
            raise RangeError(f"{who}: duration is {duration}, allowed: a number above 0 s")
        if self._options.safety_area is not None:
            x, y, z = self._options.safety_area.goal(who, (x, y, z))
        if self.mode is not Mode.READY or not self.is_connected:
            return False
        if not self._flight.is_ready:
            self.make_ready()

        def send(cf: LinkedCrazyflie) -> None:
            self._sender.release_if_streamed(cf)
            cf.high_level_commander.go_to(x, y, z, yaw, duration, relative=False)

        return self._flight.send_goal(send)  # it may have been stopped meanwhile

    def command_point(self, position: Sequence[float], duration: float, yaw: float = 0.0) -> bool:
        """The same for a vector (m, world), shape (3,)."""
        return self.command(*three(self._call("command_point"), "position", position), duration, yaw)

    def upload_trajectory(self, trajectory_id: int, pieces: ArrayLike, timeout_s: float = 10.0) -> float:
        """Write a trajectory into the memory on board, and wait until it is there. Not from a callback.

        It takes the place of the one before: do not call it while the drone flies one.

        Args:
            trajectory_id: 0 to 30.
            pieces: Shape (n, 33), up to 31 rows: 8 ascending coefficients of x, y, z (m, world) and yaw (rad), then
                the duration (s).
            timeout_s: How long it may take (s).

        Returns:
            Duration of the trajectory (s).

        Raises:
            RangeError: If the pieces are none, or lead out of a safety area.
            RadioError: If the drone is not connected, has no such memory, or does not confirm in time.
        """
        who = self._call("upload_trajectory")
        _check_id(who, trajectory_id)
        rows = checked_pieces(who, pieces)
        if self._options.safety_area is not None:
            self._check_inside(who, rows)
        self._sender.outbox.flush(timeout_s)  # the command that it flies now leaves first
        upload(self.cf, who, trajectory_id, rows, timeout_s)
        return float(rows[:, -1].sum())

    def start_trajectory(self, trajectory_id: int) -> bool:
        """Fly a trajectory that was uploaded, where it is in the world, from its first point on.

        Returns:
            Whether it is taken: not from the floor before the motors may run, nor after a stop or landing.

        Raises:
            RangeError: If the id is none.
        """
        _check_id(self._call("start_trajectory"), trajectory_id)
        if not (self.is_connected and self._flight.is_ready):
            return False

        def send(cf: LinkedCrazyflie) -> None:
            self._sender.release_if_streamed(cf)
            cf.high_level_commander.start_trajectory(trajectory_id)

        return self._flight.send_goal(send)

    def _check_inside(self, who: str, rows: np.ndarray) -> None:
        """See that a trajectory stays in the safety area: once it flies, it is not bent."""
        area = self._options.safety_area
        for row in rows.astype(float):
            powers = np.linspace(0.0, row[-1], _SAMPLES)[:, None] ** np.arange(8)
            for point in powers @ row[:24].reshape(3, 8).T:
                if not area.contains(point):
                    shown = ", ".join(f"{value:.2f}" for value in point)
                    raise RangeError(f"{who}: it leads to ({shown}) m, outside of the safety area {area}")


def _check_id(who: str, trajectory_id: int) -> None:
    if not (isinstance(trajectory_id, int) and 0 <= trajectory_id <= HIGHEST_ID):
        raise RangeError(f"{who}: trajectory_id is {trajectory_id!r}, allowed: 0 to {HIGHEST_ID}")


class RadioHandlerXYZ(RadioHandler):
    """Sends drones to points (m, world), which their planners on board fly to; the twin of `MotorCtrlXYZ`."""

    drone_class = XYZDrone
    defaults: ClassVar[Mapping[str, Any]] = {"on_silence": "nothing"}


class RadioHandlerXYZLightHouse(RadioHandlerXYZ):
    """`RadioHandlerXYZ` with odometry by the drones' own estimators, and without poses from outside."""

    defaults: ClassVar[Mapping[str, Any]] = {**RadioHandlerXYZ.defaults, **SELF_POSITIONED}
