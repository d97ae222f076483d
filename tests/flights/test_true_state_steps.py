"""Steps of the PID cascade with the true state in place of the estimate.

control-pid dossier section 19, "true state fed to the controller", and vehicle dossier section 14.3, whose numbers two
independent programs agree on.
"""

import numpy as np
import pytest
from test_acceptance import hovering, reference_world, rise_and_overshoot, within, yaw_deg

from crazychoir_fw._core import ffi
from crazychoir_fw.variables import log_table


class Omniscient:
    """A drone that hovers and whose filter is told the truth every millisecond."""

    def __init__(self, platform="cf2", **changes):
        self.world = reference_world(platform, supply_voltage=4.0 if platform == "cf2" else 3.8, **changes)
        self.drone = hovering(self.world, settle=10.0)
        # the vector S is the first member of the filter's core
        place = ffi.cast("char *", self.drone.struct) + log_table()["kalman.stateX"].offset
        self._core = ffi.cast("kalmanCoreData_t *", place)

    def _tell(self):
        w, x, y, z = self.drone.true_quat_wxyz
        rotation = np.array(
            [
                [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
            ]
        )
        self._core.S = [*self.drone.true_position, *(rotation.T @ self.drone.true_velocity), 0.0, 0.0, 0.0]
        self._core.q = [w, x, y, z]
        self._core.R = rotation.tolist()

    def record(self, seconds, read, command):
        """Run and return times (s) and what `read` gives at each millisecond; `command` is sent at 100 Hz."""
        values = []
        for i in range(round(seconds * 1000)):
            if i % 10 == 0:
                command()
            self._tell()
            self.world.step(1)
            values.append(read())
        return 0.001 * np.arange(1, len(values) + 1), np.array(values)

    def go(self, x=0.0, z=1.0, yaw=0.0):
        return lambda: self.drone.commander.send_position_setpoint(x, 0.0, z, yaw)

    def roll_deg(self):
        w, x, y, z = self.drone.true_quat_wxyz
        return np.degrees(np.arctan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)))


# platform: rise 10 to 90 % (s), overshoot (%). cf2: the two rows of the dossier that enclose its motors of 0.07 s
X_STEP = {"cf2": (0.829, 0.4), "cf21bl": (0.85, 0.4)}
Z_STEP = {"cf2": (0.55, 10.7), "cf21bl": (0.60, 9.5)}
YAW_STEP = {"cf2": (0.336, 3.2), "cf21bl": (0.322, 3.6)}
ROLL_STEP = {"cf2": (0.242, 5.7), "cf21bl": (0.243, 5.7)}
Z_DIP = {"cf2": 17.0, "cf21bl": 13.0}  # mm, while x steps

platforms = pytest.mark.parametrize("platform", ["cf2", "cf21bl"])


def assert_step(times, values, goal, expected, most=1.0):
    """Compare rise within 6 % and overshoot within a percent of the step."""
    rise, overshoot = rise_and_overshoot(times, values, values[0], goal)
    assert within(rise, expected[0], fraction=0.06)
    assert overshoot == pytest.approx(expected[1], abs=most)


@platforms
def test_x_step_of_one_meter_with_the_true_state(platform):
    flight = Omniscient(platform)
    flight.record(2.0, lambda: None, flight.go())
    times, track = flight.record(4.0, lambda: flight.drone.true_position, flight.go(x=1.0))
    assert_step(times, track[:, 0], 1.0, X_STEP[platform], most=0.2)
    assert 1000 * (track[0, 2] - track[:, 2].min()) == pytest.approx(Z_DIP[platform], abs=4.0)


@platforms
def test_z_step_of_half_a_meter_with_the_true_state(platform):
    flight = Omniscient(platform)
    flight.record(8.0, lambda: None, flight.go())
    times, height = flight.record(3.0, lambda: flight.drone.true_position[2], flight.go(z=1.5))
    assert_step(times, height, height[0] + 0.5, Z_STEP[platform])


@platforms
def test_yaw_step_of_45_degrees_with_the_true_state(platform):
    flight = Omniscient(platform)
    flight.record(2.0, lambda: None, flight.go())
    times, yaw = flight.record(3.0, lambda: yaw_deg(flight.drone), flight.go(yaw=45.0))
    assert_step(times, yaw, 45.0, YAW_STEP[platform])


@platforms
def test_roll_step_of_10_degrees_with_the_true_state(platform):
    flight = Omniscient(platform)
    lean = lambda roll: lambda: flight.drone.commander.send_zdistance_setpoint(roll, 0.0, 0.0, 1.0)
    flight.record(2.0, lambda: None, lean(0.0))
    times, roll = flight.record(1.2, flight.roll_deg, lean(10.0))
    assert_step(times, roll, 10.0, ROLL_STEP[platform])
