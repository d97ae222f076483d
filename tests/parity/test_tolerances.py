"""The table of tolerances: complete, with reasons, and the class that a signal belongs to."""

import numpy as np
import pytest

from crazychoir_fw.parity.tolerances import FLIGHT, REPLAY, WHOLE, tolerance_of

FLOAT = np.dtype(np.float32)


@pytest.mark.parametrize("table", [REPLAY, FLIGHT])
def test_every_class_has_a_reason_and_the_last_catches_all(table):
    assert all(len(row.reason.split()) > 3 for row in table)
    assert len({row.name for row in table}) == len(table)
    assert table[-1].patterns == ("*",)


def test_every_judged_class_of_floats_allows_something():
    for row in REPLAY:
        assert row.absolute or row.ulps or row.relative, row.name


@pytest.mark.parametrize(
    ("signal", "name"),
    [
        ("estimate.position.x", "position"),
        ("log.kalman.stateX", "position"),
        ("log.kalman.statePX", "velocity"),
        ("goal.pos.z", "position"),
        ("estimate.attitude.pitch", "attitude"),
        ("estimate.attitudeQuaternion.w", "attitude, as a quaternion"),
        ("control.torqueX", "torque"),
        ("pwm.list.3", "motor in counts"),
        ("log.ctrlMel.cmd_roll", "moments in counts"),
        ("log.pid_rate.roll_outP", "other log variable"),
        ("log.pid_rate.roll_outD", "derivative"),
    ],
)
def test_class_of_a_signal(signal, name):
    assert tolerance_of(signal, FLOAT).name == name


def test_whole_numbers_that_no_class_names_must_be_equal():
    assert tolerance_of("goal.state", np.dtype(np.int32)) is WHOLE
    assert tolerance_of("log.outlierf.lhWin", np.dtype(np.int32)) is WHOLE
    assert tolerance_of("pwm.list.0", np.dtype(np.uint16)).absolute == 1


def test_flights_are_judged_by_their_motion():
    judged = [row.name for row in FLIGHT if row.is_judged]
    assert tolerance_of("true.x", FLOAT, FLIGHT).absolute == 0.01
    assert tolerance_of("stateEstimate.yaw", FLOAT, FLIGHT).turn == 360.0
    assert tolerance_of("motor.m1", np.dtype(np.uint16), FLIGHT).name not in judged
